# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stability cases of the box test: edges, flat boxes, zeros of either sign, odd rays."""

from functools import partial

import meshes
import naive
import numpy as np
from differences import rebase
from numpy.typing import NDArray
from stability_tools import Case, Result, differing, embree_scene, scene_of
from stability_triangles import ASIDE

SLACK = 2.0**-18  #: by which t may be moved when clamped to the padded box of the triangle
BLOCK = 20_000  #: triangles in one scene
MOST_LONE = 200_000  #: each ray has a triangle of its own, and crosses hundreds of others


def lone_triangles(
    count: int, kind: str, spread: float, size: float, shift: float, seed: int, away: float = 0.0
):
    """Triangles strewn in a cube, and for each one ray at its edge, a vertex or its inside; from
    near by, or from `away`. Yields (corners (k, 3, 3), origins, directions) in float."""
    random = np.random.default_rng(seed)
    for first in range(0, count, BLOCK):
        k = min(BLOCK, count - first)
        corners = random.uniform(-spread, spread, (k, 1, 3)) + random.normal(0, size, (k, 3, 3))
        if kind == "flat":
            axis = random.integers(3, size=k)
            corners[np.arange(k), :, axis] = corners[np.arange(k), :1, axis]
        corners = (corners + shift * ASIDE).astype(np.float32)
        wide = corners.astype(np.float64)
        if kind == "flat":
            target = np.einsum("ki,kij->kj", random.dirichlet((2, 2, 2), k), wide)
        elif kind == "vertices":
            target = wide[:, 0]
        else:
            target = wide[:, 0] + random.uniform(size=(k, 1)) * (wide[:, 1] - wide[:, 0])
        way = random.normal(size=(k, 3))
        way *= (away or spread) / np.linalg.norm(way, axis=1, keepdims=True)
        origin = (target + way).astype(np.float32)
        yield corners, origin, (target - origin).astype(np.float32)


def farthest(corners: NDArray, origin: NDArray, direction: NDArray) -> NDArray:
    """t of the farthest corner of triangle i along the longest axis of ray i, and a little more."""
    rows = np.arange(len(origin))
    z = np.abs(direction).argmax(axis=1)
    depth = corners[rows, :, z].astype(np.float64) - origin[rows, z][:, None]
    depth /= direction[rows, z][:, None]
    return depth.max(axis=1) * (1 + SLACK)


def lost_hits(blocks: list[dict], count: int) -> Result:
    """Hits of the bare triangle test, of one triangle and one ray, that the tree loses: neither
    that triangle is reported nor another one that can lie before it."""
    lost = tried = 0
    for options in blocks:
        rays = min(count, MOST_LONE) // len(blocks)
        for corners, origins, directions in lone_triangles(rays, **options):
            scene, stats = scene_of(meshes.soup(corners), max_leaf=1)
            hits = scene.intersect(origins, directions)
            origin, direction, factor = rebase(stats, origins, directions)
            triangles = scene.triangles()
            own = triangles["triangle"]
            origin, direction = origin[own], direction[own]
            bare = naive.pairs(triangles["vertices"], origin, direction, naive.WOOP)
            meets = np.isfinite(bare)
            nearer = (hits["t"] / factor)[own] <= farthest(triangles["vertices"], origin, direction)
            lost += int((meets & ~nearer & (hits["triangle"][own] != own)).sum())
            tried += int(meets.sum())
    return Result(lost, tried)


def lost_by_box(blocks: list[dict], box: int, count: int) -> Result:
    lost = tried = 0
    for options in blocks:
        for rays in lone_triangles(count // len(blocks), **options):
            bad, hits = naive.box_losses(*rays, naive.WOOP, box)
            lost += bad
            tried += hits
    return Result(lost, tried)


NEAR = [
    dict(kind=kind, spread=1.0, size=0.2, shift=shift, seed=8)
    for kind in ("edges", "vertices")
    for shift in (0.0, 1e4)
]
MILLION = [
    dict(kind="edges", spread=5.0, size=1.0, shift=1e6, seed=9),
    dict(kind="edges", spread=50.0, size=10.0, shift=0.0, away=1e6, seed=9),
]
FLAT = [
    dict(kind="flat", spread=1.0, size=0.3, shift=0.0, seed=10),
    dict(kind="flat", spread=1.0, size=0.3, shift=1e5, seed=10),
    dict(kind="flat", spread=50.0, size=10.0, shift=0.0, away=1e6, seed=10),
]


def wall(cells: int = 32) -> meshes.Mesh:
    """A square wall at z = 0.3 of cells of two triangles each; x and y are float numbers that no
    rounding of the camera moves."""
    x, y = np.meshgrid(*[np.linspace(-1, 1, cells + 1)] * 2, indexing="ij")
    i, j = np.meshgrid(np.arange(cells), np.arange(cells), indexing="ij")
    a = (i * (cells + 1) + j).ravel()
    quads = np.stack([a, a + cells + 1, a + cells + 2, a, a + cells + 2, a + 1], axis=1)
    return meshes.pack(np.stack([x, y, np.full_like(x, 0.3)], axis=-1), quads)


def on_planes(count: int, tiny: float) -> tuple[NDArray, NDArray]:
    """Rays of doubles that fall on the wall along the planes between its cells, with x of the
    direction `tiny`, and y of it 0 or not."""
    random = np.random.default_rng(11)
    origin = np.stack(
        [
            random.integers(-15, 16, count) / 16.0,
            random.uniform(-0.9, 0.9, count).astype(np.float32),
            np.full(count, 2.0),
        ],
        axis=1,
    )
    direction = np.zeros((count, 3))
    direction[:, 0] = tiny
    direction[::2, 1] = random.uniform(-0.03, 0.03, len(direction[::2])).astype(np.float32)
    direction[:, 2] = -1.0
    return origin, direction


def planes(tinies: tuple[float, ...], count: int) -> Result:
    """Rays along the planes that go through, or whose t differs from that with a plain 0."""
    scene, _ = scene_of(wall(), max_leaf=1)
    origin, direction = on_planes(count // len(tinies), 0.0)
    straight = scene.intersect(origin, direction)
    bad = int((straight["triangle"] < 0).sum())
    for tiny in tinies:
        for packet in (1, 256):
            hits = scene.intersect(*on_planes(len(origin), tiny), packet=packet)
            bad += int((hits["t"] != straight["t"]).sum())
    return Result(bad, len(origin) * len(tinies))


def zeros(count: int) -> Result:
    """As planes, and moreover the same bits for +0 and -0."""
    scene, _ = scene_of(wall(), max_leaf=1)
    origin, direction = on_planes(count // 2, 0.0)
    minus = direction.copy()
    minus[:, :2][minus[:, :2] == 0] = -0.0
    bad = 0
    for packet in (1, 256):
        hits = [scene.intersect(origin, d, packet=packet) for d in (direction, minus)]
        bad += differing(*hits) + int((hits[0]["triangle"] < 0).sum())
    return Result(bad, 2 * len(origin))


def zeros_embree(count: int, robust: bool) -> Result:
    scene = embree_scene(wall(), robust)
    origin, direction = (r.astype(np.float32) for r in on_planes(count // 2, 0.0))
    lost = 0
    for zero in (0.0, -0.0):
        way = direction.copy()
        way[:, :2][way[:, :2] == 0] = zero
        lost += int((scene.run(origin, way) < 0).sum())
    return Result(lost, 2 * len(origin))


def planes_naive(box: int, tiny: float, count: int) -> Result:
    origin, direction = on_planes(min(count, 10_000), tiny)
    _, found = naive.trace(meshes.corners(wall()), origin, direction, naive.WOOP, box)
    return Result(int((found < 0).sum()), len(found))


def pixel_centres(count: int) -> tuple[NDArray, NDArray]:
    """An orthographic camera whose pixel centres lie on the wall's edges and diagonals."""
    side = int(count**0.5)
    at = (np.arange(side) % 127 + 1) / 64.0 - 1
    x, y = np.meshgrid(at, at, indexing="ij")
    origin = np.stack([x, y, np.full_like(x, 2.0)], axis=-1).reshape(-1, 3).astype(np.float32)
    return origin, np.tile(np.array([[0, 0, -1]], np.float32), (len(origin), 1))


def wall_holes(count: int) -> Result:
    rays = pixel_centres(count)
    lost = 0
    for cells in (1, 32):
        scene, _ = scene_of(wall(cells), max_leaf=1)
        for packet in (0, 1, 256):
            lost += int((scene.intersect(*rays, packet=packet)["triangle"] < 0).sum())
    return Result(lost, len(rays[0]))


def wall_holes_embree(count: int, robust: bool) -> Result:
    rays = pixel_centres(count)
    lost = [int((embree_scene(wall(cells), robust).run(*rays) < 0).sum()) for cells in (1, 32)]
    return Result(sum(lost), len(rays[0]))


def wall_holes_naive(count: int) -> Result:
    rays = pixel_centres(min(count, 10_000))
    _, found = naive.trace(meshes.corners(wall()), *rays, naive.WOOP, naive.FMIN_FMAX)
    return Result(int((found < 0).sum()), len(found))


def odd_rays(count: int) -> tuple[NDArray, NDArray, NDArray]:
    """Good rays with rays mixed in that cannot hit; and which are good."""
    random = np.random.default_rng(14)
    origin = random.uniform(-0.3, 0.3, (count, 3)).astype(np.float32)
    direction = random.normal(size=(count, 3)).astype(np.float32)
    good = random.uniform(size=count) < 0.5
    kind, axis = random.integers(6, size=count), random.integers(3, size=count)
    rows = np.arange(count)
    for k, value in enumerate((np.nan, np.inf, -np.inf)):
        chosen = ~good & (kind == k)
        direction[rows[chosen], axis[chosen]] = value
        chosen = ~good & (kind == 3 + k)
        origin[rows[chosen], axis[chosen]] = value
    chosen = ~good & (random.uniform(size=count) < 0.2)
    direction[chosen] = 0.0
    return origin, direction, good


def odd(count: int) -> Result:
    origin, direction, good = odd_rays(count)
    scene, _ = scene_of(meshes.icosphere(3))
    alone = scene.intersect(origin[good], direction[good], packet=1)
    bad = 0
    for packet in (1, 256):
        hits = scene.intersect(origin, direction, packet=packet)
        bad += differing({k: v[good] for k, v in hits.items()}, alone)
        bad += int((hits["triangle"][~good] >= 0).sum() + np.isfinite(hits["t"][~good]).sum())
        blocked = scene.occluded(origin, direction, packet=packet)
        bad += int(blocked[~good].sum() + (~blocked[good]).sum())
    return Result(bad, count)


def odd_naive(count: int) -> Result:
    origin, direction, good = odd_rays(min(count, 20_000))
    corners = meshes.corners(meshes.icosphere(3))
    _, found = naive.trace(corners, origin[~good], direction[~good], naive.MOLLER_LOOSE)
    return Result(int((found >= 0).sum()), len(found))


def from_boxes(count: int):
    """One large triangle, and rays that start inside its box or on a face of it and hit it."""
    random = np.random.default_rng(15)
    corners = np.array([[[-1, -1, -1], [1, -0.5, 0.8], [-0.6, 1, 0.7]]], np.float32)
    wide = corners[0].astype(np.float64)
    low, high = wide.min(axis=0), wide.max(axis=0)
    origin = random.uniform(low, high, (count, 3))
    axis, top = random.integers(3, size=count), random.integers(2, size=count)
    on_face = np.arange(count) % 2 == 0
    face = np.where(top, high[axis], low[axis])
    origin[np.arange(count)[on_face], axis[on_face]] = face[on_face]
    origin = origin.astype(np.float32)
    target = random.dirichlet((2, 2, 2), count) @ wide
    direction = (target - origin).astype(np.float32)
    normal = np.cross(wide[1] - wide[0], wide[2] - wide[0])
    off = np.abs((origin - wide[0]) @ normal) > 1e-3
    return corners, origin[off], direction[off]


def starts(count: int) -> Result:
    corners, origin, direction = from_boxes(count)
    scene, _ = scene_of(meshes.soup(corners))
    lost = [
        int((scene.intersect(origin, direction, packet=p)["triangle"] < 0).sum()) for p in (1, 256)
    ]
    return Result(max(lost), len(origin))


def starts_embree(count: int, robust: bool) -> Result:
    corners, origin, direction = from_boxes(count)
    found = embree_scene(meshes.soup(corners), robust).run(origin, direction)
    return Result(int((found < 0).sum()), len(origin))


def starts_naive(count: int) -> Result:
    rays = from_boxes(count)
    _, found = naive.trace(*rays, naive.WOOP, naive.ENTRY_IN_FRONT)
    return Result(int((found < 0).sum()), len(found))


CASES = [
    Case(
        "8",
        "lone triangles, rays at their edges and vertices, moved by 0 and 1e4",
        "the tree finds what the bare triangle test hits",
        partial(lost_hits, NEAR),
        partial(lost_by_box, NEAR, naive.UNPADDED),
        "box test without padding",
    ),
    Case(
        "9",
        "the same moved by 1e6, and seen from 1e6 away",
        "as 8",
        partial(lost_hits, MILLION),
        partial(lost_by_box, MILLION[:1], naive.FUSED),
        "box test b/d - o/d with a fused multiply-add",
    ),
    Case(
        "10",
        "axis-aligned triangles (flat boxes), moved by 0 and 1e5, and from 1e6 away",
        "as 8",
        partial(lost_hits, FLAT),
        partial(lost_by_box, FLAT[1:2], naive.FUSED),
        "box test b/d - o/d with a fused multiply-add",
    ),
    Case(
        "11",
        "wall of abutting cells, rays in the planes between them, +0 and -0",
        "a hit, and the same bits for both zeros",
        zeros,
        partial(planes_naive, naive.FMIN_FMAX, 0.0),
        "box test sorted by fmin and fmax",
        zeros_embree,
    ),
    Case(
        "12",
        "orthographic camera, pixel centres on edges and diagonals of a wall",
        "no hole",
        wall_holes,
        wall_holes_naive,
        "box test sorted by fmin and fmax",
        wall_holes_embree,
    ),
    Case(
        "13",
        "as 11, with 1e-40 and 1e-30 instead of 0",
        "the same t as with 0",
        partial(planes, (1e-40, -1e-40, 1e-30, -1e-30)),
        partial(planes_naive, naive.COMPARE_SORT, 1e-40),
        "box test sorted by a < b ? a : b",
    ),
    Case(
        "14",
        "directions of 0, NaN or infinity and such origins, among good rays",
        "no hit, and the good rays keep their bits",
        odd,
        odd_naive,
        "Moeller-Trumbore by rejections, which NaN passes",
    ),
    Case(
        "15",
        "rays that start inside a leaf's box or on its face",
        "the triangle is hit",
        starts,
        starts_naive,
        "box test that wants the entry ahead of the origin",
        starts_embree,
    ),
]
