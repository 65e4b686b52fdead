# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The pixel probe by real clicks, and the boxes of the BVH, in a real viewport."""

import bpy
import numpy as np
from mathutils import Quaternion
from probing import add_camera, click_probe, click_render, hide_render, show_render
from test_overlay import heat_of, part, shown, stage, switch
from window import Gui

KINDS = ("primary", "shadow", "reflection", "refraction")


def busiest(gui: Gui) -> tuple[int, int]:
    """The pixel of the heatmap whose rays visit the most nodes."""
    values = heat_of(gui).picture.values
    y, x = np.unravel_index(values.argmax(), values.shape)
    return int(x), int(y)


def test_a_click_finds_what_the_heatmap_counts(gui: Gui):
    yield from stage(gui)
    switch(gui, True)
    gui.scene.whittle_overlay.samples = "4"
    picture = yield from shown(gui)
    region = gui.region("VIEW_3D")
    height, width = picture.values.shape
    assert (width, height) == (region.width, region.height)
    high = np.argwhere(picture.values[100:-100, 100:-100] > np.percentile(picture.values, 98)) + 100
    for y, x in high[:: len(high) // 4][:4]:
        found = yield from click_probe(gui, "VIEW_3D", int(x), int(y))
        total = sum(row[1] for row in found.counts().values())
        gui.report(f"pixel {x}, {y}: {len(found.rays)} rays, {total} nodes")
        assert found.pixel == (x, y) and total == picture.values[y, x]
    session = bpy.context.window_manager.whittle
    assert session.show_probe and len(session.rays) == len(found.rays)


def test_the_probe_can_be_cancelled(gui: Gui):
    yield from stage(gui)
    part("inspect.probe_overlay").show(None)
    with gui.override("VIEW_3D"):
        bpy.ops.whittle.probe("INVOKE_DEFAULT")
    yield 0.3
    yield from gui.key("ESC")
    x, y = gui.center()
    yield from gui.click(x, y)
    assert part("inspect.probe_overlay").current is None


def test_a_click_on_the_render_probes_its_pixel(gui: Gui):
    yield from stage(gui)
    add_camera(gui)
    render = gui.scene.render
    render.use_border, render.use_crop_to_border = True, True
    render.border_min_x, render.border_max_x = 0.25, 0.95
    render.border_min_y, render.border_max_y = 0.1, 0.9
    result = yield from show_render(gui)
    height, width = result.counters["nodes"].shape
    for u, v in ((0.35, 0.4), (0.5, 0.6), (0.8, 0.2)):
        found = yield from click_render(gui, u, v)
        column, row = found.pixel[0] - 80, found.pixel[1] - 20
        assert abs(column - u * width) <= 2 and abs(row - v * height) <= 2
        for kind in KINDS:
            _, nodes, triangles = found.counts().get(kind, (0, 0, 0))
            assert nodes == result.counters[f"nodes_{kind}"][row, column]
            assert triangles == result.counters[f"triangles_{kind}"][row, column]
        gui.report(f"pixel {found.pixel}: {found.counts()}")
    gui.screenshot("probe-render")
    yield from hide_render(gui)


def test_rays_are_drawn_in_the_colours_of_their_kinds(gui: Gui):
    yield from stage(gui)
    switch(gui, True)
    yield from shown(gui)
    found = yield from click_probe(gui, "VIEW_3D", *busiest(gui))
    assert {ray.kind for ray in found.rays} >= {"primary", "reflection", "refraction"}
    switch(gui, False)
    overlay = part("inspect.probe_overlay")
    session = bpy.context.window_manager.whittle
    gui.scene.whittle_overlay.probe_triangles = False
    gui.scene.whittle_overlay.probe_all = False
    data = gui.space().region_3d
    data.view_rotation.rotate(Quaternion((0, 0, 1), 0.7))
    for kind in dict.fromkeys(ray.kind for ray in found.rays):
        most = 0  # some rays are short, or end on: one of the kind must be there to see
        for index in (i for i, ray in enumerate(found.rays) if ray.kind == kind):
            session.ray_index = index
            yield from gui.redrawn()
            pixels = yield from gui.pixels()
            near = abs(pixels[..., :3] - overlay.COLORS[kind][:3]).max(axis=-1) < 0.06
            most = max(most, int(near.sum()))
            if most > 30:
                break
        gui.report(f"{kind}: {most} pixels")
        assert most > 30
    gui.screenshot("rays")


def test_boxes_drawn_are_those_asked_for(gui: Gui):
    yield from stage(gui)
    session, settings = bpy.context.window_manager.whittle, gui.scene.whittle_overlay
    bare = yield from gui.pixels()
    session.show_boxes = True
    settings.box_depth_min, settings.box_depth_max = 0, 3
    source, boxes = part("inspect.source").shared, part("inspect.box_overlay")
    yield from gui.redrawn()
    yield from gui.until(
        lambda: boxes.shown is not None and not source.building and not source.stale, "boxes"
    )
    yield from gui.redrawn()
    nodes = source.scene.nodes()
    level, wanted = [0], 0
    for _depth in range(4):
        wanted += len(level)
        inner = [i for i in level if nodes[i]["count"] == 0]
        level = [int(nodes[i]["left_first"]) + side for i in inner for side in (0, 1)]
    assert len(boxes.shown.chosen) == boxes.shown.asked == wanted
    drawn = yield from gui.pixels()
    gui.screenshot("boxes")
    changed = (abs(drawn - bare).max(axis=-1) > 0.05).sum()
    gui.report(f"{wanted} boxes change {changed} pixels")
    assert changed > 500
    settings.box_limit = 5
    yield from gui.redrawn()
    yield from gui.redrawn()
    assert len(boxes.shown.chosen) == 5 and boxes.shown.asked == wanted
    settings.box_selected, settings.box_limit, settings.box_depth_max = True, 10_000, 40
    bpy.ops.object.select_all(action="DESELECT")
    bpy.data.objects["Suzanne"].select_set(True)
    yield from gui.redrawn()
    yield from gui.redrawn()
    index = next(i for i, place in source.places.items() if place.object == "Suzanne")
    owners = source.scene.owners()["instance"]
    assert len(boxes.shown.chosen) == (owners == index).sum() > 100
    session.show_boxes = False


def test_boxes_of_the_probed_ray(gui: Gui):
    yield from stage(gui)
    session, settings = bpy.context.window_manager.whittle, gui.scene.whittle_overlay
    switch(gui, True)
    yield from shown(gui)
    x, y = busiest(gui)
    found = yield from click_probe(gui, "VIEW_3D", x, y)
    assert heat_of(gui).picture.values[y, x] == sum(len(ray.nodes) for ray in found.rays)
    session.show_boxes, settings.box_probed, settings.box_depth_max = True, True, 64
    for index in (0, len(found.rays) - 1):
        session.ray_index = index
        yield from gui.redrawn()
        yield from gui.redrawn()
        drawn = part("inspect.box_overlay").shown.chosen
        assert drawn.tolist() == sorted(set(found.rays[index].nodes)) and len(drawn) > 1


def test_the_tab_shows_everything(gui: Gui):
    yield from stage(gui)
    settings = gui.scene.whittle_overlay
    settings.show_legend, settings.opacity = True, 0.85
    switch(gui, True)
    yield from shown(gui)
    yield from click_probe(gui, "VIEW_3D", *busiest(gui))
    bpy.context.window_manager.whittle.show_boxes = True
    yield from gui.show_tab("Whittle")
    gui.screenshot("tab")
    yield from gui.full_area()
    yield from gui.show_tab("Whittle")
    yield 1.0
    gui.screenshot("tab-full")
    yield from gui.full_area()
