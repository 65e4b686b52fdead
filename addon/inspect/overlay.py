# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws what is switched on over 3D viewports, and has what they need made in the background."""

from typing import Any

import bpy

from . import box_overlay, draw, legend, probe_overlay, source
from .heat import Picture
from .heat_overlay import HeatOverlay

TICK = 0.01  # seconds between two looks at what runs in the background
IDLE = 0.1  # seconds, while nothing but the clock is waited for

viewports: dict[int, HeatOverlay] = {}
"""Those that were drawn, by the address of their region."""

_handles: list[Any] = []
_seen: tuple[int, str] = (0, "")  # generation and error of the scene, when the timer last looked


def active(context: bpy.types.Context) -> bool:
    """Whether the viewport that is drawn shows any overlay of ours."""
    space = context.space_data
    return _switched_on() and space.overlay.show_overlays


def _switched_on() -> bool:
    session = bpy.context.window_manager.whittle
    return session.show_heat or session.show_boxes or session.show_probe


def draw_world() -> None:
    """Draw handler, where the viewport's own overlays have been drawn."""
    context = bpy.context
    if not active(context):
        if viewports and not _switched_on():
            _wake()  # the timer lets go of them
        return
    session = context.window_manager.whittle
    entry = viewports.setdefault(context.region.as_pointer(), HeatOverlay())
    if session.show_heat:
        entry.want(context)
        entry.paint(context.scene.whittle_overlay)
    if session.show_boxes:
        box_overlay.paint(context)
    if session.show_probe:
        probe_overlay.paint(context)
    _wake()


def draw_legends() -> None:
    """Draw handler in pixels of the region, after all else."""
    context = bpy.context
    if not active(context):
        return
    scale = context.preferences.system.ui_scale
    x, y = _corner(context.area, context.region, scale)
    for item in _legends(context):
        if item is not None:
            y += legend.paint(item, x, y, scale) + 6.0 * scale


def _legends(context: bpy.types.Context) -> list[legend.Legend | None]:
    """From the bottom up."""
    session, settings = context.window_manager.whittle, context.scene.whittle_overlay
    entry = viewports.get(context.region.as_pointer())
    found = []
    if session.show_heat and entry is not None:
        found.append(entry.legend(settings))
    if session.show_boxes and settings.show_legend:
        found.append(box_overlay.explain(settings))
    if session.show_probe and settings.show_legend:
        found.append(probe_overlay.explain(context))
    return found


def picture_of(context: bpy.types.Context) -> Picture | None:
    """The heatmap of the viewport that a panel or operator belongs to."""
    area = context.area
    if area is None or area.type != "VIEW_3D":
        return None
    for region in area.regions:
        entry = viewports.get(region.as_pointer())
        if entry is not None:
            return entry.heat.picture
    return None


def _corner(area: bpy.types.Area, region: bpy.types.Region, scale: float) -> tuple[float, float]:
    """Where legends stand: beside the toolbar, at the bottom."""
    x = 16.0 * scale
    for other in area.regions:
        left = region.x <= other.x < region.x + region.width / 2
        if other.type in ("TOOLS", "UI") and other.width > 1 and left:
            x = max(x, other.x + other.width - region.x + 10.0 * scale)
    return x, 16.0 * scale


def _wake() -> None:
    if not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=0.0, persistent=True)


def _tick() -> float | None:
    """Timer: one step of everything in the background; None ends it until something is drawn."""
    if not _switched_on():
        _let_go()
        return None
    regions = _regions()
    for address in [key for key in viewports if key not in regions]:
        viewports.pop(address).heat.cancel()
    source.shared.poll()
    waiting = any([_read(regions[address][1]) for address in viewports])
    changed, busy = _new_scene(), False
    for address, entry in viewports.items():
        area = regions[address][0]
        if not bpy.context.window_manager.whittle.show_heat:
            entry.heat.clear()
        fresh = source.shared.scene is not None and entry.heat.step(source.shared.scene)
        if fresh or changed or source.shared.building:
            area.tag_redraw()
        busy |= entry.heat.busy
    if busy or source.shared.building:
        return TICK
    return IDLE if waiting else None


def _new_scene() -> bool:
    """Whether the scene has become another one, or has failed, since this was asked last."""
    global _seen
    before, _seen = _seen, (source.shared.generation, source.shared.error)
    return before != _seen


def _regions() -> dict[int, tuple[bpy.types.Area, bpy.types.Window]]:
    """The main regions of all 3D viewports that are open, by their address."""
    return {
        region.as_pointer(): (area, window)
        for window in bpy.context.window_manager.windows
        for area in window.screen.areas
        if area.type == "VIEW_3D"
        for region in area.regions
        if region.type == "WINDOW"
    }


def _read(window: bpy.types.Window) -> bool:
    """Reads the window's scene if it is time; whether it will be, later."""
    scene, shared = window.scene, source.shared
    automatic = scene.whittle_overlay.automatic and not window.screen.is_animation_playing
    if shared.wants_reading((scene.name, window.view_layer.name), automatic):
        with bpy.context.temp_override(window=window):
            shared.read(bpy.context.evaluated_depsgraph_get())
    return shared.stale and automatic and shared.quick


def _let_go() -> None:
    for entry in viewports.values():
        entry.heat.cancel()
    viewports.clear()


def _stop_tracing() -> None:
    for entry in viewports.values():
        entry.heat.stop()


def register() -> None:
    source.shared.busy.append(_stop_tracing)
    add = bpy.types.SpaceView3D.draw_handler_add
    _handles.append(add(draw_world, (), "WINDOW", "POST_VIEW"))
    _handles.append(add(draw_legends, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
    _let_go()
    source.shared.busy.remove(_stop_tracing)
    box_overlay.forget()
    probe_overlay.forget()
    draw.forget()
