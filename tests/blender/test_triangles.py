# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The triangles of polygons are Blender's own: the same ones, corner for corner, of any polygon."""

import bmesh
import bpy
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays as any_array

SLOTS = np.arange(3, dtype=np.uint32)
SQUARE = np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])


def mesh_of(points, sizes):
    """A mesh of polygons without common vertices; every third of them is flat, and each has one of
    three materials."""
    mesh = bpy.data.meshes.new("Polygons")
    count = sum(sizes)
    mesh.vertices.add(count)
    mesh.vertices.foreach_set("co", np.ascontiguousarray(points, np.float32).reshape(-1))
    mesh.loops.add(count)
    mesh.loops.foreach_set("vertex_index", np.arange(count, dtype=np.int32)[::-1].copy())
    mesh.polygons.add(len(sizes))
    starts = np.cumsum([0, *sizes[:-1]], dtype=np.int32)
    mesh.polygons.foreach_set("loop_start", starts)
    mesh.polygons.foreach_set("use_smooth", np.arange(len(sizes)) % 3 > 0)
    mesh.polygons.foreach_set("material_index", np.arange(len(sizes), dtype=np.int32) % 3)
    mesh.update(calc_edges=True)
    return mesh


def column(data, name, width=1):
    values = np.empty(len(data) * width, dtype=np.int32)
    data.foreach_get(name, values)
    return values.reshape(-1, width) if width > 1 else values


def agree(mesh, flat=False):
    """Whether the exporter's triangles are those that Blender names, by vertex, by corner and by
    polygon, the last two as far as normals and materials tell."""
    from addon.export.meshes import arrays

    if flat:
        mesh.shade_flat()
    found = arrays(mesh, SLOTS)
    mesh.calc_loop_triangles()
    rows = mesh.loop_triangles
    triangles = found["triangles"]
    if found["corners"] is not None:
        assert np.array_equal(triangles, column(rows, "loops", 3))
        triangles = found["corners"][triangles]
    assert (found["corners"] is None) == flat
    assert np.array_equal(triangles, column(rows, "vertices", 3))
    assert np.array_equal(found["materials"], column(rows, "polygon_index") % 3)


@pytest.mark.parametrize("flat", [True, False])
@given(st.data())
@settings(max_examples=80)
def test_any_quads(addon, flat, data):
    """Of any numbers, few different ones, or corners that are moved a little or nearly agree."""
    count = data.draw(st.integers(3, 12))
    whole = st.floats(width=32, allow_nan=True, allow_infinity=True)
    few = st.sampled_from([0.0, 1.0, -1.0, 2.0, 1 + 2**-23, 2.0**-66, -(2.0**63), np.nan])
    small = st.floats(-2.0, 2.0, width=32)
    numbers = data.draw(st.sampled_from([whole, few, small]))
    points = data.draw(any_array(np.float32, (count, 4, 3), elements=numbers))
    shape = data.draw(st.sampled_from(["any", "flat", "square", "collapsed", "in line"]))
    with np.errstate(all="ignore"):
        if shape == "flat":
            points[..., 2] = points[0, 0, 2]
        elif shape == "square":
            points = SQUARE + points / 8
        elif shape == "collapsed":
            points[:, 3] = points[:, data.draw(st.integers(0, 2))]
        elif shape == "in line":
            points[:, 1] = points[:, 0] + (points[:, 2] - points[:, 0]) * np.float32(0.3)
    mesh = mesh_of(points, [4] * count)
    agree(mesh, flat)
    bpy.data.meshes.remove(mesh)


FAMILIES = {
    "nearly square": lambda r, n: SQUARE + r.normal(size=(n, 4, 3)) / 10,
    "twisted": lambda r, n: SQUARE + r.normal(size=(n, 4, 3)),
    "concave": lambda r, n: r.normal(size=(n, 4, 3)) * [1, 1, 0],
    "far": lambda r, n: r.normal(size=(n, 4, 3)) * [1, 1, 0.01] + 1e5 * r.normal(size=(n, 1, 3)),
    "slivers": lambda r, n: r.normal(size=(n, 4, 3)) * 10 ** r.uniform(-7, 0, (n, 1, 3)),
    "of any size": lambda r, n: r.normal(size=(n, 4, 3)) * 10 ** r.uniform(-25, 25, (n, 1, 1)),
    "grid points": lambda r, n: r.integers(-1, 2, (n, 4, 3)),
    "not numbers": lambda r, n: np.where(
        r.random((n, 4, 3)) < 0.05, np.nan, r.normal(size=(n, 4, 3))
    ),
}


@pytest.mark.parametrize("family", FAMILIES)
def test_many_quads(addon, family):
    points = FAMILIES[family](np.random.default_rng(7), 6000)
    with np.errstate(over="ignore"):
        mesh = mesh_of(points.astype(np.float32), [4] * len(points))
    agree(mesh)
    bpy.data.meshes.remove(mesh)


def test_polygons_of_all_sizes(addon):
    random = np.random.default_rng(3)
    sizes = random.choice([3, 4, 4, 4, 4, 5, 9], 3000)
    mesh = mesh_of(random.normal(size=(sizes.sum(), 3)), sizes.tolist())
    agree(mesh)
    bpy.data.meshes.remove(mesh)


@pytest.mark.parametrize("modifier", ["SUBSURF", "SOLIDIFY", "TRIANGULATE", "WEIGHTED_NORMAL"])
def test_what_modifiers_make(scene, modifier):
    random = np.random.default_rng(4)
    ob = bpy.data.objects.new("Object", mesh_of(random.normal(size=(2000, 3)), [4] * 500))
    scene.collection.objects.link(ob)
    ob.modifiers.new("Modifier", modifier)
    mesh = ob.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    from addon.export.meshes import arrays

    found = arrays(mesh, SLOTS[:1])
    triangles = found["triangles"]
    if found["corners"] is not None:
        triangles = found["corners"][triangles]
    mesh.calc_loop_triangles()
    assert np.array_equal(triangles, column(mesh.loop_triangles, "vertices", 3))


def test_blender_is_asked_for_no_more_than_is_open(addon, monkeypatch):
    """A few by themselves, many in one go; of good quads none, and triangles are what they are."""
    from addon.export import meshes

    listed, single = [], []

    class Rows:
        def __init__(self, rows):
            self.rows = rows

        def __len__(self):
            return len(self.rows)

        def __getitem__(self, index):
            single.append(index)
            return self.rows[index]

        def foreach_get(self, name, values):
            listed.append(name)
            self.rows.foreach_get(name, values)

    class Mesh:
        def __init__(self, mesh):
            self.mesh = mesh

        def __getattr__(self, name):
            value = getattr(self.mesh, name)
            return Rows(value) if name == "loop_triangles" else value

    square, line = SQUARE, SQUARE * np.float32([1, 0, 0])
    for sizes, quads, by_itself, at_once in (
        ([4] * 30, [square] * 30, [], []),
        ([4] * 30, [square] * 29 + [line], [58, 59], []),
        ([4] * 30, [square] * 20 + [line] * 10, [], ["loops"]),
    ):
        mesh = mesh_of(np.concatenate(quads)[::-1], sizes)
        found = meshes.arrays(Mesh(mesh), SLOTS)
        assert np.array_equal(found["triangles"], column(mesh.loop_triangles, "loops", 3))
        assert (single, listed) == (by_itself, at_once)
        single.clear()
        listed.clear()
    mesh = mesh_of(np.random.default_rng(1).normal(size=(30, 3)), [3] * 10)
    assert np.array_equal(
        meshes.arrays(Mesh(mesh), SLOTS)["triangles"].reshape(-1), np.arange(30)[::-1]
    )
    assert not single and not listed


def test_an_object_squashed_flat_keeps_its_triangles(scene):
    """Its vertices are placed by the exporter; corners then only name them."""
    import recorder

    from addon.export.scene import Export
    from addon.notes import Notes

    shape = bmesh.new()
    bmesh.ops.create_cube(shape, size=2.0)
    mesh = bpy.data.meshes.new("Cube")
    shape.to_mesh(mesh)
    shape.free()
    mesh.shade_smooth()
    mesh.polygons[0].use_smooth = False
    ob = bpy.data.objects.new("Cube", mesh)
    ob.scale.z = 0
    scene.collection.objects.link(ob)
    graph = bpy.context.evaluated_depsgraph_get()
    native = Export(recorder, graph, Notes(), lambda done: True).scene
    assert native.meshes[0].normals is None
    mesh.calc_loop_triangles()
    assert np.array_equal(native.meshes[0].triangles, column(mesh.loop_triangles, "vertices", 3))
