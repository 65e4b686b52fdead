# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the buttons of the viewport's Whittle tab do."""

import bpy
from bpy.props import IntProperty, StringProperty

from . import overlay, properties, source


class WHITTLE_OT_update(bpy.types.Operator):
    """Read the scene as it is now, and build the BVH that a render of it has"""

    bl_idname = "whittle.update"
    bl_label = "Update"
    bl_options = {"INTERNAL"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        source.shared.read(context.evaluated_depsgraph_get(), whole=True)
        if source.shared.error:
            self.report({"ERROR"}, f"Whittle: {source.shared.error}")
            return {"CANCELLED"}
        properties.redraw()
        return {"FINISHED"}


class WHITTLE_OT_fit_range(bpy.types.Operator):
    """Fix the range at what the automatic one is now, to compare other views and scenes with it"""

    bl_idname = "whittle.fit_range"
    bl_label = "Fit to View"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if overlay.picture_of(context) is not None:
            return True
        cls.poll_message_set("Show the heatmap first")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        settings = context.scene.whittle_overlay
        settings.low, settings.high = 0.0, overlay.picture_of(context).top
        settings.range = "FIXED"
        return {"FINISHED"}


class WHITTLE_OT_step_ray(bpy.types.Operator):
    """Make the next or the previous ray of the probed pixel the active one"""

    bl_idname = "whittle.step_ray"
    bl_label = "Step Through Rays"
    bl_options = {"INTERNAL"}

    step: IntProperty(name="Step", description="How many rays further; below 0: back", default=1)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return len(context.window_manager.whittle.rays) > 0

    def execute(self, context: bpy.types.Context) -> set[str]:
        session = context.window_manager.whittle
        session.ray_index = (session.ray_index + self.step) % len(session.rays)
        return {"FINISHED"}


class WHITTLE_OT_select_object(bpy.types.Operator):
    """Select this object alone, and make it active"""

    bl_idname = "whittle.select_object"
    bl_label = "Select Object"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name", description="Of the object to select")

    def execute(self, context: bpy.types.Context) -> set[str]:
        found = context.view_layer.objects.get(self.name)
        if found is None:
            self.report({"WARNING"}, f"Whittle: '{self.name}' is not in this view layer")
            return {"CANCELLED"}
        for ob in context.selected_objects:
            ob.select_set(False)
        found.select_set(True)
        context.view_layer.objects.active = found
        return {"FINISHED"}


CLASSES = (
    WHITTLE_OT_update,
    WHITTLE_OT_fit_range,
    WHITTLE_OT_step_ray,
    WHITTLE_OT_select_object,
)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
