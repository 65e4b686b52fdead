# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine in Blender's real window: the Render button, F12, Esc, disabling and enabling."""

import bpy
import numpy as np
from window import PACKAGE, Gui, Steps

# Pixels below the top of the Render properties, with the engine chosen and an interface scale of 1.
RENDER_BUTTON = 82


def rendering() -> bool:
    return bpy.app.is_job_running("RENDER")


def finished(gui: Gui) -> Steps:
    """Waits for the end of a render; gives its result."""
    results = gui.package.results
    yield from gui.until(lambda: results.last and not rendering(), "the render ends")
    return results.last[0]


def saved(gui: Gui, name: str) -> np.ndarray:
    """The pixels of Render Result as they were rendered."""
    path = gui.folder / f"{name}.exr"
    settings = gui.scene.render.image_settings
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    bpy.data.images["Render Result"].save_render(str(path))
    image = bpy.data.images.load(str(path))
    pixels = np.empty(len(image.pixels), dtype=np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], -1)


def small(gui: Gui) -> Steps:
    """The start-up scene, rendered small; nothing rendered before."""
    yield from gui.fresh()
    gui.scene.render.resolution_x, gui.scene.render.resolution_y = 160, 100
    gui.package.results.last.clear()


def test_the_window_has_the_size_asked_for(gui: Gui):
    assert (gui.window.width, gui.window.height) == (1280, 800)
    yield 0.1


def test_a_click_on_the_render_button_renders(gui: Gui):
    yield from small(gui)
    yield from gui.show_properties("RENDER")
    region = gui.region("PROPERTIES")
    gui.screenshot("properties")
    yield from gui.click(region.x + region.width * 0.5, region.y + region.height - RENDER_BUTTON)
    result = yield from finished(gui)
    gui.screenshot("rendered")
    assert result.size == (160, 100) and result.render["rays"]["primary"] == 4 * 160 * 100
    pixels = saved(gui, "button")
    assert np.isfinite(pixels).all() and np.ptp(pixels[..., 0]) > 0.2
    with gui.override("IMAGE_EDITOR"):
        bpy.ops.render.view_cancel()
    yield 0.5


def test_f12_renders_the_same(gui: Gui):
    yield from small(gui)
    with gui.override("VIEW_3D"):
        bpy.ops.render.render()
    wanted = saved(gui, "operator")
    gui.package.results.last.clear()
    yield from gui.key("F12")
    yield from finished(gui)
    assert np.array_equal(saved(gui, "f12"), wanted)
    yield from gui.key("ESC", at=gui.center("IMAGE_EDITOR"))
    yield from gui.until(lambda: gui.shows("VIEW_3D"), "Esc brings the viewport back")


def test_esc_cancels_a_render(gui: Gui):
    yield from gui.fresh()
    gui.package.results.last.clear()
    gui.scene.whittle.samples = 1024
    yield from gui.key("F12")
    yield from gui.until(rendering, "F12 starts the render")
    yield 1.0
    assert rendering(), "the render was over before it could be cancelled: make it longer"
    gui.screenshot("cancelling")
    yield from gui.key("ESC", at=gui.center("IMAGE_EDITOR"))
    yield from gui.until(lambda: not rendering(), "Esc ends the render", timeout=10.0)
    assert not gui.package.results.last
    yield from gui.fresh()


def test_disabled_and_enabled_again(gui: Gui):
    yield from small(gui)
    gui.scene.whittle.samples = 9
    with gui.override("VIEW_3D"):
        bpy.ops.render.render()
    wanted = saved(gui, "before")
    bpy.ops.preferences.addon_disable(module=PACKAGE)
    yield 0.5
    assert not hasattr(bpy.types.Scene, "whittle")
    gui.screenshot("disabled")
    bpy.ops.preferences.addon_enable(module=PACKAGE)
    yield 0.5
    assert gui.scene.whittle.samples == 9 and gui.scene.render.engine == "WHITTLE"
    with gui.override("VIEW_3D"):
        bpy.ops.render.render()
    assert np.array_equal(saved(gui, "after"), wanted)
