# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A native scene that follows the depsgraph: as right as a new one, with no call too many."""

from collections import Counter

import bmesh
import bpy
import numpy as np
import pytest
from mathutils import Matrix


class Core:
    """The core's module, but that its scenes count the calls that change them."""

    def __init__(self, core, calls):
        class Scene:
            def __init__(self):
                self._scene = core.Scene()

            def __getattr__(self, name):
                if not hasattr(self._scene, name):
                    raise AttributeError(name)
                if name not in ("build", "render"):
                    calls[name] += 1
                return getattr(self._scene, name)

        self.Scene = Scene
        self._core = core

    def __getattr__(self, name):
        return getattr(self._core, name)


class Follower:
    """A Live scene that hears of every update, and what it did."""

    def __init__(self, core):
        from addon.export.live import Live

        self.calls = Counter()
        self.core = core
        self.live = Live(Core(core, self.calls))

    def hear(self, scene, depsgraph):
        self.live.mark(depsgraph)

    def sync(self, *expected):
        """The change that a sync reports, after a check that the scene shows what a new one shows
        and that just these calls were made."""
        self.calls.clear()
        bpy.context.view_layer.update()
        graph = bpy.context.evaluated_depsgraph_get()
        change = self.live.sync(graph)
        if expected != (ANY,):
            assert dict(self.calls) == dict(Counter(expected))
        assert np.array_equal(self.picture(self.live), self.picture(self.new()))
        return change

    def new(self):
        from addon.export.live import Live

        live = Live(self.core)
        live.sync(bpy.context.evaluated_depsgraph_get())
        return live

    def picture(self, live):
        from addon.export import camera
        from addon.notes import Notes

        graph = bpy.context.evaluated_depsgraph_get()
        size = (64, 40)
        view = camera.export(graph, bpy.context.scene.camera, size, (0, 0, *size), Notes())
        live.scene.build(threads=1, by_instance=live is self.live)
        return live.scene.render(view, {"samples": 1, "threads": 1})["combined"]


ANY = object()
LOOK = ("set_materials", "set_lights", "set_world")


@pytest.fixture
def change(addon):
    from addon.export.live import Change

    return Change


@pytest.fixture
def follower(scene, addon):
    """Follows a scene with two cubes of one mesh, a sphere with a modifier, and a light."""
    from addon import native

    core = native.load()
    red, grey = material("Red", (1, 0, 0)), material("Grey", (0.5, 0.5, 0.5))
    cube = mesh("Cube", lambda shape: bmesh.ops.create_cube(shape, size=1.5), red)
    ball = mesh(
        "Ball", lambda shape: bmesh.ops.create_icosphere(shape, subdivisions=1, radius=1), grey
    )
    put(scene, "Left", cube, (-2, 0, 0))
    put(scene, "Right", cube, (2, 0, 0))
    put(scene, "Ball", ball, (0, 1, 0)).modifiers.new("Smooth", "SUBSURF").levels = 1
    put(scene, "Lamp", bpy.data.lights.new("Lamp", "POINT"), (1, -2, 6)).data.energy = 500
    found = Follower(core)
    bpy.app.handlers.depsgraph_update_post.append(found.hear)
    found.sync(ANY)
    yield found
    bpy.app.handlers.depsgraph_update_post.remove(found.hear)


def icosphere(shape):
    bmesh.ops.create_icosphere(shape, subdivisions=1, radius=1)


def material(name, color):
    made = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0):
        made.use_nodes = True
    made.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (*color, 1)
    return made


def mesh(name, fill, look):
    made, shape = bpy.data.meshes.new(name), bmesh.new()
    fill(shape)
    shape.to_mesh(made)
    shape.free()
    made.materials.append(look)
    return made


def put(scene, name, data, place):
    ob = bpy.data.objects.new(name, data)
    ob.location = place
    scene.collection.objects.link(ob)
    return ob


def test_nothing_changed(follower, change):
    assert follower.sync() == change.NONE


def test_selecting_is_no_change(follower, change):
    bpy.data.objects["Ball"].select_set(True)
    assert follower.sync() == change.NONE


def test_moving_one_object_moves_one_instance(follower, change):
    bpy.data.objects["Left"].location.x -= 0.5
    assert follower.sync("set_transform") == change.GEOMETRY


def test_moving_the_camera_is_no_change(follower, change):
    bpy.context.scene.camera.location.x += 1
    assert follower.sync() == change.NONE


def test_moving_a_light(follower, change):
    bpy.data.objects["Lamp"].location.x += 1
    assert follower.sync(*LOOK) == change.LOOK


def test_the_energy_of_a_light(follower, change):
    bpy.data.lights["Lamp"].energy = 100
    assert follower.sync(*LOOK) == change.LOOK


def test_a_material_by_its_nodes(follower, change):
    nodes = bpy.data.materials["Red"].node_tree.nodes
    nodes["Principled BSDF"].inputs["Base Color"].default_value = (0, 1, 0, 1)
    assert follower.sync(*LOOK) == change.LOOK
    assert follower.live.materials.rows[0]["diffuse"] == (0, 1, 0)


def test_the_world(follower, change):
    world = bpy.data.worlds.new("World")
    if bpy.app.version < (5, 0):
        world.use_nodes = True
    bpy.context.scene.world = world
    assert follower.sync(*LOOK) == change.LOOK
    background = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value = (0, 0, 1, 1)
    assert follower.sync(*LOOK) == change.LOOK


def test_editing_a_shared_mesh_replaces_it_once(follower, change):
    data = bpy.data.meshes["Cube"]
    data.vertices[0].co.z += 1
    data.update()
    assert follower.sync("replace_mesh") == change.GEOMETRY


def test_a_modifier_replaces_its_own_mesh_only(follower, change):
    bpy.data.objects["Ball"].modifiers["Smooth"].levels = 2
    assert follower.sync("replace_mesh") == change.GEOMETRY


def test_a_modifier_parts_an_object_from_a_shared_mesh(follower, change):
    bpy.data.objects["Left"].modifiers.new("Bevel", "BEVEL")
    calls = ("add_mesh", "remove_instance", "add_instance")
    assert follower.sync(*calls) == change.GEOMETRY


def test_edit_mode_shows_what_is_edited(follower, change):
    ball = bpy.data.objects["Ball"]
    bpy.context.view_layer.objects.active = ball
    bpy.ops.object.mode_set(mode="EDIT")
    try:
        follower.sync(ANY)
        shape = bmesh.from_edit_mesh(ball.data)
        for vertex in shape.verts:
            vertex.co.x += 2
        bmesh.update_edit_mesh(ball.data)
        before = follower.picture(follower.live)
        assert follower.sync(ANY) == change.GEOMETRY
        assert not np.array_equal(before, follower.picture(follower.live))
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")
    follower.sync(ANY)


def test_another_material_in_a_slot(follower, change):
    bpy.data.meshes["Cube"].materials[0] = bpy.data.materials["Grey"]
    follower.sync(ANY)
    names = {follower.live.places[i].object for i in follower.live.places}
    assert names == {"Left", "Right", "Ball"}


def test_removing_and_adding_objects(follower, change):
    bpy.data.objects.remove(bpy.data.objects["Left"])
    assert follower.sync("remove_instance") == change.GEOMETRY
    put(bpy.context.scene, "Third", bpy.data.meshes["Cube"], (0, -2, 0))
    assert follower.sync("add_instance") == change.GEOMETRY


def test_ray_visibility_exchanges_the_instance(follower, change):
    bpy.data.objects["Left"].visible_camera = False
    assert follower.sync("remove_instance", "add_instance") == change.GEOMETRY


def test_an_object_squashed_flat_and_back(follower, change):
    ob = bpy.data.objects["Left"]
    ob.scale.z = 0
    assert follower.sync(ANY) == change.GEOMETRY
    ob.scale.z = 1
    assert follower.sync(ANY) == change.GEOMETRY


def test_instances_of_a_collection_move_one_by_one(follower, change):
    group = bpy.data.collections.new("Group")
    for place in ((0, 0, 0), (0, -2, 0)):
        ob = bpy.data.objects.new("Part", bpy.data.meshes["Cube"])
        ob.location = place
        group.objects.link(ob)
    empties = [put(bpy.context.scene, f"Empty {x}", None, (x, 0, 1)) for x in (-1, 3)]
    for empty in empties:
        empty.instance_type, empty.instance_collection = "COLLECTION", group
    assert follower.sync(*["add_instance"] * 4) == change.GEOMETRY
    empties[0].location.z += 1
    assert follower.sync(*["set_transform"] * 2) == change.GEOMETRY


def test_many_edits_in_any_order(follower):
    """Random edits, each followed by a comparison with a scene that is read anew."""
    random = np.random.default_rng(7)
    scene = bpy.context.scene
    for step in range(25):
        objects = [ob for ob in scene.objects if ob.type == "MESH"]
        ob = objects[random.integers(len(objects))]
        match random.integers(7):
            case 0:
                ob.location = random.uniform(-3, 3, 3)
            case 1:
                put(scene, f"New {step}", ob.data, random.uniform(-3, 3, 3))
            case 2:
                if len(objects) > 2:
                    bpy.data.objects.remove(ob)
            case 3:
                ob.data.transform(Matrix.Rotation(0.3, 4, "X"))
            case 4:
                ob.data = ob.data.copy()
            case 5:
                ob.hide_viewport = not ob.hide_viewport
            case 6:
                ob.data.materials.clear()
        follower.sync(ANY)


def test_an_error_reads_everything_anew(follower, change):
    bpy.data.lights["Lamp"].energy = float("inf")
    with pytest.raises(ValueError, match="Light 'Lamp': its intensity"):
        follower.sync(ANY)
    bpy.data.lights["Lamp"].energy = 100
    assert follower.sync(ANY) == change.GEOMETRY


def test_stopped_on_the_way(follower, change):
    bpy.data.objects["Left"].location.x -= 0.5
    bpy.context.view_layer.update()
    graph = bpy.context.evaluated_depsgraph_get()
    with pytest.raises(follower.core.Cancelled):
        follower.live.sync(graph, report=lambda done: done < 0.5)
    assert follower.sync(ANY) == change.GEOMETRY
