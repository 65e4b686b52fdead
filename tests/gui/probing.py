# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The probe in the hands of tests: clicks on the viewport, and on a render in an image editor."""

import bpy
from test_overlay import part
from window import Gui, Steps


def click_probe(gui: Gui, kind: str, x: int, y: int) -> Steps:
    """Starts the probe and clicks a pixel of an editor's main region; what was found."""
    overlay = part("inspect.probe_overlay")
    overlay.show(None)
    with gui.override(kind):
        bpy.ops.whittle.probe("INVOKE_DEFAULT")
    yield 0.3
    region = gui.region(kind)
    yield from gui.click(region.x + x, region.y + y)
    yield from gui.until(lambda: overlay.current, "the click is probed", timeout=20.0)
    return overlay.current


def add_camera(gui: Gui) -> None:
    """A camera that sees the stage, for a render of 320 x 200 that counts 4 rays in a pixel."""
    scene = gui.scene
    bpy.ops.object.camera_add(location=(0, -9, 2), rotation=(1.4, 0, 0))
    scene.camera = bpy.context.object
    scene.render.resolution_x, scene.render.resolution_y = 320, 200
    scene.whittle.use_counters, scene.whittle.samples = True, 4


def show_render(gui: Gui) -> Steps:
    """Renders, and shows it in an image editor instead of the properties; the result's numbers."""
    with gui.override("VIEW_3D"):
        bpy.ops.render.render()
    gui.area("PROPERTIES").type = "IMAGE_EDITOR"
    yield 0.5
    gui.space("IMAGE_EDITOR").image = bpy.data.images["Render Result"]
    with gui.override("IMAGE_EDITOR"):
        bpy.ops.image.view_all(fit_view=True)
    yield 0.5
    return gui.package.results.last[0]


def click_render(gui: Gui, u: float, v: float) -> Steps:
    """Probes the render that is shown, at a place from (0, 0) to (1, 1) of it; what was found."""
    x, y = gui.region("IMAGE_EDITOR").view2d.view_to_region(u, v, clip=False)
    return (yield from click_probe(gui, "IMAGE_EDITOR", x, y))


def hide_render(gui: Gui) -> Steps:
    """The properties are back."""
    gui.area("IMAGE_EDITOR").type = "PROPERTIES"
    yield 0.3
