# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The guide's pictures of overlays and panels, from the demo scene: screenshots of the run."""

import bpy
import numpy as np
from mathutils import Vector
from probing import click_probe
from test_overlay import PATIENCE, heat_of, part, shown, switch
from window import Gui, Steps


def demo(gui: Gui) -> Steps:
    """The demo scene much as its camera sees it, with the Whittle tab open."""
    yield from gui.fresh()
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    part("demo").build(gui.scene)
    gui.space().lens = 42.0
    yield from look(gui, Vector((-0.5, -12.5, 4.6)), Vector((1.1, 0.0, 0.6)))
    gui.space().overlay.show_cursor = gui.space().overlay.show_extras = False
    bpy.ops.object.select_all(action="DESELECT")
    yield from gui.show_tab("Whittle")


def look(gui: Gui, eye: Vector, target: Vector) -> Steps:
    data = gui.space().region_3d
    data.view_rotation = (eye - target).to_track_quat("Z", "Y")
    data.view_location, data.view_distance = target, (eye - target).length
    yield from gui.redrawn()


def collapse(gui: Gui, below_top: int) -> Steps:
    """Closes the panel of the tab whose header lies so many pixels below the region's top."""
    tab = gui.region("VIEW_3D", "UI")
    yield from gui.click(tab.x + 60, tab.y + tab.height - below_top)


def changed(before: np.ndarray, after: np.ndarray) -> int:
    return int((abs(after - before).max(axis=-1) > 0.05).sum())


def test_overlay(gui: Gui):
    yield from demo(gui)
    bare = yield from gui.pixels()
    switch(gui, True)
    yield from shown(gui)
    yield 0.5
    gui.screenshot("overlay")
    assert changed(bare, (yield from gui.pixels())) > 100_000


def test_boxes(gui: Gui):
    yield from demo(gui)
    session, settings = bpy.context.window_manager.whittle, gui.scene.whittle_overlay
    yield from look(gui, Vector((-2.0, -8.0, 4.0)), Vector((-0.6, 0.0, 1.5)))
    bare = yield from gui.pixels()
    suzanne = next(ob for ob in gui.scene.objects if "Suzanne" in ob.name)
    suzanne.select_set(True)
    session.show_boxes, settings.box_selected = True, True
    settings.box_depth_min, settings.box_depth_max = 3, 14
    boxes = part("inspect.box_overlay")
    yield from gui.until(lambda: boxes.shown is not None, "boxes", timeout=PATIENCE)
    yield 1.0
    gui.screenshot("boxes")
    gui.report(len(boxes.shown.chosen), "boxes")
    assert changed(bare, (yield from gui.pixels())) > 5_000
    session.show_boxes = False


def test_probe(gui: Gui):
    yield from demo(gui)
    switch(gui, True)
    yield from shown(gui)
    values = heat_of(gui).picture.values.copy()
    values[:260, :460] = 0  # below the legend
    values[:, 700:] = 0  # below the panel
    y, x = np.argwhere(values > 0.6 * values.max())[0]
    found = yield from click_probe(gui, "VIEW_3D", int(x), int(y))
    assert len(found.rays) > 10
    switch(gui, False)
    yield from collapse(gui, below_top=131)  # the heatmap's panel: there is no room for both
    yield from look(gui, Vector((-4.5, -9.0, 6.0)), Vector((0.6, 0.0, 0.9)))
    session = bpy.context.window_manager.whittle
    session.ray_index = 1
    yield 0.5
    gui.screenshot("probe")


def test_panel(gui: Gui):
    """The Render properties beside a heatmap of the last render."""
    yield from gui.fresh()
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    scene = gui.scene
    part("demo").build(scene)
    scene.render.resolution_percentage, scene.whittle.samples = 75, 1
    scene.whittle.use_counters = True
    with gui.override("VIEW_3D"):
        bpy.ops.render.render()
    for kind in ("OUTLINER", "DOPESHEET_EDITOR"):
        with gui.override(kind):
            bpy.ops.screen.area_close()
        yield 0.3
    gui.area("VIEW_3D").type = "IMAGE_EDITOR"
    yield 0.5
    edge = gui.area("PROPERTIES").x - 1
    yield from gui.drag((edge, 300), (edge - 130, 300))
    bpy.ops.whittle.heatmaps()
    assert gui.space("IMAGE_EDITOR").image == bpy.data.images["Whittle Nodes"]
    with gui.override("IMAGE_EDITOR"):
        bpy.ops.image.view_all(fit_view=True)
    yield 0.5
    yield from gui.show_properties("RENDER")
    gui.screenshot("panel")
