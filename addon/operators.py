# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panels' buttons do."""

import bpy

from . import demo, heat, passes, results


class WHITTLE_OT_heatmaps(bpy.types.Operator):
    """Make coloured images of what the last render counted for each pixel"""

    bl_idname = "whittle.heatmaps"
    bl_label = "Heatmaps"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if any(result.counters for result in results.last):
            return True
        cls.poll_message_set("Switch on Count Rays' Work and render first")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            images = draw_heatmaps(context.scene)
        except heat.HeatError as error:
            self.report({"ERROR"}, f"Whittle: {error}")
            return {"CANCELLED"}
        show_in_editor(context, images[0])
        self.report({"INFO"}, f"Whittle: {len(images)} heatmaps: see the Image Editor's list")
        return {"FINISHED"}


def draw_heatmaps(scene: bpy.types.Scene) -> list[bpy.types.Image]:
    """An image in Blender for each counter of the last render that is not 0 everywhere."""
    settings = scene.whittle
    top = settings.heat_max if settings.heat_range == "FIXED" else None
    images = []
    for result in results.last:
        for row in passes.counted(result.counters):
            if not (result.counters[row.source].any() or row.source == "nodes"):
                continue
            place = f" ({result.layer})" if len(results.last) > 1 else ""
            pixels = heat.draw(result, row.source, settings.heat_map, top)
            images.append(heat.show(f"Whittle {row.name}{place}", pixels))
    return images


def show_in_editor(context: bpy.types.Context, image: bpy.types.Image) -> None:
    """Shows an image in the first Image Editor that is open, if there is one."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "IMAGE_EDITOR":
                area.spaces.active.image = image
                return


class WHITTLE_OT_demo_scene(bpy.types.Operator):
    """Add glass and mirror spheres over a checkered floor, as in Whitted's paper"""

    bl_idname = "whittle.demo_scene"
    bl_label = "Demo Scene"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        demo.build(context.scene)
        return {"FINISHED"}


CLASSES = (WHITTLE_OT_heatmaps, WHITTLE_OT_demo_scene)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
