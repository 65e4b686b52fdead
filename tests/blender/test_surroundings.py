# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights, world and camera in the core's words."""

from math import pi

import bpy
import numpy as np
import pytest
from mathutils import Matrix, Vector


@pytest.fixture
def notes(scene):
    from addon.notes import Notes

    return Notes()


def light(kind, **values):
    """A light object with the given properties."""
    ob = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", kind))
    for name, value in values.items():
        setattr(ob.data, name, value)
    return ob


def exported(ob, notes, matrix=None):
    from addon.export import lights

    return lights.export(ob, matrix or Matrix(), notes)


def test_a_point_light_spreads_its_power_over_the_sphere(notes):
    ob = light("POINT", energy=100, color=(1, 0.5, 0.25), shadow_soft_size=0)
    row = exported(ob, notes, Matrix.Translation((1, 2, 3)))
    assert row["kind"] == "point" and row["position"] == (1, 2, 3) and row["shadow"]
    assert row["intensity"] == pytest.approx(np.array([100, 50, 25]) / (4 * pi))
    assert notes.lines() == []


def test_a_sun_shines_along_its_minus_z(notes):
    row = exported(light("SUN", energy=3, angle=0), notes, Matrix.Rotation(pi / 2, 4, "X"))
    assert row["kind"] == "sun" and row["intensity"] == (3, 3, 3)
    assert row["direction"] == pytest.approx((0, 1, 0), abs=1e-6)
    assert notes.lines() == []


def test_a_light_without_shadow(notes):
    assert not exported(light("POINT", use_shadow=False), notes)["shadow"]


def test_lights_that_are_not_understood_still_shine_and_are_named(notes):
    for kind in ("SPOT", "AREA"):
        assert min(exported(light(kind, energy=10), notes)["intensity"]) > 0
    assert [line for line in notes.lines() if "spot lights" in line]
    assert [line for line in notes.lines() if "area lights" in line]


def test_the_size_of_lights_is_said_once(notes):
    for _ in range(3):
        exported(light("POINT", shadow_soft_size=0.5), notes)
    assert notes.lines() == ["Lights have no size here: their shadows are sharp"]


@pytest.mark.skipif(bpy.app.version < (4, 5), reason="newer Blenders only")
def test_exposure_and_temperature(notes):
    plain = np.array(exported(light("POINT", energy=10), notes)["intensity"])
    brighter = exported(light("POINT", energy=10, exposure=2), notes)["intensity"]
    assert brighter == pytest.approx(4 * plain)
    warm = exported(light("POINT", energy=10, use_temperature=True, temperature=3000), notes)
    assert np.array(warm["intensity"]) / plain == pytest.approx([1.771, 0.844, 0.272], abs=2e-3)


def test_the_nodes_of_a_light_multiply_its_power(notes):
    ob = light("POINT", energy=4 * pi)
    if bpy.app.version < (5, 0):
        ob.data.use_nodes = True
    node = next(node for node in ob.data.node_tree.nodes if node.type == "EMISSION")
    node.inputs["Color"].default_value = (1, 0.5, 0.25, 1)
    node.inputs["Strength"].default_value = 2
    assert exported(ob, notes)["intensity"] == pytest.approx((2, 1, 0.5))


@pytest.fixture
def world(scene):
    world = bpy.data.worlds.new("World")
    scene.world = world
    if bpy.app.version < (5, 0):
        world.use_nodes = True
    node = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
    node.inputs["Color"].default_value = (1, 0.5, 0.25, 1)
    node.inputs["Strength"].default_value = 2
    return world


def sky(scene, notes):
    from addon.export import world

    return world.export(scene, notes)


def test_the_world_shines_and_lights(scene, notes, world):
    assert sky(scene, notes) == {"color": (2, 1, 0.5), "ambient": (2, 1, 0.5)}
    assert notes.lines() == ["The world lights diffuse surfaces evenly, without shadows"]


def test_the_world_lights_nothing_when_told(scene, notes, world):
    scene.whittle.use_ambient = False
    assert sky(scene, notes) == {"color": (2, 1, 0.5), "ambient": (0, 0, 0)}
    scene.whittle.use_ambient = True
    world.cycles_visibility.diffuse = False
    assert sky(scene, notes) == {"color": (2, 1, 0.5), "ambient": (0, 0, 0)}
    assert notes.lines() == []


def test_a_world_texture_is_named(scene, notes, world):
    texture = world.node_tree.nodes.new("ShaderNodeTexSky")
    background = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
    world.node_tree.links.new(texture.outputs[0], background.inputs["Color"])
    assert sky(scene, notes)["color"] == (2, 1, 0.5)
    assert len([line for line in notes.lines() if "'Sky Texture'" in line]) == 1


def shot(scene, notes, size):
    from addon.export import camera

    graph = bpy.context.evaluated_depsgraph_get()
    return camera.export(graph, scene.camera, size, (0, 0, *size), notes)


def seen(view, point):
    """Where a world point appears, in pixels from the lower left corner."""
    local = np.linalg.inv(view["to_world"]) @ np.append(point, 1)
    clip = view["projection"] @ local
    return (clip[:2] / clip[3] + 1) / 2 * (view["width"], view["height"])


@pytest.mark.parametrize("fit", ["AUTO", "HORIZONTAL", "VERTICAL"])
@pytest.mark.parametrize("size", [(200, 100), (100, 200)])
@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_a_camera_sees_points_where_blender_does(scene, notes, fit, size, kind):
    from bpy_extras.object_utils import world_to_camera_view

    data = scene.camera.data
    data.type, data.sensor_fit, data.shift_x, data.shift_y = kind, fit, 0.1, -0.2
    scene.camera.scale = (2, 2, 2)
    scene.camera.rotation_euler = (0.3, 0.2, 0.1)
    scene.render.resolution_x, scene.render.resolution_y = size
    bpy.context.view_layer.update()
    view = shot(scene, notes, size)
    for point in ((0, 0, 0), (1, 2, 3), (-2, 1, 0.5)):
        expected = world_to_camera_view(scene, scene.camera, Vector(point))
        assert seen(view, point) == pytest.approx(np.array(expected[:2]) * size, abs=0.02)


def test_what_a_camera_cannot_do_is_named(scene, notes):
    scene.camera.data.type = "PANO"
    scene.camera.data.dof.use_dof = True
    scene.render.use_motion_blur = True
    shot(scene, notes, (64, 40))
    assert len(notes.lines()) == 3
