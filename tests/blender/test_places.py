# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of Blender's objects and materials stand behind the core's instances and rows."""

import bpy
import pytest
import recorder


@pytest.fixture
def export(scene, addon):
    """Exports what the viewport shows, into a recorder."""
    from addon.export.scene import Export
    from addon.notes import Notes

    def run():
        graph = bpy.context.evaluated_depsgraph_get()
        return Export(recorder, graph, Notes(), lambda done: True)

    return run


def test_each_instance_tells_its_object_and_what_placed_it(scene, export):
    bpy.ops.mesh.primitive_cube_add(scale=(1, 1, 0))
    bpy.context.object.name = "Flat"
    bpy.ops.object.text_add()
    collection = bpy.data.collections.new("Group")
    collection.objects.link(bpy.data.objects.new("Brick", bpy.data.meshes["Cube"]))
    for name in ("Wall", "Tower"):
        empty = bpy.data.objects.new(name, None)
        scene.collection.objects.link(empty)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
    made = export()
    places = [(place.object, place.instancer) for place in made.meshes.places]
    assert len(places) == len(made.scene.instances)
    assert sorted(places) == [("Brick", "Tower"), ("Brick", "Wall"), ("Flat", ""), ("Text", "")]


def test_each_row_of_materials_tells_its_name(scene, export):
    for name in ("Red", ""):
        bpy.ops.mesh.primitive_cube_add()
        if name:
            bpy.context.object.data.materials.append(bpy.data.materials.new(name))
    made = export()
    assert made.materials.names == ["Red", ""]
    assert len(made.materials.names) == len(made.scene.materials)
