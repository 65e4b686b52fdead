# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stability cases of the triangle test: closed meshes seen from inside, shared edges, needles."""

from functools import partial

import aim
import meshes
import naive
import numpy as np
import whittle_core
from differences import classify, rebase, rows_of
from stability_tools import Case, Result, embree_misses, misses, scene_of

ASIDE = np.array([1.0, 0.7, -0.4])  #: the way in which meshes are moved
NAIVE_RAYS = 40_000  #: of brute force


def inside(kind: str, count: int, radius: float, shift: float, eyes: int = 16):
    """An icosphere and rays from some points inside it at points on its edges or vertices."""
    mesh = meshes.icosphere(3, radius, shift * ASIDE)
    random = np.random.default_rng(1)
    rays = [
        aim.from_point(
            mesh, kind, count // eyes, shift * ASIDE + radius * random.uniform(-0.4, 0.4, 3), seed
        )
        for seed in range(eyes)
    ]
    return mesh, (np.concatenate([o for o, _ in rays]), np.concatenate([d for _, d in rays]))


def escapes(places: list[tuple[str, float, float]], count: int) -> Result:
    """Rays that leave closed meshes given by (kind of aim, radius, shift)."""
    found = [misses(*inside(kind, count // len(places), r, s)) for kind, r, s in places]
    return Result(sum(f.failures for f in found), sum(f.tried for f in found))


def escapes_embree(places: list[tuple[str, float, float]], count: int, robust: bool) -> Result:
    found = [
        embree_misses(*inside(kind, count // len(places), r, s), robust) for kind, r, s in places
    ]
    return Result(sum(f.failures for f in found), sum(f.tried for f in found))


def escapes_naive(test: int, places: list[tuple[str, float, float]], count: int) -> Result:
    lost = tried = 0
    for kind, radius, shift in places:
        mesh, rays = inside(kind, min(count, NAIVE_RAYS) // len(places), radius, shift)
        _, found = naive.trace(meshes.corners(mesh), *rays, test)
        lost += int((found < 0).sum())
        tried += len(found)
    return Result(lost, tried)


def closed(number: str, builds: str, places: list, test: int, culprit: str) -> Case:
    return Case(
        number,
        builds,
        "no ray escapes",
        partial(escapes, places),
        partial(escapes_naive, test, places),
        culprit,
        partial(escapes_embree, places),
    )


def shared_edges(count: int, quads: int = 100):
    """Scenes of two triangles on either side of an edge, and rays at that edge: a generator of
    (scene, rays). The left triangle is seen by camera rays, the right one by shadow rays."""
    random = np.random.default_rng(6)
    for _ in range(quads):
        a, b = random.normal(size=(2, 3))
        along = (b - a) / np.linalg.norm(b - a)
        side = np.cross(along, random.normal(size=3))
        side /= np.linalg.norm(side)
        normal = np.cross(along, side)
        middle = a + random.uniform(0.1, 0.9) * (b - a)
        c = middle + random.uniform(0.2, 2) * side + 0.2 * random.normal() * normal
        d = middle - random.uniform(0.2, 2) * side + 0.2 * random.normal() * normal
        scene = whittle_core.Scene()
        for corners, seen in (((a, b, c), whittle_core.CAMERA), ((b, a, d), whittle_core.SHADOW)):
            mesh = scene.add_mesh(*meshes.soup(np.array([corners])))
            scene.add_instance(mesh, np.eye(4), visibility=seen)
        scene.build()
        rays = count // quads
        ends = np.array([a, b]).astype(np.float32).astype(np.float64)
        target = ends[0] + random.uniform(0.01, 0.99, (rays, 1)) * (ends[1] - ends[0])
        way = normal + random.uniform(-1, 1, (rays, 1)) * along + random.uniform(-0.3, 0.3) * side
        origin = (target + random.uniform(1, 5, (rays, 1)) * way).astype(np.float32)
        yield scene, origin, (target - origin).astype(np.float32)


def shared_edge_signs(count: int) -> Result:
    """Rays for which the two triangles at an edge do not see it from opposite sides: neither is
    hit, or both are and neither reports a weight of exactly 0 for the vertex off the edge."""
    bad = tried = 0
    for scene, origin, direction in shared_edges(10 * count):
        left = scene.intersect(origin, direction, visibility=whittle_core.CAMERA)
        right = scene.intersect(origin, direction, visibility=whittle_core.SHADOW)
        hit_left, hit_right = left["triangle"] >= 0, right["triangle"] >= 0
        both = hit_left & hit_right & ((left["v"] != 0) | (right["v"] != 0))
        bad += int((both | ~(hit_left | hit_right)).sum())
        tried += len(origin)
    return Result(bad, tried)


def shared_edge_signs_naive(count: int) -> Result:
    random = np.random.default_rng(6)
    a = random.uniform(-1, 1, (min(count, 1_000_000), 2)).astype(np.float32)
    b = (
        a * random.uniform(0.5, 2, (len(a), 1)) * (1 + random.uniform(-3e-7, 3e-7, a.shape))
    ).astype(np.float32)
    assert naive.edge_asymmetry(a, b, fused=False) == 0
    return Result(naive.edge_asymmetry(a, b, fused=True), len(a))


def zero_area_mesh() -> tuple[meshes.Mesh, meshes.Mesh, int]:
    """(a sphere, the sphere with points and lines thrown in, how many of those)."""
    sphere = meshes.icosphere(3)
    positions, triangles = sphere
    random = np.random.default_rng(38)
    a, b = random.integers(len(positions), size=(2, 2000)).astype(np.uint32)
    lines = np.stack([a, b, np.where(np.arange(2000) % 3 == 0, a, b)], axis=1)
    return sphere, (positions, np.concatenate([triangles, lines])), len(lines)


def zero_area(count: int) -> Result:
    clean, dirty, extra = zero_area_mesh()
    _, rays = inside("vertices", count, 1.0, 0.0)
    scene, stats = scene_of(dirty)
    want, got = scene_of(clean)[0].intersect(*rays), scene.intersect(*rays)
    bad = (want["t"] != got["t"]) | (want["triangle"] != got["triangle"])
    wrong_count = stats["dropped_zero_area"] != extra
    return Result(int(bad.sum()) + wrong_count, len(bad), f"{stats['dropped_zero_area']:,} dropped")


def zero_area_naive(count: int) -> Result:
    clean, dirty, _ = zero_area_mesh()
    _, rays = inside("vertices", min(count, NAIVE_RAYS // 2), 1.0, 0.0)
    _, found = naive.trace(meshes.corners(dirty), *rays, naive.MOLLER_LOOSE)
    return Result(int((found >= len(clean[1])).sum()), len(found))


def needle_rays(count: int):
    mesh = meshes.needles(1000, 1.0, 1e-6, 39)
    return mesh, aim.from_around(mesh, "interior", count)


def wrong_needles(scene, stats: dict, rays: aim.Rays, answer: tuple) -> Result:
    """Answers (t in scene units, triangle's row) that are wrong: unexplained against the oracle,
    or on the right needle with t off by more than 1e-4 of itself."""
    origin, direction, factor = rebase(stats, *rays)
    truth = scene.reference_intersect(*rays)
    t, row = truth["t"] / factor, rows_of(scene, truth)
    classes = classify(scene.triangles()["vertices"], origin, direction, answer, (t, row))
    both = (row >= 0) & (answer[1] == row)
    off = int((np.abs(answer[0][both] - t[both]) > 1e-4 * np.abs(t[both])).sum())
    note = ", ".join(f"{name.replace('_', ' ')} {n:,}" for name, n in classes.items())
    return Result(classes["unexplained"] + off, len(t), f"{note}, t off {off:,}")


def needles(count: int) -> Result:
    mesh, rays = needle_rays(count)
    scene, stats = scene_of(mesh)
    hits = scene.intersect(*rays)
    factor = rebase(stats, *rays)[2]
    return wrong_needles(scene, stats, rays, (hits["t"] / factor, rows_of(scene, hits)))


def needles_naive(count: int) -> Result:
    mesh, rays = needle_rays(min(count, NAIVE_RAYS))
    scene, stats = scene_of(mesh)
    origin, direction, _ = rebase(stats, *rays)
    corners = scene.triangles()["vertices"]
    answer = naive.trace(corners, origin, direction, naive.WOOP)
    return wrong_needles(scene, stats, rays, answer)


FAR = [(kind, 1.0, shift) for kind in ("edges", "vertices") for shift in (1e2, 1e3, 1e4, 1e5, 1e6)]

CASES = [
    closed(
        "1",
        "icosphere of 1,280 triangles from inside, rays at points on its edges",
        [("edges", 1.0, 0.0)],
        naive.MOLLER,
        "Moeller-Trumbore",
    ),
    closed(
        "2",
        "the same, rays at its vertices",
        [("vertices", 1.0, 0.0)],
        naive.PLUECKER,
        "signed volumes in float",
    ),
    closed("3", "1 and 2 moved by 1e2 to 1e6", FAR, naive.MOLLER, "Moeller-Trumbore"),
    closed(
        "4",
        "1 and 2 at radius 1e-3",
        [("edges", 1e-3, 0.0), ("vertices", 1e-3, 0.0)],
        naive.MOLLER_DET,
        "Moeller-Trumbore that drops det below 1e-7",
    ),
    closed(
        "5",
        "1 and 2 at radius 1e4",
        [("edges", 1e4, 0.0), ("vertices", 1e4, 0.0)],
        naive.MOLLER,
        "Moeller-Trumbore",
    ),
    Case(
        "6",
        "two triangles at an edge, ten times the rays at it, each triangle asked alone",
        "they see the edge from opposite sides: e(a, b) = -e(b, a)",
        shared_edge_signs,
        shared_edge_signs_naive,
        "edge function with a fused multiply-add",
    ),
    Case(
        "38",
        "2,000 points and lines as triangles in a sphere",
        "dropped and counted; the same hits as without them",
        zero_area,
        zero_area_naive,
        "Moeller-Trumbore that divides by det = 0",
    ),
    Case(
        "39",
        "1,000 needles of 1 : 1e6 at random angles",
        "hits are the oracle's, but within the bound of a silhouette; t to 1e-4",
        needles,
        needles_naive,
        "t from the vertices' weighed depths",
    ),
]
