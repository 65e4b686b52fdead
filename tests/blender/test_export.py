# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The exporter: what of a Blender scene reaches the core, and what is said of the rest."""

import bmesh
import bpy
import numpy as np
import pytest
import recorder


@pytest.fixture
def export(scene, addon):
    """Exports the scene as it is rendered, into a recorder; gives it and the notes."""
    from addon.export.scene import Export
    from addon.notes import Notes

    def run(report=lambda done: True):
        notes = Notes()
        scene.view_layers[0].update()
        found = []

        class Probe(bpy.types.RenderEngine):
            """Only a render has a depsgraph in render mode."""

            bl_idname = "WHITTLE_PROBE"
            bl_label = "Probe"

            def render(self, depsgraph):
                try:
                    found.append(Export(recorder, depsgraph, notes, report))
                except BaseException as error:
                    found.append(error)
                self.report({"ERROR"}, "no picture wanted")

        bpy.utils.register_class(Probe)
        scene.render.engine = "WHITTLE_PROBE"
        try:
            with pytest.raises(RuntimeError, match="no picture wanted"):
                bpy.ops.render.render()
        finally:
            scene.render.engine = "WHITTLE"
            bpy.utils.unregister_class(Probe)
        if isinstance(found[0], BaseException):
            raise found[0]
        return found[0].scene, notes.lines()

    return run


def link(scene, name, data):
    ob = bpy.data.objects.new(name, data)
    scene.collection.objects.link(ob)
    return ob


def cube(name="Cube", size=2.0):
    mesh = bpy.data.meshes.new(name)
    shape = bmesh.new()
    bmesh.ops.create_cube(shape, size=size)
    shape.to_mesh(mesh)
    shape.free()
    return mesh


def material(name, **inputs):
    """A Principled material with the given inputs."""
    made = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0):
        made.use_nodes = True
    node = made.node_tree.nodes["Principled BSDF"]
    for key, value in inputs.items():
        node.inputs[key.replace("_", " ")].default_value = value
    return made


def test_an_empty_scene_is_exported(export):
    native, notes = export()
    assert native.meshes == [] and native.lights == [] and notes == []
    assert native.world.color == native.world.ambient == (0, 0, 0)


def test_a_shared_mesh_is_exported_once(scene, export):
    mesh = cube()
    for index in range(3):
        link(scene, f"Cube {index}", mesh).location.x = 4 * index
    native, _ = export()
    assert len(native.meshes) == 1
    assert [instance.matrix[0, 3] for instance in native.instances] == [0, 4, 8]


def test_a_shared_mesh_with_other_materials_on_the_object_is_another_mesh(scene, export):
    mesh = cube()
    mesh.materials.append(material("Red", Base_Color=(1, 0, 0, 1)))
    first, second = link(scene, "First", mesh), link(scene, "Second", mesh)
    second.material_slots[0].link = "OBJECT"
    second.material_slots[0].material = material("Blue", Base_Color=(0, 0, 1, 1))
    native, _ = export()
    assert len(native.meshes) == 2
    colors = {
        native.materials[native.meshes[instance.mesh].materials[0]]["diffuse"]
        for instance in native.instances
    }
    assert colors == {(1, 0, 0), (0, 0, 1)}
    assert first.data == second.data


def test_modifiers_count_at_their_render_level(scene, export):
    ob = link(scene, "Cube", cube())
    modifier = ob.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = 0, 2
    native, _ = export()
    assert len(native.meshes[0].triangles) == 6 * 4**2 * 2


def test_curves_and_text_are_exported_once(scene, export):
    bpy.ops.object.text_add()
    bpy.ops.curve.primitive_bezier_circle_add()
    bpy.context.object.data.bevel_depth = 0.1
    bpy.ops.surface.primitive_nurbs_surface_sphere_add()
    bpy.ops.object.metaball_add()
    native, notes = export()
    assert len(native.meshes) == len(native.instances) == 4
    assert not [line for line in notes if line.startswith("Left out")]


def test_instances_of_a_collection_share_their_mesh(scene, export):
    collection = bpy.data.collections.new("Group")
    collection.objects.link(bpy.data.objects.new("Cube", cube()))
    lamp = bpy.data.lights.new("Lamp", "POINT")
    collection.objects.link(bpy.data.objects.new("Lamp", lamp))
    for index in range(2):
        empty = link(scene, f"Empty {index}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        empty.location.y = 3 * index
    native, _ = export()
    assert len(native.meshes) == 1
    assert sorted(instance.matrix[1, 3] for instance in native.instances) == [0, 3]
    assert sorted(light["position"][1] for light in native.lights) == [0, 3]


def test_instances_of_geometry_nodes_share_their_mesh(scene, export):
    ob = link(scene, "Points", cube())
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    for way, kind in (("INPUT", "in"), ("OUTPUT", "out")):
        tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
        tree.nodes.new(f"NodeGroup{way.title()}").name = kind
    scatter = tree.nodes.new("GeometryNodeInstanceOnPoints")
    shape = tree.nodes.new("GeometryNodeMeshCone")
    paint = tree.nodes.new("GeometryNodeSetMaterial")
    paint.inputs["Material"].default_value = material("Green", Base_Color=(0, 1, 0, 1))
    tree.links.new(tree.nodes["in"].outputs[0], scatter.inputs["Points"])
    tree.links.new(shape.outputs["Mesh"], paint.inputs["Geometry"])
    tree.links.new(paint.outputs[0], scatter.inputs["Instance"])
    tree.links.new(scatter.outputs[0], tree.nodes["out"].inputs[0])
    ob.modifiers.new("Scatter", "NODES").node_group = tree
    native, _ = export()
    assert len(native.meshes) == 1 and len(native.instances) == 8
    row = native.materials[native.meshes[0].materials[0]]
    assert row["diffuse"] == (0, 1, 0)


def test_positions_triangles_and_materials_are_those_of_the_mesh(scene, export):
    mesh = bpy.data.meshes.new("Mesh")
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 1), (2, 1, 1)]
    mesh.from_pydata(points, [], [(0, 1, 2, 3), (1, 4, 5)])
    mesh.materials.append(material("Red", Base_Color=(1, 0, 0, 1)))
    mesh.materials.append(material("Blue", Base_Color=(0, 0, 1, 1)))
    mesh.polygons[1].material_index = 1
    link(scene, "Object", mesh)
    native, _ = export()
    found = native.meshes[0]
    assert np.array_equal(found.positions, np.float32(points))
    quad = sorted(found.triangles[:2].reshape(-1).tolist())
    assert quad in ([0, 0, 1, 2, 2, 3], [0, 1, 1, 2, 3, 3])
    assert found.triangles[2].tolist() == [1, 4, 5]
    diffuse = [native.materials[index]["diffuse"] for index in found.materials]
    assert diffuse == [(1, 0, 0), (1, 0, 0), (0, 0, 1)]
    assert found.normals is None


def test_a_material_index_beyond_the_slots_takes_the_last(scene, export):
    mesh = cube()
    mesh.materials.append(material("Red", Base_Color=(1, 0, 0, 1)))
    mesh.materials.append(material("Blue", Base_Color=(0, 0, 1, 1)))
    mesh.polygons.foreach_set("material_index", [7] * 6)
    link(scene, "Cube", mesh)
    native, _ = export()
    assert {native.materials[i]["diffuse"] for i in native.meshes[0].materials} == {(0, 0, 1)}


@pytest.mark.parametrize("triangles", [False, True])
def test_normals_are_by_vertex_or_by_corner(scene, export, triangles):
    mesh = cube()
    if triangles:
        shape = bmesh.new()
        shape.from_mesh(mesh)
        bmesh.ops.triangulate(shape, faces=shape.faces)
        shape.to_mesh(mesh)
        shape.free()
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    link(scene, "Smooth", mesh)
    native, _ = export()
    smooth = native.meshes[0]
    assert smooth.normals.shape == (8, 3)
    corners = smooth.positions / np.linalg.norm(smooth.positions, axis=1, keepdims=True)
    assert np.allclose(smooth.normals, corners, atol=1e-4)  # Blender's arc cosine is a quick one

    mesh.polygons[0].use_smooth = False
    native, _ = export()
    mixed = native.meshes[0]
    assert mixed.normals.shape == (12, 3, 3)
    assert np.allclose(np.linalg.norm(mixed.normals, axis=2), 1, atol=1e-4)
    points = mixed.positions[mixed.triangles]
    cross = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    assert (np.einsum("tcx,tx->tc", mixed.normals, cross) > 0).all()


def test_ray_visibility_and_render_visibility(scene, export):
    seen = link(scene, "Seen", cube("A"))
    seen.visible_camera, seen.visible_shadow = False, False
    link(scene, "Hidden", cube("B")).hide_render = True
    collection = bpy.data.collections.new("Hidden")
    scene.collection.children.link(collection)
    collection.hide_render = True
    collection.objects.link(bpy.data.objects.new("In Hidden", cube("C")))
    native, _ = export()
    assert [i.visibility for i in native.instances] == [recorder.REFLECTION | recorder.REFRACTION]


def test_indirect_only_hides_from_the_camera_and_holdout_is_named(scene, export):
    for name in ("Indirect", "Holdout"):
        collection = bpy.data.collections.new(name)
        scene.collection.children.link(collection)
        collection.objects.link(bpy.data.objects.new(name, cube(name)))
    layer = scene.view_layers[0].layer_collection
    layer.children["Indirect"].indirect_only = True
    layer.children["Holdout"].holdout = True
    native, notes = export()
    assert sorted(i.visibility for i in native.instances) == [
        recorder.ALL & ~recorder.CAMERA,
        recorder.ALL,
    ]
    assert [line for line in notes if "Holdout" in line and "holdout" in line]


def test_object_index(scene, export):
    link(scene, "Cube", cube()).pass_index = 7
    native, _ = export()
    assert [instance.id for instance in native.instances] == [7]


def test_flat_and_vanished_objects(scene, export):
    flat = link(scene, "Flat", cube("A"))
    flat.scale, flat.location = (1, 1, 0), (5, 0, 2)
    link(scene, "Point", cube("B")).scale = (0, 0, 0)
    native, notes = export()
    assert len(native.instances) == 1
    placed = native.placed(0)
    assert set(placed[:, 2]) == {2.0} and set(placed[:, 0]) == {4.0, 6.0}
    assert notes == ["Object 'Point' left out: its scale is zero"]


def test_what_cannot_be_drawn_is_named_with_its_count(scene, export):
    for index in range(2):
        link(scene, f"Cloud {index}", bpy.data.pointclouds.new(f"Cloud {index}"))
    link(scene, "Fur", bpy.data.hair_curves.new("Fur"))
    link(scene, "Smoke", bpy.data.volumes.new("Smoke"))
    if bpy.app.version >= (4, 3):
        bpy.ops.object.grease_pencil_add(type="STROKE")
    ob = link(scene, "Head", cube())
    ob.modifiers.new("Particles", "PARTICLE_SYSTEM")
    ob.particle_systems[0].settings.type = "HAIR"
    _, notes = export()
    text = "\n".join(notes)
    assert "Left out point cloud: 2 objects (Cloud 0, Cloud 1)" in text
    assert "Fur" in text and "Head" in text and "Left out hair: 2 objects" in text
    assert "Left out volume: 1 object (Smoke)" in text
    if bpy.app.version >= (4, 3):
        assert "Left out grease pencil: 1 object" in text
        assert "Blender draws it over the picture" in text


def test_the_material_override_of_a_view_layer(scene, export):
    mesh = cube()
    mesh.materials.append(material("Red", Base_Color=(1, 0, 0, 1)))
    link(scene, "Cube", mesh)
    scene.view_layers[0].material_override = material("Clay", Base_Color=(0, 1, 0, 1))
    native, _ = export()
    assert [row["diffuse"] for row in native.materials] == [(0, 1, 0)]


def test_an_object_without_material_is_light_grey(scene, export):
    link(scene, "Cube", cube())
    native, _ = export()
    assert native.materials == [{"diffuse": (0.8, 0.8, 0.8)}]


def test_dropped_triangles_are_told_by_object(scene, addon):
    from addon.export.scene import Export
    from addon.notes import Notes

    link(scene, "Broken", cube())
    notes = Notes()
    found = Export(recorder, bpy.context.evaluated_depsgraph_get(), notes, lambda done: True)
    found.note_dropped([{"mesh": 0, "non_finite": 3, "zero_area": 1200}])
    assert notes.lines() == ["Dropped triangles of Broken: 3 not finite and 1,200 without area"]


def test_export_stops_when_told(scene, export):
    link(scene, "Cube", cube())
    with pytest.raises(recorder.Cancelled):
        export(report=lambda done: False)


def test_a_place_that_is_not_finite_is_left_out_and_named(scene, export):
    ob = link(scene, "Lost", cube())
    ob.location.x = float("nan")
    tiny = link(scene, "Tiny", cube())
    tiny.scale = (1e-15, 1e-15, 1e-15)
    native, notes = export()
    assert len(native.instances) == 1
    assert notes == ["Object 'Lost' left out: its place is not a finite number"]
