# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles of polygons against exact arithmetic, and meshes that keep the caller's arrays."""

import gc
import weakref

import meshes
import numpy as np
import pytest
from trees import scene_of
from whittle_core import Scene, triangulate

OPEN = 0xFFFFFFFF


def polygons(sizes, seed=0, steps=64):
    """Polygons without common vertices, their coordinates small multiples of 1/8: positions,
    corners, and the polygon of each triangle."""
    random = np.random.default_rng(seed)
    count = sum(sizes)
    positions = random.integers(-steps, steps, (count, 3)).astype(np.float32) / 8
    corners = random.permutation(count).astype(np.uint32)
    faces = np.repeat(np.arange(len(sizes)), np.array(sizes, int) - 2)
    return positions, corners, faces.astype(np.uint32)


def exact(positions, corners, sizes):
    """Triangles of corners, and the exact sign of the product of each quad's two areas, by polygon;
    one of more corners has None."""
    result, first = [], 0
    for size in sizes:
        quad = [positions[corners[first + i]].astype(float) * 8 for i in range(size)]
        a, b, c, d = range(first, first + 4)
        if size == 3:
            result.append(([(a, b, c)], 1))
        elif size == 4:
            edges = [[int(x) for x in point - quad[0]] for point in quad[1:]]
            product = int(np.dot(np.cross(edges[0], edges[1]), np.cross(edges[1], edges[2])))
            divided = [(a, b, c), (a, c, d)] if product > 0 else [(a, b, d), (b, c, d)]
            result.append((divided, np.sign(product)))
        elif size > 4:
            result.append((None, 0))
        first += size
    return result


@pytest.mark.parametrize(
    ("sizes", "seed"),
    [
        ([4] * 3000, 1),
        ([3, 4, 4, 4, 4, 2, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 7, 3, 3] * 60, 2),
        ([4, 4, 4, 4, 3] * 200, 3),
    ],
)
@pytest.mark.parametrize("steps", [2, 64])
def test_quads_are_divided_by_the_sign_of_their_areas(sizes, seed, steps):
    positions, corners, faces = polygons(sizes, seed, steps)
    triangles, count = triangulate(positions, corners, faces, by_corner=True)
    left, row, signs = 0, 0, {1: 0, -1: 0}
    for size, (divided, sign) in zip(
        (n for n in sizes if n > 2), exact(positions, corners, sizes), strict=True
    ):
        found = [tuple(t) for t in triangles[row : row + size - 2].tolist()]
        row += size - 2
        if found[0] == (OPEN, OPEN, OPEN):
            assert found == [(OPEN, OPEN, OPEN)] * (size - 2)
            left += size - 2
            assert size > 4 or sign == 0 or steps > 2  # of small numbers, only 0 is in doubt
        else:
            assert found == divided and sign
            signs[sign] += size == 4
    assert left == count and min(signs.values()) > 50
    assert row == len(triangles)
    vertices, same = triangulate(positions, corners, faces)
    closed = triangles[:, 0] != OPEN
    assert same == count and (vertices[~closed] == OPEN).all()
    assert (vertices[closed] == corners[triangles[closed]]).all()


def test_few_quads_are_left_open():
    sizes = [4] * 5000
    _, left = triangulate(*polygons(sizes, 5, 2**20))
    assert left < 20


def waves(columns, rows):
    """A grid of quads that are not quite flat: positions, corners and faces of the triangles."""
    x, y = np.meshgrid(np.arange(columns + 1), np.arange(rows + 1))
    positions = np.stack([x, y, np.sin(x + 2 * y) / 8], axis=-1).astype(np.float32).reshape(-1, 3)
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).reshape(-1, 1)
    corners = (first + [0, 1, columns + 2, columns + 1]).astype(np.uint32).reshape(-1)
    return positions, corners, np.repeat(np.arange(columns * rows, dtype=np.uint32), 2)


def test_pieces_of_a_large_mesh_fit_together():
    """Quads, with a polygon of many corners across the ends of several pieces."""
    positions, corners, faces = waves(300, 100)
    assert triangulate(positions, corners, faces)[1] == 0
    expected = corners.reshape(-1, 4)[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    assert (triangulate(positions, corners, faces)[0] == expected).all()
    many = np.arange(5000, dtype=np.uint32)
    longer = np.concatenate([corners[:40_000], many, corners[40_000:]])
    inserted = np.full(len(many) - 2, 10_000, np.uint32)
    numbers = np.concatenate([faces[:20_000], inserted, faces[20_000:] + np.uint32(1)])
    triangles, left = triangulate(positions, longer, numbers)
    assert left == len(inserted)
    assert (triangles[20_000 : 20_000 + left] == OPEN).all()
    assert (np.delete(triangles, np.s_[20_000 : 20_000 + left], axis=0) == expected).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e30, 1e-30])
def test_what_no_single_precision_can_tell_is_left_open(bad):
    square = np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    wrong = np.where(square == 0, 0, np.float32(bad))
    positions = np.concatenate([square, wrong, square, square, square, square])
    corners, faces = np.arange(24, dtype=np.uint32), np.repeat(np.arange(6, dtype=np.uint32), 2)
    triangles, left = triangulate(positions, corners, faces)
    assert left == 2 and (triangles[2:4] == OPEN).all()
    assert (triangles[[0, 1, 4, 5]] < OPEN).all()


def test_nothing_has_no_triangles():
    triangles, left = triangulate(np.empty((0, 3), np.float32), [], [])
    assert triangles.shape == (0, 3) and left == 0


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"faces": [0, 0, 1, 1, 0, 0]}, "faces: Triangle 4 is of polygon 0, but the one before"),
        ({"faces": [0, 0, 1, 1, 3, 3]}, "faces: Polygon 3 ends at corner 14 .* there are 12"),
        ({"faces": [0, 0, 1, 1, 2]}, None),
        (
            {"corners": [0, 1, 2, 3, 0, 1, 9, 3, 0, 1, 2, 3]},
            "Corner 6 names vertex 9, but .* 4 ver",
        ),
        ({"faces": [[0, 0]]}, r"faces must have shape \(m,\)"),
        ({"positions": [[0, 0]]}, r"positions must have shape \(n, 3\)"),
        ({"corners": [-1] * 12}, "corners must hold numbers from 0"),
    ],
)
def test_what_does_not_fit_is_named(change, sentence):
    square = np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    given = {"positions": square, "corners": [0, 1, 2, 3] * 3, "faces": [0, 0, 1, 1, 2, 2]}
    if sentence is None:  # fewer triangles than corners allow: the rest is not looked at
        assert triangulate(**given | change)[0][4].tolist() == [0, 1, 2]
        return
    with pytest.raises(ValueError, match=sentence):
        triangulate(**given | change)


# ---- Normals by polygon's corner -----------------------------------------------------------------


def test_normals_of_corners_are_those_of_the_triangles():
    positions, corners, faces = waves(9, 7)
    triangles, _ = triangulate(positions, corners, faces, by_corner=True)
    normals = np.random.default_rng(1).normal(size=(len(corners), 3)).astype(np.float32)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    pictures = []
    for given in (
        {"triangles": triangles, "corners": corners, "normals": normals},
        {"triangles": corners[triangles], "normals": normals[triangles]},
        {"triangles": corners[triangles]},
    ):
        scene = Scene()
        scene.add_instance(scene.add_mesh(positions, **given), np.eye(4))
        pictures.append(picture(scene))
    assert pictures[0] == pictures[1] != pictures[2]
    with pytest.raises(ValueError, match=r"normals must have shape \(252, 3\)"):
        Scene().add_mesh(positions, triangles, normals[:-1], corners=corners)


def picture(scene):
    """The bytes of an image of the waves from above."""
    scene.build()
    look = np.eye(4)
    look[:3, 3] = 4.5, 3.5, 20
    shape = {"width": 32, "height": 24}
    camera = shape | {"to_world": look, "projection": np.diag([3.0, 4.0, -1.0, 1.0])}
    camera["projection"][2:] = [[0, 0, -1.0, -0.2], [0, 0, -1, 0]]
    return scene.render(camera, {"passes": ["normal"]})["normal"].tobytes()


# ---- Arrays that are kept ------------------------------------------------------------------------


def frozen(*arrays):
    for values in arrays:
        values.flags.writeable = False
    return arrays


def test_kept_arrays_make_the_same_tree_and_are_given_back():
    positions, triangles = frozen(*(values.copy() for values in meshes.terrain(70)))
    copied = scene_of((positions, triangles))
    copied.build()
    scene = Scene()
    scene.add_instance(scene.add_mesh(positions, triangles, keep=True), np.eye(4))
    scene.build()
    assert scene.nodes().tobytes() == copied.nodes().tobytes()
    watched = weakref.ref(positions), weakref.ref(triangles)
    del positions, triangles
    gc.collect()
    assert all(ref() is not None for ref in watched)
    scene.replace_mesh(0, *meshes.icosphere(1))
    gc.collect()
    assert all(ref() is None for ref in watched)


def test_the_end_of_a_scene_gives_kept_arrays_back():
    positions, triangles = frozen(*(values.copy() for values in meshes.icosphere(2)))
    materials = frozen(np.zeros(len(triangles), np.uint32))[0]
    normals = frozen(positions.copy())[0]
    scene = Scene()
    scene.add_mesh(positions, triangles, normals, materials=materials, keep=True)
    watched = [weakref.ref(values) for values in (positions, triangles, normals, materials)]
    del positions, triangles, normals, materials
    gc.collect()
    assert all(ref() is not None for ref in watched)
    del scene
    gc.collect()
    assert all(ref() is None for ref in watched)


def test_of_a_mesh_with_corners_only_what_is_read_is_kept():
    positions, corners, faces = waves(4, 4)
    triangles, _ = triangulate(positions, corners, faces, by_corner=True)
    frozen(positions, corners, triangles)
    scene = Scene()
    scene.add_mesh(positions, triangles, corners=corners, keep=True)
    watched = [weakref.ref(values) for values in (positions, triangles, corners)]
    del positions, triangles, corners
    gc.collect()
    assert [ref() is None for ref in watched] == [False, True, True]


def test_a_mesh_that_is_refused_keeps_nothing():
    positions, triangles = frozen(np.eye(3, dtype=np.float32), np.uint32([[0, 1, 3]]))
    scene = Scene()
    with pytest.raises(ValueError, match="Triangle 0 names vertex 3"):
        scene.add_mesh(positions, triangles, keep=True)
    watched = weakref.ref(positions)
    del positions
    gc.collect()
    assert watched() is None and scene.add_mesh(*meshes.icosphere(1)) == 0


@pytest.mark.parametrize("name", ["positions", "triangles", "normals", "materials"])
@pytest.mark.parametrize("fault", ["writable", "other type", "gaps"])
def test_arrays_that_cannot_be_kept_are_named(name, fault):
    positions, triangles = (values.copy() for values in meshes.icosphere(1))
    given = {
        "positions": positions,
        "triangles": triangles,
        "normals": positions.copy(),
        "materials": np.zeros(len(triangles), np.uint32),
    }
    if fault == "other type":
        given[name] = given[name].astype(np.float64 if name in ("positions", "normals") else "i8")
    elif fault == "gaps":
        given[name] = np.repeat(given[name], 2, axis=0)[::2]
    for key, values in given.items():
        values.flags.writeable = key == name and fault == "writable"
    with pytest.raises(ValueError, match=f"{name} must be read-only"):
        Scene().add_mesh(**given, keep=True)
