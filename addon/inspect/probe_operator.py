# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Clicking a pixel: of a 3D viewport, or of the rendered picture in the Image Editor."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import bpy

from .. import properties as engine_properties
from ..export import camera
from ..notes import Notes
from . import probe, probe_overlay, properties, source, view

CLICK = "Click a pixel of a 3D viewport or of the render: its rays are shown   |   Esc: cancel"
WAIT = "Reading the scene and building its BVH   |   Esc: cancel"


class ProbeError(RuntimeError):
    """There is no pixel to probe; the message says why."""


@dataclass(frozen=True)
class Target:
    """A pixel of a picture that the core can trace."""

    camera: Mapping[str, Any]
    settings: Mapping[str, Any]
    pixel: tuple[int, int]


class WHITTLE_OT_probe(bpy.types.Operator):
    """Click a pixel to see its rays: where they go, and the work of each"""

    bl_idname = "whittle.probe"
    bl_label = "Probe a Pixel"
    bl_options = {"REGISTER"}

    _target: Target | None = None
    _timer: Any = None

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        self._target = None
        context.window.cursor_modal_set("EYEDROPPER")
        context.workspace.status_text_set(CLICK)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        try:
            return self._modal(context, event)
        except (ProbeError, ValueError, RuntimeError, MemoryError) as error:
            self.report({"ERROR"}, f"Whittle: {error}")
            return self._end(context, "CANCELLED")

    def _modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            return self._end(context, "CANCELLED")
        if self._target is not None:
            source.shared.poll()
            return self._finish(context)
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"PASS_THROUGH"}
        area, region = under(context.window, event.mouse_x, event.mouse_y)
        if region is None or region.type != "WINDOW":
            return {"PASS_THROUGH"}  # a button, perhaps
        at = (event.mouse_x - region.x, event.mouse_y - region.y)
        self._target = aim(context, area, region, at)
        if _prepare(context, whole=area.type == "IMAGE_EDITOR"):
            context.workspace.status_text_set(WAIT)
            self._timer = context.window_manager.event_timer_add(0.05, window=context.window)
        return self._finish(context)

    def _finish(self, context: bpy.types.Context) -> set[str]:
        """Probes, once the scene is ready."""
        shared = source.shared
        if shared.building:
            return {"RUNNING_MODAL"}
        if shared.scene is None:
            raise ProbeError(shared.error or "the scene could not be read")
        target = self._target
        found = probe.take(shared, target.camera, target.settings, target.pixel)
        probe_overlay.show(found)
        properties.redraw()
        return self._end(context, "FINISHED")

    def _end(self, context: bpy.types.Context, how: str) -> set[str]:
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None
        context.window.cursor_modal_restore()
        context.workspace.status_text_set(None)
        return {how}


def _prepare(context: bpy.types.Context, whole: bool) -> bool:
    """Sees that the scene at hand is what is clicked, with a render's tree if `whole`; whether it
    must be waited for."""
    shared = source.shared
    missing = shared.scene is None and not shared.building
    other = shared.subject != (context.scene.name, context.view_layer.name)
    if missing or other or shared.stale or (whole and shared.by_instance):
        shared.read(context.evaluated_depsgraph_get(), whole=whole)
    return shared.building


def under(
    window: bpy.types.Window, x: int, y: int
) -> tuple[bpy.types.Area | None, bpy.types.Region | None]:
    """The area and region at a place of a window; panels lie over the main region."""
    for area in window.screen.areas:
        hits = [
            region
            for region in area.regions
            if region.x <= x < region.x + region.width
            and region.y <= y < region.y + region.height
            and region.width > 1
        ]
        if hits:
            return area, min(hits, key=lambda region: region.type == "WINDOW")
    return None, None


def aim(
    context: bpy.types.Context,
    area: bpy.types.Area,
    region: bpy.types.Region,
    at: tuple[int, int],
) -> Target:
    """What a click at a pixel of a region means; ProbeError if it means nothing."""
    if area.type == "VIEW_3D":
        here = view.of_region(region, area.spaces.active, region.data)
        return Target(here.camera(), properties.core_settings(context.scene), at)
    if area.type == "IMAGE_EDITOR":
        return _aim_at_render(context, area.spaces.active, region, at)
    raise ProbeError("click into a 3D viewport, or on the render in the Image Editor")


def _aim_at_render(
    context: bpy.types.Context,
    space: bpy.types.SpaceImageEditor,
    region: bpy.types.Region,
    at: tuple[int, int],
) -> Target:
    """The pixel of the render, seen by the scene's camera at its own settings."""
    scene = context.scene
    if space.image is None or space.image.type != "RENDER_RESULT":
        raise ProbeError("the Image Editor shows no Render Result: choose it, or click a viewport")
    if scene.camera is None:
        raise ProbeError("the scene has no camera: add one, or click a viewport")
    render = scene.render
    scale = render.resolution_percentage / 100
    whole = (int(render.resolution_x * scale), int(render.resolution_y * scale))
    border = camera.region(render, whole)
    x0, y0, x1, y1 = border if render.use_crop_to_border else (0, 0, *whole)
    u, v = region.view2d.region_to_view(at[0] + 0.5, at[1] + 0.5)
    if not (0.0 <= u < 1.0 and 0.0 <= v < 1.0):
        raise ProbeError("the click is outside the picture")
    pixel = (x0 + int(u * (x1 - x0)), y0 + int(v * (y1 - y0)))
    graph = context.evaluated_depsgraph_get()
    shot = camera.export(graph, scene.camera, whole, (0, 0, *whole), Notes())
    settings = engine_properties.core_settings(scene, [])
    del settings["passes"]
    return Target(shot, settings, pixel)


register, unregister = bpy.utils.register_classes_factory((WHITTLE_OT_probe,))
