# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles on their way into the tree: their frame, their bits, and which of them are dropped."""

import meshes
import numpy as np
import pytest
from meshes import Mesh
from numpy.typing import NDArray
from trees import check_tree, scene_of
from whittle_core import Scene


def in_scene_space(world: NDArray, stats: dict) -> NDArray[np.float32]:
    return np.ldexp(world - np.array(stats["center"]), -stats["exponent"]).astype(np.float32)


def placed(mesh: Mesh, matrix: NDArray) -> NDArray[np.float64]:
    """World positions by the rounding that the core promises: products added from x to z."""
    x, y, z = np.moveaxis(mesh[0].astype(np.float64), 1, 0)
    with np.errstate(all="ignore"):
        return np.stack([((r[0] * x + r[1] * y) + r[2] * z) + r[3] for r in matrix[:3]], axis=1)


def random_matrix(seed: int) -> NDArray[np.float64]:
    random = np.random.default_rng(seed)
    matrix = np.eye(4)
    matrix[:3] = random.normal(size=(3, 4)) * [1, 1, 1, 50]
    return matrix


def test_frame_and_vertices_match_numpy():
    parts = [(meshes.icosphere(2), random_matrix(1)), (meshes.torus(), random_matrix(2))]
    scene = scene_of(*parts)
    stats = scene.build()
    world = [placed(mesh, matrix) for mesh, matrix in parts]
    every = np.concatenate(world)
    extent, step = np.ptp(every, axis=0).max(), 2.0 ** stats["exponent"]
    assert step / 2 < extent <= step
    middle = every.min(axis=0) / 2 + every.max(axis=0) / 2
    assert np.array_equal(np.mod(stats["center"], step), np.zeros(3))
    assert (np.abs(middle - stats["center"]) <= step / 2).all()
    triangles = scene.triangles()
    for instance, (mesh, _) in enumerate(parts):
        mine = triangles["instance"] == instance
        want = in_scene_space(world[instance], stats)[mesh[1][triangles["triangle"][mine]]]
        assert np.array_equal(triangles["vertices"][mine], want)
    assert not np.signbit(triangles["vertices"][triangles["vertices"] == 0]).any()


def test_moving_one_object_keeps_the_bits_of_the_others():
    still = (meshes.icosphere(3), random_matrix(3))
    seen = set()
    for x in (0.0, 0.37, 1.1, -0.9):
        scene = scene_of(
            (meshes.icosphere(1), meshes.transform(20.0)),
            still,
            (meshes.torus(), meshes.transform(1.0, (x, 0.2, 0))),
        )
        scene.build()
        triangles = scene.triangles()
        own = triangles["instance"] == 1
        order = np.argsort(triangles["triangle"][own])
        seen.add(triangles["vertices"][own][order].tobytes())
    assert len(seen) == 1


@pytest.mark.parametrize("subdivisions", [2, 6], ids=["small", "shared by threads"])
def test_vertices_that_no_good_triangle_uses_do_not_stretch_the_frame(subdivisions):
    positions, triangles = meshes.icosphere(subdivisions)
    alone = scene_of((positions, triangles))
    alone.build()
    stray = np.array([[1e30, 0, 0], [0, -1e20, 0], [np.nan, 0, 0]], np.float32)
    bad = np.arange(3, dtype=np.uint32)[None] + np.uint32(len(positions))
    scene = scene_of((np.concatenate([positions, stray]), np.concatenate([triangles, bad])))
    stats = scene.build()
    assert stats["dropped_non_finite"] == 1
    assert scene.nodes().tobytes() == alone.nodes().tobytes()


def test_vertices_of_no_triangle_do_not_stretch_the_frame_of_a_large_mesh():
    positions, triangles = meshes.icosphere(6)
    alone = scene_of((positions, triangles))
    alone.build()
    for place in (0, len(positions) // 2, len(positions)):
        grown = np.insert(positions, place, [[1e30, 0, 0]], axis=0)
        scene = scene_of((grown, np.where(triangles < place, triangles, triangles + 1)))
        scene.build()
        assert scene.nodes().tobytes() == alone.nodes().tobytes()


def test_the_first_bad_index_of_a_large_mesh_is_named():
    positions, triangles = meshes.icosphere(6)
    broken = triangles.copy()
    broken[[70_001, 70_000, 81_000], [0, 1, 2]] = len(positions) + np.arange(3)
    named = f"Triangle 70000 names vertex {len(positions) + 1}, but the mesh has {len(positions)}"
    with pytest.raises(ValueError, match=named):
        scene_of((positions, broken))


def test_many_vertices_in_a_row_that_no_triangle_uses():
    """Whole pieces of the work have nothing to bound then."""
    corners = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    padding = np.full((40_000, 3), 5, np.float32)
    mesh = np.concatenate([padding, corners, padding]), np.uint32([[40_000, 40_001, 40_002]])
    scene = scene_of(mesh)
    stats = scene.build()
    assert (stats["center"], stats["exponent"]) == ((1.0, 1.0, 0.0), 0)
    assert scene.intersect([[0.2, 0.2, 1]], [[0, 0, -1]])["t"] == 1


def judged(mesh: Mesh, matrix: NDArray, stats: dict) -> tuple[NDArray, NDArray]:
    """Which triangles are not finite, and which have no area, by the stated definitions."""
    with np.errstate(all="ignore"):
        world = placed(mesh, matrix)
        finite = (np.abs(world) <= np.finfo(np.float32).max).all(axis=1)[mesh[1]].all(axis=1)
        corners = in_scene_space(world, stats)[mesh[1]].astype(np.float64)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return ~finite, finite & (normal == 0).all(axis=1)


def test_bad_triangles_are_dropped_and_counted_by_mesh():
    random = np.random.default_rng(5)
    positions, triangles = meshes.random_triangles(4000, 0.2, 6)
    positions[random.integers(len(positions), size=300), random.integers(3, size=300)] = np.array(
        [np.nan, np.inf, -np.inf], np.float32
    )[np.arange(300) % 3]
    triangles[random.integers(4000, size=200), 1] = triangles[0, 2]
    points = triangles.copy()
    points[::3, 1] = points[::3, 0]
    huge = np.diag([1e38, 1e38, 1e38, 1.0])
    parts = [
        ((positions, triangles), random_matrix(7)),
        ((positions, points), np.eye(4)),
        (meshes.icosphere(1, 2.0), np.eye(4)),
        (meshes.icosphere(1, 9.0), huge),
    ]
    scene = scene_of(*parts)
    # A second instance of the second mesh: its triangles are dropped, and counted, twice.
    scene.add_instance(1, random_matrix(8))
    parts.append((parts[1][0], random_matrix(8)))
    stats = scene.build()
    expected: dict[int, list[int]] = {}
    kept = set()
    for instance, (mesh, matrix) in enumerate(parts):
        bad, flat = judged(mesh, matrix, stats)
        counts = expected.setdefault(instance if instance < 4 else 1, [0, 0])
        counts[0] += int(bad.sum())
        counts[1] += int(flat.sum())
        kept |= {(instance, int(t)) for t in np.flatnonzero(~bad & ~flat)}
    got = {d["mesh"]: [d["non_finite"], d["zero_area"]] for d in stats["dropped"]}
    assert got == {mesh: counts for mesh, counts in expected.items() if any(counts)}
    assert min(expected[1]) > 0
    assert expected[3][0] > 0
    found = scene.triangles()
    pairs = list(zip(found["instance"].tolist(), found["triangle"].tolist(), strict=True))
    assert set(pairs) == kept
    assert len(pairs) == len(kept)
    check_tree(scene, stats)


def test_triangles_of_corners_are_those_of_their_vertices():
    for subdivisions in (2, 6):
        positions, triangles = meshes.icosphere(subdivisions)
        order = np.random.default_rng(4).permutation(triangles.size).astype(np.uint32)
        corners = triangles.reshape(-1)[np.argsort(order)]
        built = []
        for arrays in ({"triangles": triangles}, {"triangles": order.reshape(-1, 3)}):
            scene = Scene()
            given = {"corners": corners} if built else {}
            scene.add_instance(scene.add_mesh(positions, **arrays, **given), np.eye(4))
            scene.build()
            built.append(scene.triangles()["vertices"].tobytes() + scene.nodes().tobytes())
        assert built[0] == built[1]
        replaced = Scene()
        replaced.add_instance(replaced.add_mesh(*meshes.icosphere(1)), np.eye(4))
        replaced.replace_mesh(0, positions, order.reshape(-1, 3), corners=corners)
        replaced.build()
        assert replaced.nodes().tobytes() == scene.nodes().tobytes()


@pytest.mark.parametrize(
    ("triangle", "corners", "sentence"),
    [
        ((0, 1, 4), (0, 1, 2, 0), "Triangle 0 names corner 4, but there are 4"),
        ((0, 1, 3), (0, 1, 2, 3), "Corner 3 names vertex 3, but the mesh has 3 vertices"),
        ((0, 1, 2), [(0, 1, 2)], r"corners must have the shape|corners .*\(k,\)"),
    ],
)
def test_a_bad_corner_is_named(triangle, corners, sentence):
    positions = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    with pytest.raises(ValueError, match=sentence):
        Scene().add_mesh(positions, np.uint32([triangle]), corners=np.uint32(corners))
