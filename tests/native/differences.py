# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sorts every difference between two tracers by its cause, with stated bounds.

In the sheared plane of a ray (Woop, Benthin, Wald 2013) a vertex at distance R from the origin is
known to about 4 rounding errors of R, and an edge function adds as much again. So a float tracer
may move an edge by `EDGE` roundings of R where it passes near the ray. An edge function is off by
as much times the distance of its two vertices from the ray, which shifts the weights of the
vertices' depths, and so t: much on needles and at grazing angles, but never out of the triangle.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

ROUNDING = 2.0**-24
EDGE = 16.0  #: roundings of the farthest vertex by which an edge may move: Whittle's test
EDGE_EMBREE = 64.0  #: and Embree's, which starts from absolute coordinates
CLASSES = ("same", "grazing_t", "tie", "silhouette", "unexplained")


@dataclass
class Near:
    """How triangles lie to rays, exactly enough: all in the sheared plane, in double."""

    outside: NDArray  # distance of the ray to the triangle, 0 inside
    edge: NDArray  # distance of the ray to its nearest edge
    reach: NDArray  # how far its edges may move
    t: NDArray  # where the ray meets its plane
    t_bound: NDArray  # by how much t may be off


def rebase(stats: dict, origins: NDArray, directions: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """The rays as the core holds them: float origins, float directions of about unit size, and
    the factor from its t to the caller's."""
    shift = np.asarray(stats["center"])
    with np.errstate(over="ignore"):
        origin = np.ldexp(origins.astype(np.float64) - shift, -stats["exponent"]).astype(np.float32)
    wide = directions.astype(np.float64)
    exponent = np.frexp(np.abs(wide).max(axis=1))[1] - 1
    direction = np.ldexp(wide, -exponent[:, None]).astype(np.float32)
    return origin, direction, np.ldexp(1.0, stats["exponent"] - exponent)


def _segment_distance(a: NDArray, b: NDArray) -> NDArray:
    """Distance of the plane's origin to segments from a to b, (k, 2) each."""
    along = b - a
    length = np.einsum("ki,ki->k", along, along)
    with np.errstate(all="ignore"):
        part = np.clip(-np.einsum("ki,ki->k", a, along) / length, 0, 1)
    part = np.where(length > 0, part, 0.0)
    return np.linalg.norm(a + part[:, None] * along, axis=1)


def locate(vertices: NDArray, origin: NDArray, direction: NDArray, edge_roundings: float) -> Near:
    """Row by row: triangle (k, 3, 3) against ray, all in the same space."""
    rows = np.arange(len(origin))
    z = np.abs(direction).argmax(axis=1)
    x, y = (z + 1) % 3, (z + 2) % 3
    wide = vertices.astype(np.float64) - origin.astype(np.float64)[:, None, :]
    d = direction.astype(np.float64)
    depth = wide[rows, :, z]
    flat = np.stack(
        [wide[rows, :, k] - (d[rows, k] / d[rows, z])[:, None] * depth for k in (x, y)], axis=2
    )
    reach = edge_roundings * ROUNDING * np.abs(wide).max(axis=(1, 2))
    edge = np.min([_segment_distance(flat[:, i], flat[:, (i + 1) % 3]) for i in range(3)], axis=0)
    weight = np.stack(
        [
            flat[:, (i + 1) % 3, 0] * flat[:, (i + 2) % 3, 1]
            - flat[:, (i + 1) % 3, 1] * flat[:, (i + 2) % 3, 0]
            for i in range(3)
        ],
        axis=1,
    )
    total = weight.sum(axis=1)
    inside = (weight >= 0).all(axis=1) | (weight <= 0).all(axis=1)
    low, high = depth.min(axis=1), depth.max(axis=1)
    with np.errstate(all="ignore"):
        at = np.einsum("ki,ki->k", weight, depth) / total
        at = np.where(np.isfinite(at), np.clip(at, low, high), 0.5 * (low + high))
        size = np.linalg.norm(flat, axis=2)
        lever = np.abs(depth - at[:, None]) * (
            np.roll(size, -1, axis=1) + np.roll(size, -2, axis=1)
        )
        most = reach * lever.sum(axis=1) / np.abs(total)
    most = np.minimum(np.where(np.isfinite(most), most, np.inf), high - low)
    bound = most + 16 * ROUNDING * np.abs(depth).max(axis=1)
    per_t = 1.0 / np.abs(d[rows, z])
    return Near(np.where(inside, 0.0, edge), edge, reach, at / d[rows, z], bound * per_t)


def classify(
    corners: NDArray,
    origin: NDArray,
    direction: NDArray,
    ours: tuple[NDArray, NDArray],
    theirs: tuple[NDArray, NDArray],
    edge_roundings: float = EDGE,
) -> dict[str, int]:
    """Counts by class. `ours` and `theirs` are (t, row of `corners` or -1) of each ray, t in the
    units of `direction`; `theirs` is the reference."""
    counts = dict.fromkeys(CLASSES, 0)
    (t, hit), (t_ref, hit_ref) = ours, theirs
    with np.errstate(invalid="ignore"):
        close = (hit == hit_ref) & (
            (hit < 0) | (np.abs(t - t_ref) <= 16 * ROUNDING * np.abs(t_ref))
        )
    counts["same"] = int(close.sum())
    rows = np.flatnonzero(~close)
    if len(rows) == 0:
        return counts

    def near(hits: NDArray) -> Near:
        return locate(corners[np.maximum(hits, 0)], origin[rows], direction[rows], edge_roundings)

    t, hit, t_ref, hit_ref = t[rows], hit[rows], t_ref[rows], hit_ref[rows]
    own, other = near(hit), near(hit_ref)
    valid = (hit < 0) | ((own.outside <= own.reach) & (np.abs(t - own.t) <= own.t_bound))
    both = (hit >= 0) & (hit_ref >= 0)
    same_t = np.abs(own.t - other.t) <= own.t_bound + other.t_bound
    nearer_is_ours = (hit_ref < 0) | ((hit >= 0) & (own.t < other.t))
    edge = np.where(nearer_is_ours, own.edge <= own.reach, other.edge <= other.reach)
    grazing = valid & both & (hit == hit_ref)
    tie = valid & both & ~grazing & same_t
    silhouette = valid & ~grazing & ~tie & edge & (hit != hit_ref)
    counts["grazing_t"] = int(grazing.sum())
    counts["tie"] = int(tie.sum())
    counts["silhouette"] = int(silhouette.sum())
    counts["unexplained"] = len(rows) - int((grazing | tie | silhouette).sum())
    return counts


def rows_of(scene, hits: dict[str, NDArray]) -> NDArray[np.int64]:
    """Index into scene.triangles() of each hit, -1 for a miss."""
    triangles = scene.triangles()
    key = triangles["instance"].astype(np.int64) << 32 | triangles["triangle"].astype(np.int64)
    order = np.argsort(key)
    wanted = hits["instance"].astype(np.int64) << 32 | hits["triangle"].astype(np.int64)
    missed = hits["triangle"] < 0
    if len(order) == 0:
        assert missed.all()
        return np.full(len(wanted), -1)
    at = order[np.searchsorted(key[order], wanted).clip(0, len(order) - 1)]
    assert (missed | (key[at] == wanted)).all(), "a hit names a triangle that is not in the tree"
    return np.where(missed, -1, at)


def against_oracle(
    scene, stats: dict, origins: NDArray, directions: NDArray, hits: dict | None = None
) -> dict[str, int]:
    """Classes of the differences of `hits` (default: the scene's own) from the oracle's."""
    hits = scene.intersect(origins, directions) if hits is None else hits
    truth = scene.reference_intersect(origins, directions)
    origin, direction, factor = rebase(stats, origins, directions)
    corners = scene.triangles()["vertices"]
    if len(corners) == 0:
        corners = np.zeros((1, 3, 3), np.float32)
    ours = hits["t"] / factor, rows_of(scene, hits)
    theirs = truth["t"] / factor, rows_of(scene, truth)
    return classify(corners, origin, direction, ours, theirs)
