# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders through Blender: light, passes, regions, layers, settings."""

from math import pi

import bpy
import numpy as np
import pictures
import pytest


@pytest.fixture
def plane(scene):
    """A white diffuse plane at z = 0, as wide as the camera sees."""
    bpy.ops.mesh.primitive_plane_add(size=8)
    return bpy.context.object


def lamp(scene, kind="POINT", **values):
    data = bpy.data.lights.new("Lamp", kind)
    ob = bpy.data.objects.new("Lamp", data)
    scene.collection.objects.link(ob)
    for name, value in values.items():
        setattr(ob if name == "location" else data, name, value)
    return ob


@pytest.fixture
def render(scene, addon, tmp_path):
    """Renders the scene; gives the passes of a view layer as its multilayer EXR holds them."""

    def run(layer="ViewLayer"):
        bpy.ops.render.render()
        addon.batch.set_format(scene.render.image_settings, "OPEN_EXR_MULTILAYER")
        scene.render.image_settings.color_depth = "32"
        path = tmp_path / "image.exr"
        bpy.data.images["Render Result"].save_render(str(path))
        return pictures.layer(path, layer)

    return run


def centre(image):
    return image[image.shape[0] // 2, image.shape[1] // 2]


def test_a_point_lights_a_plane_as_in_cycles(scene, plane, render):
    lamp(scene, energy=1000, location=(0, 0, 3), color=(1, 0.5, 0.25))
    found = centre(render()["Combined"])
    expected = 0.8 * 1000 / (4 * pi**2 * 3**2)
    assert found == pytest.approx([expected, expected / 2, expected / 4, 1], rel=2e-3)


def test_a_sun_lights_a_plane_as_in_cycles(scene, plane, render):
    lamp(scene, "SUN", energy=5).rotation_euler = (0.5, 0, 0)
    found = centre(render()["Combined"])
    assert found[:3] == pytest.approx([0.8 * 5 * np.cos(0.5) / pi] * 3, rel=1e-5)


def test_the_world_is_seen_and_lights(scene, plane, render):
    scene.world = bpy.data.worlds.new("World")
    if bpy.app.version < (5, 0):
        scene.world.use_nodes = True
    background = next(node for node in scene.world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value = (0.5, 0.25, 1, 1)
    plane.scale = (0.1, 0.1, 1)
    image = render()["Combined"]
    assert image[0, 0] == pytest.approx([0.5, 0.25, 1, 1])
    assert centre(image) == pytest.approx([0.4, 0.2, 0.8, 1], rel=1e-5)


def test_a_transparent_film_leaves_the_background_empty(scene, plane, render):
    plane.scale = (0.1, 0.1, 1)
    lamp(scene, energy=1000, location=(0, 0, 3))
    scene.render.film_transparent = True
    image = render()["Combined"]
    assert (image[0, 0] == 0).all()
    assert centre(image)[3] == 1 and centre(image)[0] > 0


def test_passes_hold_what_they_say(scene, plane, render, addon):
    layer = scene.view_layers[0]
    for name in ("z", "position", "normal", "object_index"):
        setattr(layer, f"use_pass_{name}", True)
    scene.whittle.use_counters = True
    scene.whittle.mode = "LECTURE"
    plane.pass_index = 7
    plane.location.z = 2
    plane.scale = (0.5, 0.5, 1)
    lamp(scene, energy=100, location=(0, 0, 6))
    passes = render()
    names = {row.name for row in addon.passes.PASSES}
    assert set(passes) == names
    assert centre(passes["Depth"]) == pytest.approx(8) and passes["Depth"][0, 0] == 1e10
    assert centre(passes["Position"])[2] == pytest.approx(2)
    assert centre(passes["Normal"]) == pytest.approx([0, 0, 1])
    assert centre(passes["Object Index"]) == 7 and passes["Object Index"][0, 0] == 0
    # Depth is along the view, not along the ray.
    hit = passes["Object Index"] == 7
    assert np.ptp(passes["Depth"][hit]) < 1e-4
    counters = addon.results.last[0].counters
    for row in addon.passes.COUNTERS:
        assert np.array_equal(passes[row.name], counters[row.source])
    for kind in ("Nodes", "Triangles"):
        total = sum(
            passes[f"{kind} {k}"] for k in ("Primary", "Shadow", "Reflection", "Refraction")
        )
        assert np.array_equal(passes[kind], total) and passes[kind].sum() > 0
    assert passes["Leaf Depth"].max() >= 0 < passes["Seconds"].min()
    assert 0 < passes["Coherence"].min() <= passes["Coherence"].max() <= 1


def test_only_the_passes_asked_for_exist(scene, plane, render):
    assert set(render()) == {"Combined"}


def test_coherence_exists_only_where_packets_count_it(scene, plane, render):
    scene.whittle.use_counters = True
    for mode in ("FAST", "LECTURE", "SINGLE"):
        scene.whittle.mode = mode
        found = render()
        assert ("Coherence" in found) == (mode == "LECTURE") and "Leaf Depth" in found


@pytest.fixture
def busy(scene, plane):
    """A picture whose pixels all differ a little."""
    lamp(scene, energy=700, location=(1.3, -0.7, 2))
    bpy.ops.mesh.primitive_monkey_add(location=(0.3, 0.2, 1))
    scene.whittle.samples = 4
    return scene


BORDERS = [
    (0.25, 0.5, 0.5, 1.0),
    (0.1, 0.3, 0.7, 0.9),
    (0.0, 0.0, 1 / 3, 2 / 3),
    (0.3333, 0.123, 0.9, 0.5),
    (0.5, 0.5, 0.6, 0.6),
]


@pytest.mark.parametrize("size", [(64, 40), (77, 53), (101, 67)])
@pytest.mark.parametrize("border", BORDERS)
def test_a_border_holds_the_same_bits_as_the_whole_picture(busy, render, size, border):
    settings = busy.render
    settings.resolution_x, settings.resolution_y = size
    whole = render()["Combined"]
    settings.use_border = True
    settings.border_min_x, settings.border_max_x = border[0], border[2]
    settings.border_min_y, settings.border_max_y = border[1], border[3]
    inside = render()["Combined"]
    assert inside.shape == whole.shape
    lit = np.argwhere(inside[..., 3] > 0)
    (y0, x0), (y1, x1) = lit.min(axis=0), lit.max(axis=0) + 1
    assert np.array_equal(inside[y0:y1, x0:x1], whole[y0:y1, x0:x1])
    area = (border[2] - border[0]) * size[0] * (border[3] - border[1]) * size[1]
    assert abs((y1 - y0) * (x1 - x0) - area) <= size[0] + size[1]
    settings.use_crop_to_border = True
    cropped = render()["Combined"]
    assert np.array_equal(cropped, whole[y0:y1, x0:x1])


def test_a_border_with_no_pixel_is_an_error(busy, render):
    busy.render.use_border = True
    busy.render.border_min_x, busy.render.border_max_x = 0.5, 0.5001
    with pytest.raises(RuntimeError):
        render()


def test_resolution_percentage(busy, render):
    busy.render.resolution_percentage = 50
    assert render()["Combined"].shape == (20, 32, 4)


def test_view_layers_show_their_own_collections(busy, render):
    collection = bpy.data.collections.new("Second only")
    busy.collection.children.link(collection)
    ball = bpy.data.objects["Suzanne"]
    collection.objects.link(ball)
    busy.collection.objects.unlink(ball)
    busy.view_layers.new("Second")
    busy.view_layers["ViewLayer"].layer_collection.children["Second only"].exclude = True
    busy.view_layers["Second"].use_pass_z = True
    first, second = render(), None
    second = render("Second")
    assert set(first) == {"Combined"} and set(second) == {"Combined", "Depth"}
    assert not np.array_equal(first["Combined"], second["Combined"])
    assert second["Depth"].min() < 9.5


def test_the_result_tells_the_last_frame(busy, render, addon):
    busy.render.threads_mode, busy.render.threads = "FIXED", 1
    render()
    (result,) = addon.results.last
    assert result.build["triangles"] == 2 + 968 and result.build["meshes"] == 2
    assert result.render["threads"] == 1 and result.build["threads"] == 1
    assert result.render["rays"]["primary"] == 64 * 40 * 4
    assert result.size == (64, 40) and min(result.seconds.values()) > 0
    assert '"primary": 10240' in addon.results.to_json([result])
    names = dict(addon.panels.numbers(result))
    assert names["Triangles"] == "970" and names["Primary Rays"] == "10,240"
    tracing = result.tracing()
    assert list(tracing) == ["primary", "shadow", "secondary", "shade"]
    assert tracing["primary"] > 0 and tracing["shade"] > 0
    assert sum(tracing.values()) == pytest.approx(result.seconds["trace"])
    assert names["    Shadow"] == f"{tracing['shadow']:.3f} s"
    assert names["Hand Over"] == f"{result.seconds['hand_over']:.3f} s" and "Judge" not in names
    busy.whittle.use_counters = True
    render()
    (result,) = addon.results.last
    assert dict(addon.panels.numbers(result))["Judge"] == f"{result.seconds['judge']:.3f} s"


def test_the_binary_tree_is_kept_only_to_count_on(busy, render, addon):
    settings, held = busy.whittle, {}
    for counters, mode in ((False, "FAST"), (False, "SINGLE"), (True, "FAST"), (False, "LECTURE")):
        settings.use_counters, settings.mode = counters, mode
        render()
        build = addon.results.last[0].build
        held[counters, mode] = build["bytes_nodes"]
    assert held[False, "FAST"] == held[False, "SINGLE"] > 0
    assert held[True, "FAST"] == held[False, "LECTURE"]
    assert held[True, "FAST"] - held[False, "FAST"] == build["bytes_binary"] == 32 * build["nodes"]


def test_dropped_triangles_are_named(busy, render, addon):
    mesh = bpy.data.meshes.new("Broken")
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (float("nan"), 0, 0)]
    mesh.from_pydata(points, [], [(0, 1, 2), (0, 1, 3), (0, 1, 1)])
    busy.collection.objects.link(bpy.data.objects.new("Broken", mesh))
    render()
    notes = [line for line in addon.results.last[0].notes if "Broken" in line]
    assert notes == ["Dropped triangles of Broken: 1 not finite and 1 without area"]


def test_frame_step_and_camera_markers(busy, addon, tmp_path):
    busy.frame_start, busy.frame_end, busy.frame_step = 1, 5, 2
    other = bpy.data.objects.new("Other", bpy.data.cameras.new("Other"))
    other.location = (0, 0, 20)
    busy.collection.objects.link(other)
    first = busy.camera
    busy.timeline_markers.new("start", frame=1).camera = first
    busy.timeline_markers.new("cut", frame=3).camera = other
    busy.render.filepath = str(tmp_path / "f_####")
    busy.render.image_settings.file_format = "PNG"
    bpy.ops.render.render(animation=True)
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["f_0001.png", "f_0003.png", "f_0005.png"]
    first, third, fifth = sorted(tmp_path.iterdir())
    assert not pictures.same(first, third) and pictures.same(third, fifth)


@pytest.mark.parametrize("phase", ["export", "build", "trace"])
def test_esc_leaves_no_result_and_no_error(busy, addon, monkeypatch, phase):
    monkeypatch.setattr(addon.progress.Progress, "report", lambda self, now, done: now != phase)
    busy.whittle.samples = 400
    bpy.ops.render.render()
    assert addon.results.last == []


def test_progress_is_told_in_order(busy, addon):
    heard = []

    def listener(phase, fraction):
        heard.append((phase, fraction))

    addon.progress.listeners.append(listener)
    try:
        bpy.ops.render.render()
    finally:
        addon.progress.listeners.remove(listener)
    phases = [phase for phase, _ in heard]
    assert phases == sorted(phases, key=["export", "build", "trace"].index) and phases
    assert all(0 <= fraction <= 1 for _, fraction in heard)


def test_settings_survive_disabling_and_enabling(busy, addon):
    busy.whittle.samples, busy.whittle.max_depth, busy.whittle.pattern = 16, 3, "STRATIFIED"
    addon.unregister()
    addon.register()
    found = busy.whittle
    assert (found.samples, found.max_depth, found.pattern) == (16, 3, "STRATIFIED")


def test_presets_of_the_build_are_numbers_of_bins(busy):
    settings = busy.whittle
    assert (settings.build_preset, settings.bins) == ("STANDARD", 16)
    for preset, bins in (("PREVIEW", 8), ("FINAL", 64), ("CUSTOM", 64), ("STANDARD", 16)):
        settings.build_preset = preset
        assert settings.bins == bins
    settings.bins = 17
    assert settings.build_preset == "CUSTOM"
    settings.bins = 64
    assert settings.build_preset == "FINAL"


@pytest.mark.parametrize(
    "name, value",
    [
        ("samples", 0),
        ("samples", -1),
        ("samples", 65**2),
        ("seed", -1),
        ("max_depth", -1),
        ("cutoff", -1.0),
        ("cutoff", 2.0),
        ("cutoff", float("nan")),
        ("bins", 65),
    ],
)
def test_a_setting_out_of_its_range_is_an_error_that_names_it(busy, name, value):
    setattr(busy.whittle, name, value)
    with pytest.raises(RuntimeError, match=name):
        bpy.ops.render.render()


def test_settings_can_be_animated(busy, addon):
    busy.whittle.keyframe_insert("samples", frame=1)
    busy.whittle.samples = 16
    busy.whittle.keyframe_insert("samples", frame=3)
    for frame, samples in ((1, 4), (3, 16)):
        busy.frame_set(frame)
        bpy.ops.render.render()
        (result,) = addon.results.last
        assert result.frame == frame
        assert result.render["rays"]["primary"] == 64 * 40 * samples


def test_the_compositor_gets_the_passes(busy):
    busy.whittle.use_counters = True
    bpy.context.view_layer.update()
    if bpy.app.version >= (5, 0):
        tree = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
        busy.compositing_node_group = tree
    else:
        busy.use_nodes = True
        tree = busy.node_tree
    node = tree.nodes.new("CompositorNodeRLayers")
    names = {socket.name for socket in node.outputs if socket.enabled}
    assert {"Image", "Nodes", "Triangles Shadow"} <= names
