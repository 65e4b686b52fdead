# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the buttons of the cost panels do."""

import bpy
from bpy.props import EnumProperty, StringProperty

from .. import heat
from ..cost.compare import CompareError
from ..operators import show_in_editor
from . import baseline, columns, properties, table

MAP = "Whittle Difference"
NOT_COUNTED = "Switch on Count Rays' Work and render first"


class WHITTLE_OT_sort_cost(bpy.types.Operator):
    """Sort the rows by this column; a second time the other way round"""

    bl_idname = "whittle.sort_cost"
    bl_label = "Sort"
    bl_options = {"INTERNAL"}

    column: EnumProperty(
        name="Column", description="To sort the rows by", items=columns.SORTS, default="WORK"
    )

    def execute(self, context: bpy.types.Context) -> set[str]:
        session = context.window_manager.whittle_cost
        _sort(session, "sort", "descending", self.column)
        return {"FINISHED"}


class WHITTLE_OT_sort_changes(bpy.types.Operator):
    """Sort the changed rows by this column; a second time the other way round"""

    bl_idname = "whittle.sort_changes"
    bl_label = "Sort"
    bl_options = {"INTERNAL"}

    column: EnumProperty(
        name="Column",
        description="To sort the rows by",
        items=properties.CHANGE_SORTS,
        default="DIFFERENCE",
    )

    def execute(self, context: bpy.types.Context) -> set[str]:
        session = context.window_manager.whittle_cost
        _sort(session, "change_sort", "change_descending", self.column)
        return {"FINISHED"}


def _sort(session: bpy.types.PropertyGroup, sort: str, descending: str, column: str) -> None:
    again = getattr(session, sort) == column
    setattr(session, descending, not getattr(session, descending) if again else column != "NAME")
    setattr(session, sort, column)


class WHITTLE_OT_select_cost(bpy.types.Operator):
    """Select what the row stands for: its object, the objects of its material, or, of what several
    share, the one that stretches the boxes most"""

    bl_idname = "whittle.select_cost"
    bl_label = "Select"
    bl_options = {"REGISTER", "UNDO"}

    kind: StringProperty(name="Kind", description="object or material", default="object")
    name: StringProperty(name="Name", description="Of the object or material")

    def execute(self, context: bpy.types.Context) -> set[str]:
        found = standing_for(context.view_layer, self.kind, self.name)
        if not found:
            self.report({"WARNING"}, f"Whittle: nothing of '{self.name}' is in this view layer")
            return {"CANCELLED"}
        if context.view_layer.objects.active and context.mode != "OBJECT":
            self.report({"WARNING"}, "Whittle: leave the mode for editing to select an object")
            return {"CANCELLED"}
        for ob in list(context.view_layer.objects.selected):
            ob.select_set(False)
        for ob in found:
            ob.select_set(True)
        context.view_layer.objects.active = found[0]
        return {"FINISHED"}


def standing_for(layer: bpy.types.ViewLayer, kind: str, name: str) -> list[bpy.types.Object]:
    """The objects of a view layer that a row is due to. Of an object that is only there as an
    instance of its collection, those that place it."""
    if kind == "material":
        return [ob for ob in layer.objects if any(s.name == name for s in ob.material_slots)]
    found = layer.objects.get(name)
    if found is not None:
        return [found]
    return [
        ob
        for ob in layer.objects
        if ob.instance_collection is not None and name in ob.instance_collection.all_objects
    ]


class Counting:
    """An operator that switches on what costs are made of, and renders."""

    bl_options = {"REGISTER", "UNDO"}
    judges = False  # trees of objects too

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if context.engine != "WHITTLE":
            cls.poll_message_set("Choose Whittle as the render engine first")
            return False
        if context.scene.camera is None:
            cls.poll_message_set("Add a camera first")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        settings = context.scene.whittle
        settings.use_counters = True
        settings.use_own_trees |= self.judges
        return _render(self)


class WHITTLE_OT_count(Counting, bpy.types.Operator):
    """Switch on Count Rays' Work, and render: the table is filled then"""

    bl_idname = "whittle.count"
    bl_label = "Count and Render"


class WHITTLE_OT_measure_overlap(Counting, bpy.types.Operator):
    """Switch on Judge Objects, and render again: measures how much objects overlap (EPO), and what
    a BVH of its own would cost each of them"""

    bl_idname = "whittle.measure_overlap"
    bl_label = "Measure Overlap"
    judges = True


def _render(operator: bpy.types.Operator) -> set[str]:
    """Renders with a progress bar where there is a window, else waits."""
    try:
        if bpy.app.background:
            bpy.ops.render.render()
        else:
            bpy.ops.render.render("INVOKE_DEFAULT")
    except RuntimeError as error:
        operator.report({"ERROR"}, str(error).strip())
        return {"CANCELLED"}
    return {"FINISHED"}


class WHITTLE_OT_keep_baseline(bpy.types.Operator):
    """Keep the last render's cost, to compare the next ones with it"""

    bl_idname = "whittle.keep_baseline"
    bl_label = "Keep as Baseline"
    bl_options = {"REGISTER"}

    name: StringProperty(name="Name", description="What to call it; by default scene and frame")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if table.counted():
            return True
        cls.poll_message_set(NOT_COUNTED)
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        counted = table.counted()
        baseline.keep(self.name or f"{counted[0].scene}, frame {counted[0].frame}", counted)
        table.refresh()
        return {"FINISHED"}


class WHITTLE_OT_clear_baseline(bpy.types.Operator):
    """Forget the baseline; the last render stays"""

    bl_idname = "whittle.clear_baseline"
    bl_label = "Clear Baseline"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return baseline.kept is not None

    def execute(self, context: bpy.types.Context) -> set[str]:
        baseline.clear()
        table.refresh()
        return {"FINISHED"}


class WHITTLE_OT_difference_map(bpy.types.Operator):
    """Show where the last render has more work than the baseline (red), or less (blue)"""

    bl_idname = "whittle.difference_map"
    bl_label = "Difference Map"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        result = table.shown.result
        if baseline.kept is None or result is None or baseline.kept.of(result.layer) is result:
            cls.poll_message_set("Keep a baseline and render again first")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            pixels = baseline.difference_map(table.shown.result)
        except (CompareError, heat.HeatError) as error:
            self.report({"ERROR"}, f"Whittle: {error}")
            return {"CANCELLED"}
        show_in_editor(context, heat.show(MAP, pixels))
        self.report({"INFO"}, f"Whittle: '{MAP}' is in the Image Editor's list")
        return {"FINISHED"}


CLASSES = (
    WHITTLE_OT_sort_cost,
    WHITTLE_OT_sort_changes,
    WHITTLE_OT_select_cost,
    WHITTLE_OT_count,
    WHITTLE_OT_measure_overlap,
    WHITTLE_OT_keep_baseline,
    WHITTLE_OT_clear_baseline,
    WHITTLE_OT_difference_map,
)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
