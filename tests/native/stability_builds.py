# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stability cases of the builder: coinciding, nested, huge, tiny and broken triangles."""

from collections.abc import Callable, Iterator
from functools import partial

import aim
import meshes
import naive
import numpy as np
import whittle_core
from differences import against_oracle
from meshes import Mesh
from numpy.typing import NDArray
from stability_tools import Case, Result, scene_of
from stability_triangles import ASIDE

MAX_LEAF = 8
DEEPEST = 64  #: the depth cap of the builder
Matrices = list[NDArray] | None


def tree_faults(scene: whittle_core.Scene, stats: dict) -> list[str]:
    """What is wrong with a tree, as words; an empty list if nothing is."""
    nodes, triangles = scene.nodes(), scene.triangles()
    count = len(triangles["instance"])
    if count == 0:
        return [] if len(nodes) == 0 else ["nodes without triangles"]
    faults = []
    leaf = nodes["count"] > 0
    first = nodes["left_first"].astype(np.int64)
    low, high = nodes["bounds_min"], nodes["bounds_max"]
    covered = np.zeros(count, int)
    for start, length in zip(first[leaf], nodes["count"][leaf].astype(np.int64), strict=True):
        covered[start : start + length] += 1
    if not (covered == 1).all():
        faults.append("a triangle is not in exactly one leaf")
    if len(nodes) > 2 * count - 1:
        faults.append("more than 2N - 1 nodes")
    if nodes["count"].max() > MAX_LEAF or stats["largest_leaf"] > MAX_LEAF:
        faults.append(f"a leaf of {nodes['count'].max()} triangles")
    if stats["depth"] > DEEPEST:
        faults.append(f"depth {stats['depth']}")
    if not (np.isfinite(low).all() and np.isfinite(high).all() and (low <= high).all()):
        faults.append("bounds that are not finite or not ordered")
    for side in (0, 1):
        child = first[~leaf] + side
        if (low[child] < low[~leaf]).any() or (high[child] > high[~leaf]).any():
            faults.append("a child reaches out of its parent")
    corners = triangles["vertices"]
    owner = np.repeat(np.flatnonzero(leaf), nodes["count"][leaf])
    order = np.concatenate(
        [np.arange(f, f + n) for f, n in zip(first[leaf], nodes["count"][leaf], strict=True)]
    )
    if (corners[order].min(axis=1) < low[owner]).any() or (
        corners[order].max(axis=1) > high[owner]
    ).any():
        faults.append("a triangle reaches out of its leaf")
    return faults


def check(scene: whittle_core.Scene, stats: dict, mesh: Mesh, matrix: NDArray, rays: int) -> Result:
    """A tree's faults, and its hits against the oracle's."""
    faults = tree_faults(scene, stats)
    with np.errstate(all="ignore"):
        world = meshes.corners(mesh).astype(np.float64)
        world = world[np.isfinite(world).all(axis=(1, 2))] @ matrix[:3, :3].T + matrix[:3, 3]
    if len(world) == 0:
        origin = np.random.default_rng(0).normal(size=(rays, 3))
        missed = scene.intersect(origin, -origin)["triangle"] < 0
        return Result(len(faults) + int((~missed).sum()), rays, "; ".join(faults))
    origin, direction = aimed(world, rays)
    classes = against_oracle(scene, stats, origin, direction)
    hits = rays - int((scene.intersect(origin, direction)["triangle"] < 0).sum())
    note = "; ".join([*faults, f"{hits * 100 // rays} % hit"])
    return Result(len(faults) + classes["unexplained"], rays, note)


def aimed(corners: NDArray, count: int) -> tuple[NDArray, NDArray]:
    """Rays of doubles at points inside triangles, from distances like the triangles' sizes."""
    random = np.random.default_rng(5)
    chosen = corners[random.integers(len(corners), size=count)]
    target = np.einsum("ki,kij->kj", random.dirichlet((1, 1, 1), count), chosen)
    size = np.ptp(chosen, axis=1).max(axis=1, keepdims=True)
    way = random.normal(size=(count, 3)) * size * random.uniform(0.5, 4, (count, 1))
    return target + way, -way


Variant = tuple[Mesh, NDArray]


def built(variants: Callable[[], Iterator[Variant]], count: int) -> Result:
    """Builds and checks each variant with some of the rays."""
    found = []
    for mesh, matrix in variants():
        scene, stats = scene_of(mesh, matrices=[matrix])
        found.append(check(scene, stats, mesh, matrix, max(min(count, 200_000) // 100, 256)))
    notes = sorted({f.note for f in found if f.note})
    return Result(sum(f.failures for f in found), sum(f.tried for f in found), " / ".join(notes))


def built_naive(
    variants: Callable[[], Iterator[Variant]], fault: str, least: int, midpoint: bool, count: int
) -> Result:
    """How many of the variants show the fault: a number of naive_build's that exceeds `least`."""
    seen = []
    for mesh, matrix in variants():
        world = meshes.corners(mesh).astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        with np.errstate(over="ignore"):
            seen.append(naive.build(world.astype(np.float32), midpoint)[fault])
    words = fault.replace("_", " ")
    return Result(sum(s > least for s in seen), len(seen), f"{words} up to {max(seen):,}")


def identical() -> Iterator[Variant]:
    one = np.array([[[0, 0, 0], [1, 0.2, 0.1], [0.3, 1, 0.4]]])
    yield meshes.soup(np.tile(one, (100_000, 1, 1))), np.eye(4)


def concentric() -> Iterator[Variant]:
    one = np.array([[-1, -1, -0.5], [1, -1, 0.5], [-1, 1, 0.5], [1, 1, -0.5]])
    size = np.linspace(1, 3, 1000)[:, None, None]
    yield meshes.soup(np.concatenate([one[:3] * size, one[1:] * size])), np.eye(4)


def geometric() -> Iterator[Variant]:
    at = 2.0 ** np.arange(-60, 60)
    one = np.array([[0, 0, 0], [0.3, 0.5, 0], [0.3, 0, 0.5]])
    place = np.zeros((120, 1, 3))
    place[:, 0, 0] = at
    yield meshes.soup(place + one * at[:, None, None]), np.eye(4)


def nested() -> Iterator[Variant]:
    size = 2.0 ** (0.4 * np.arange(250))
    one = np.array([[0, 0, 0], [1, 0.1, 0], [0.1, 1, 0.3]])
    yield meshes.soup(one * size[:, None, None]), np.eye(4)


def far_unit() -> Iterator[Variant]:
    for shift in (1e6, 1e8):
        yield meshes.icosphere(4, 1.0, shift * ASIDE), np.eye(4)
        yield meshes.icosphere(4), meshes.transform(1.0, shift * ASIDE)


def thin_axis() -> Iterator[Variant]:
    positions, triangles = meshes.icosphere(3)
    for axis in range(3):
        flat = positions.copy()
        flat[:, axis] *= np.float32(1e-40)
        yield (flat, triangles), np.eye(4)


def huge() -> Iterator[Variant]:
    for size in (1e18, 1e25, 1e30, 1e38):
        yield meshes.icosphere(3, size), np.eye(4)


def tiny() -> Iterator[Variant]:
    for size in (1e-19, 1e-21, 1e-23, 1e-30):
        yield meshes.icosphere(3, size), np.eye(4)


def largest() -> Iterator[Variant]:
    yield meshes.icosphere(3, 1.0), meshes.transform(3e38)
    positions, triangles = meshes.random_triangles(500, 0.3, 36)
    place = np.clip(positions, -1, 1) * np.float32(3e38)
    yield (place, triangles), np.eye(4)


def few() -> Iterator[Variant]:
    some = meshes.random_triangles(3, 0.5, 40)
    for count in range(4):
        yield (some[0], some[1][:count]), np.eye(4)
    for way in ((1.0, 0.0, 0.0), (1.0, 2.0, 3.0)):
        line = np.linspace(0, 1, 300)[:, None] * np.array(way)
        yield meshes.soup(line.reshape(-1, 3, 3)), np.eye(4)
    flat = meshes.random_triangles(500, 0.2, 41)
    flat[0][:, 1] = 0.125
    yield flat, np.eye(4)


def broken_mesh() -> tuple[Mesh, Mesh, NDArray]:
    """(a sphere, the sphere with broken triangles between its own, indices of its own)."""
    sphere = meshes.icosphere(3)
    random = np.random.default_rng(37)
    bad = meshes.corners(sphere)[random.integers(1280, size=640)].copy()
    rows = np.arange(640)
    bad[rows, random.integers(3, size=640), random.integers(3, size=640)] = np.array(
        [np.nan, np.inf, -np.inf], np.float32
    )[rows % 3]
    corners = np.concatenate([meshes.corners(sphere), bad])
    order = random.permutation(len(corners))
    own = np.empty(1280, int)
    position = np.argsort(order)
    own[:] = position[:1280]
    return meshes.soup(meshes.corners(sphere)), meshes.soup(corners[order]), own


def broken(count: int) -> Result:
    clean, dirty, own = broken_mesh()
    rays = aim.from_around(clean, "edges", count)
    scene, stats = scene_of(dirty)
    want, got = scene_of(clean)[0].intersect(*rays), scene.intersect(*rays)
    named = np.where(want["triangle"] >= 0, own[want["triangle"]], -1)
    t_differs = want["t"].view(np.uint32) != got["t"].view(np.uint32)
    corners = meshes.corners(clean)
    hit = (named >= 0) & (got["triangle"] >= 0)
    back = np.full(len(dirty[1]), -1)
    back[own] = np.arange(1280)
    tie = hit & (named != got["triangle"]) & ~t_differs & (back[got["triangle"]] >= 0)
    shares = np.zeros(len(named), bool)
    pair = corners[want["triangle"][tie]][:, :, None], corners[back[got["triangle"][tie]]][:, None]
    shares[tie] = ((pair[0] == pair[1]).all(axis=3)).any(axis=(1, 2))
    other = (named != got["triangle"]) & ~shares
    wrong_count = stats["dropped_non_finite"] != 640
    return Result(
        int((t_differs | other).sum()) + wrong_count,
        count,
        f"{stats['dropped_non_finite']:,} dropped",
    )


def broken_naive(count: int) -> Result:
    """Boxes around eight triangles each, grown by compares that let NaN in."""
    clean, dirty, _ = broken_mesh()
    rays = aim.from_around(clean, "edges", min(count, 20_000))
    right, _ = naive.trace(meshes.corners(clean), *rays, naive.WOOP)
    wrong, _ = naive.trace(meshes.corners(dirty), *rays, naive.WOOP, naive.PADDED, group=8)
    return Result(int((np.isinf(wrong) & np.isfinite(right)).sum()), len(right))


SOUND = "the tree is sound, no leaf above 8, depth at most 64; hits are the oracle's"


def build_case(
    number: str,
    builds: str,
    variants: Callable[[], Iterator[Variant]],
    fault: str,
    least: int,
    culprit: str,
    *,
    midpoint: bool = False,
) -> Case:
    return Case(
        number,
        builds,
        SOUND,
        partial(built, variants),
        partial(built_naive, variants, fault, least, midpoint),
        culprit,
        rate=False,
    )


SAH = "binned builder in plain float without a fallback"
HALVES = "split of boxes in halves"
CASES = [
    build_case("28", "100,000 identical triangles", identical, "largest_leaf", MAX_LEAF, SAH),
    build_case(
        "29", "2,000 triangles about one centroid", concentric, "largest_leaf", MAX_LEAF, SAH
    ),
    build_case(
        "30", "triangles at x = 2^i, i = -60 to 59", geometric, "depth", 64, HALVES, midpoint=True
    ),
    build_case(
        "31", "250 nested triangles of sizes 2^(0.4 i)", nested, "depth", 64, HALVES, midpoint=True
    ),
    build_case(
        "32",
        "unit sphere at 1e6 and 1e8, by vertices and by transform",
        far_unit,
        "largest_leaf",
        MAX_LEAF,
        SAH,
    ),
    build_case("33", "sphere with one axis of 1e-40", thin_axis, "bad_bins", 0, SAH),
    build_case("34", "spheres of radius 1e18 to 1e38", huge, "bad_costs", 0, SAH),
    build_case("35", "spheres of radius 1e-19 to 1e-30", tiny, "largest_leaf", MAX_LEAF, SAH),
    build_case("36", "bounds of 3e38", largest, "bad_costs", 0, SAH),
    Case(
        "37",
        "vertices of NaN and infinity between good ones",
        "dropped and counted; the rest gives the same bits",
        broken,
        broken_naive,
        "boxes grown by compares that let NaN in",
    ),
    build_case(
        "40", "0 to 3 triangles, all on a line, all in a plane", few, "largest_leaf", MAX_LEAF, SAH
    ),
]
