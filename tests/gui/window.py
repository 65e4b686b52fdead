# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hands and eyes for Blender's real window: clicks, keys, screenshots, pixels.

Runs inside Blender. Whatever takes time is a generator that yields the seconds to wait, so that
Blender handles events and draws meanwhile: `yield from gui.click(x, y)`.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

import bpy
import gpu
import numpy as np
from numpy.typing import NDArray

Steps = Generator[float, None, Any]

PACKAGE = "bl_ext.user_default.whittle"
SETTLE = 0.15  #: seconds that Blender gets to handle an event
MOVES = 4  #: of a drag, when not said otherwise

# By its name, Xvfb's keyboard sends F12 with Alt: here it is the code of the key.
KEYS = {"F12": "96", "ESC": "Escape", "TAB": "Tab"}


class Gui:
    """The first window of Blender. Coordinates are pixels of it, from the lower left corner."""

    def __init__(self, folder: Path, extension: Path) -> None:
        self.folder = folder
        self.extension = extension
        self.printed: list[str] = []

    # ---- What is there ----

    @property
    def window(self) -> bpy.types.Window:
        return bpy.context.window_manager.windows[0]

    @property
    def scene(self) -> bpy.types.Scene:
        return self.window.scene

    @property
    def package(self) -> Any:
        """The extension, as Blender imported it."""
        return sys.modules[PACKAGE]

    def shows(self, kind: str) -> bool:
        """Whether there is an area of a type."""
        return any(area.type == kind for area in self.window.screen.areas)

    def area(self, kind: str) -> bpy.types.Area:
        """The largest area of a type such as "VIEW_3D"."""
        found = [area for area in self.window.screen.areas if area.type == kind]
        assert found, f"no {kind} in {[area.type for area in self.window.screen.areas]}"
        return max(found, key=lambda area: area.width * area.height)

    def region(self, kind: str, region: str = "WINDOW") -> bpy.types.Region:
        """A region of the largest area of a type: "WINDOW", "UI" (the N-panel), ..."""
        return next(found for found in self.area(kind).regions if found.type == region)

    def space(self, kind: str = "VIEW_3D") -> bpy.types.Space:
        return self.area(kind).spaces.active

    def override(self, kind: str = "VIEW_3D") -> Any:
        """A context for operators that want an area: `with gui.override("VIEW_3D"): ...`."""
        return bpy.context.temp_override(
            window=self.window, area=self.area(kind), region=self.region(kind)
        )

    def center(self, kind: str = "VIEW_3D") -> tuple[int, int]:
        region = self.region(kind)
        return region.x + region.width // 2, region.y + region.height // 2

    def report(self, *words: Any) -> None:
        """Prints a line, here and in the summary of the tests."""
        line = " ".join(str(word) for word in words)
        self.printed.append(line)
        print(line, flush=True)

    # ---- Waiting ----

    def until(
        self, condition: Callable[[], Any], what: str, timeout: float = 60.0, step: float = 0.02
    ) -> Steps:
        """Waits for something to be true, and gives it; an AssertionError says what never was."""
        end = time.monotonic() + timeout
        while not (value := condition()):
            assert time.monotonic() < end, f"waited {timeout:g} s in vain: {what}"
            yield step
        return value

    def redrawn(self, kind: str = "VIEW_3D") -> Steps:
        """Asks for an area to be drawn, and gives it time to be."""
        self.area(kind).tag_redraw()
        yield SETTLE

    # ---- Hands ----

    def move(self, x: float, y: float) -> Steps:
        """Moves the pointer there."""
        self._point(x, y)
        yield SETTLE

    def _point(self, x: float, y: float) -> None:
        left, top = self._corner()
        x_tool("mousemove", left + int(x), top + self.window.height - 1 - int(y))

    def _corner(self) -> tuple[int, int]:
        """Where the window's upper left corner is on the screen; Blender knows it only roughly."""
        words = ["xdotool", "getwindowgeometry", "--shell", _window_id()]
        text = subprocess.run(words, capture_output=True, text=True, check=True).stdout
        place = dict(line.split("=") for line in text.split())
        return int(place["X"]), int(place["Y"])

    def click(self, x: float, y: float, button: int = 1) -> Steps:
        """A real click: 1 left, 2 middle, 3 right."""
        yield from self.move(x - 3, y)
        yield from self.move(x, y)
        x_tool("mousedown", button)
        yield SETTLE
        x_tool("mouseup", button)
        yield 2 * SETTLE

    def drag(
        self,
        start: tuple[float, float],
        end: tuple[float, float],
        button: int = 1,
        moves: int = MOVES,
        wait: float = SETTLE,
    ) -> Steps:
        """Presses at the start, moves in steps, and lets go at the end."""
        yield from self.move(*start)
        x_tool("mousedown", button)
        yield SETTLE
        for step in range(1, moves + 1):
            self._point(*(a + (b - a) * step / moves for a, b in zip(start, end, strict=True)))
            yield wait
        x_tool("mouseup", button)
        yield 2 * SETTLE

    def key(self, name: str, at: tuple[float, float] | None = None) -> Steps:
        """Presses a key over a place, the middle of the largest 3D viewport if none is given."""
        yield from self.move(*(at or self.center()))
        x_tool("windowfocus", "--sync", _window_id())
        yield SETTLE
        x_tool("key", KEYS.get(name, name))
        yield 2 * SETTLE

    # ---- Places to click ----

    def show_tab(self, category: str) -> Steps:
        """Opens the 3D viewport's N-panel at a tab."""
        self.space().show_region_ui = True
        yield from self.redrawn()
        tabs = "active_panel_category"  # Blender 4 has none before they were drawn

        def drawn() -> bool:
            self.area("VIEW_3D").tag_redraw()
            return not self.region("VIEW_3D", "UI").is_property_readonly(tabs)

        yield from self.until(drawn, "the tabs are drawn", timeout=20.0, step=SETTLE)
        setattr(self.region("VIEW_3D", "UI"), tabs, category)
        yield from self.redrawn()
        yield SETTLE

    def show_properties(self, context: str) -> Steps:
        """Shows a tab of the Properties editor, such as "RENDER"."""
        self.space("PROPERTIES").context = context
        yield from self.redrawn("PROPERTIES")
        yield SETTLE

    def full_area(self, kind: str = "VIEW_3D") -> Steps:
        """Lets an area fill the window, without headers and panels; a second time takes it back."""
        with self.override(kind):
            bpy.ops.screen.screen_full_area(use_hide_panels=True)
        yield 4 * SETTLE

    def shade(self, kind: str) -> Steps:
        """Shades the 3D viewport: "SOLID", "MATERIAL" or "RENDERED"."""
        self.space().shading.type = kind
        yield from self.redrawn()

    def fresh(self, engine: str = "WHITTLE") -> Steps:
        """Blender's own start-up scene, with an engine chosen."""
        bpy.ops.wm.read_homefile(use_factory_startup=True, load_ui=True)
        yield 4 * SETTLE
        self.scene.render.engine = engine
        yield SETTLE

    # ---- Eyes ----

    def screenshot(self, name: str) -> Path:
        """The window as a PNG in the folder of the run."""
        path, window = self.folder / f"{name}.png", self.window
        left, top = self._corner()
        place = f"{left},{top},{window.width},{window.height}"
        subprocess.run(["scrot", "-o", "-a", place, str(path)], check=True)
        return path

    def screen_pixels(self, kind: str = "VIEW_3D") -> Steps:
        """What the screen shows of an area's region: uint8 as float32 (height, width, 3), row 0 at
        the bottom. Nothing must lie over it, the pointer included."""
        yield from self.move(self.window.width - 2, 2)
        yield from self.redrawn(kind)
        yield SETTLE
        image = bpy.data.images.load(str(self.screenshot("screen")))
        image.colorspace_settings.name = "Non-Color"
        width, height = image.size
        pixels = np.empty(width * height * image.channels, dtype=np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
        pixels = pixels.reshape(height, width, -1)[..., :3] * 255
        region = self.region(kind)
        return np.rint(
            pixels[region.y : region.y + region.height, region.x : region.x + region.width]
        )

    def pixels(self, kind: str = "VIEW_3D") -> Steps:
        """What is drawn in a viewport's region: float32 (height, width, 4), row 0 at the bottom.

        The numbers are those of the frame buffer when all has been drawn but the window's own
        decorations: overlays that were drawn before are in it."""
        region, found = self.region(kind), []

        def read() -> None:
            if bpy.context.region == region:
                found.append(_frame_buffer())

        space = type(self.space(kind))
        handle = space.draw_handler_add(read, (), "WINDOW", "POST_PIXEL")
        try:
            self.area(kind).tag_redraw()
            yield from self.until(lambda: found, "the region is drawn", timeout=20.0)
        finally:
            space.draw_handler_remove(handle, "WINDOW")
        return found[-1]


def _frame_buffer() -> NDArray[np.float32]:
    x, y, width, height = gpu.state.viewport_get()
    buffer = gpu.state.active_framebuffer_get().read_color(x, y, width, height, 4, 0, "FLOAT")
    # Of what Blender 4 calls several dimensions numpy reads the red of each pixel only.
    buffer.dimensions = height * width * 4
    return np.array(buffer, dtype=np.float32).reshape(height, width, 4)


def x_tool(*words: object) -> None:
    """Moves the pointer or presses buttons and keys, in xdotool's words."""
    subprocess.run(["xdotool", *map(str, words)], check=True)


def _window_id() -> str:
    command = ["xdotool", "search", "--onlyvisible", "--name", "Blender"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()[0]
