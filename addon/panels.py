# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine's panels in the Properties editor."""

from math import isqrt
from typing import Any

import bpy

from . import native, results
from .builtin_panels import ENGINE


class WhittlePanel:
    """What the panels share: they show while the engine is chosen."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.engine in cls.COMPAT_ENGINES


class WHITTLE_RENDER_PT_render(WhittlePanel, bpy.types.Panel):
    bl_label = "Whittle"
    bl_options = {"HIDE_HEADER"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        problem = native.problem()
        if problem is not None:
            box = layout.box()
            box.alert = True
            box.label(text="Whittle cannot render:", icon="ERROR")
            wrapped(box, problem)
        row = layout.row()
        row.scale_y = 1.4
        row.enabled = problem is None
        row.operator("render.render", text="Render", icon="RENDER_STILL")


class WHITTLE_RENDER_PT_sampling(WhittlePanel, bpy.types.Panel):
    bl_label = "Sampling"

    def draw(self, context: bpy.types.Context) -> None:
        layout = _columns(self.layout)
        settings = context.scene.whittle
        for name, text in (("samples", "Render"), ("viewport_samples", "Viewport")):
            count = getattr(settings, name)
            square = count >= 1 and isqrt(count) ** 2 == count
            column = layout.column()
            column.alert = not square
            column.prop(settings, name, text=text)
            if not square:
                column.label(text="A square number: 1, 4, 9, 16, ...", icon="ERROR")
        layout.prop(settings, "pattern")
        if settings.pattern == "STRATIFIED":
            layout.prop(settings, "seed")


class WHITTLE_RENDER_PT_light_paths(WhittlePanel, bpy.types.Panel):
    bl_label = "Light Paths"

    def draw(self, context: bpy.types.Context) -> None:
        layout = _columns(self.layout)
        settings = context.scene.whittle
        layout.prop(settings, "max_depth")
        layout.prop(settings, "cutoff")
        layout.prop(settings, "use_ambient")


class WHITTLE_RENDER_PT_film(WhittlePanel, bpy.types.Panel):
    bl_label = "Film"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        _columns(self.layout).prop(context.scene.render, "film_transparent", text="Transparent")


class WHITTLE_RENDER_PT_performance(WhittlePanel, bpy.types.Panel):
    bl_label = "Performance"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = _columns(self.layout)
        render = context.scene.render
        layout.prop(render, "threads_mode")
        row = layout.row()
        row.enabled = render.threads_mode == "FIXED"
        row.prop(render, "threads")
        layout.prop(context.scene.whittle, "mode")
        layout.prop(context.scene.whittle, "build_preset")
        layout.prop(context.scene.whittle, "bins")


class WHITTLE_RENDER_PT_heatmaps(WhittlePanel, bpy.types.Panel):
    bl_label = "Heatmaps"

    def draw(self, context: bpy.types.Context) -> None:
        layout = _columns(self.layout)
        settings = context.scene.whittle
        layout.prop(settings, "use_counters")
        column = layout.column()
        column.enabled = settings.use_counters
        column.prop(settings, "use_own_trees")
        layout.prop(settings, "heat_map")
        layout.prop(settings, "heat_range")
        if settings.heat_range == "FIXED":
            layout.prop(settings, "heat_max")
        layout.operator("whittle.heatmaps", icon="IMAGE_DATA")


class WHITTLE_RENDER_PT_last(WhittlePanel, bpy.types.Panel):
    bl_label = "Last Render"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        if not results.last:
            layout.label(text="Nothing rendered yet")
            layout.operator("whittle.demo_scene", text="Add the Demo Scene")
        for result in results.last:
            if len(results.last) > 1:
                layout.label(text=result.layer, icon="RENDERLAYERS")
            _table(layout, numbers(result))
            left_out = [name for name, _ in result.render["left_out"]]
            if left_out:
                wrapped(layout, "Left out, not needed: " + ", ".join(left_out))
            for line in result.notes:
                wrapped(layout, line, icon="INFO")


class WHITTLE_VIEWLAYER_PT_passes(WhittlePanel, bpy.types.Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context: bpy.types.Context) -> None:
        layout = _columns(self.layout)
        column = layout.column(heading="Data")
        for switch in ("use_pass_z", "use_pass_position", "use_pass_normal"):
            column.prop(context.view_layer, switch)
        column.prop(context.view_layer, "use_pass_object_index")
        column = layout.column(heading="Work")
        column.prop(context.scene.whittle, "use_counters", text="Nodes and Triangles")


class WHITTLE_DATA_PT_shadow(WhittlePanel, bpy.types.Panel):
    bl_label = "Shadow"
    bl_context = "data"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.light is not None

    def draw(self, context: bpy.types.Context) -> None:
        _columns(self.layout).prop(context.light, "use_shadow", text="Cast Shadow")


class WHITTLE_OBJECT_PT_ray_visibility(WhittlePanel, bpy.types.Panel):
    bl_label = "Ray Visibility"
    bl_parent_id = "OBJECT_PT_visibility"
    bl_context = "object"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.object is not None

    def draw(self, context: bpy.types.Context) -> None:
        layout = _columns(self.layout)
        column = layout.column()
        for kind in ("camera", "glossy", "transmission", "shadow"):
            column.prop(context.object, f"visible_{kind}", text=kind.title())


def numbers(result: results.Result) -> list[tuple[str, str]]:
    """The rows of the last render's table: name and value."""
    build, stats, seconds = result.build, result.render, result.seconds
    kinds = ((kind, count) for kind, count in stats["rays"].items() if count)
    judged = [("Judge", f"{seconds['judge']:.3f} s")] if "judge" in seconds else []
    return [
        ("Size", "{} x {}".format(*result.size)),
        ("Triangles", f"{build['triangles']:,}"),
        ("BVH Nodes", f"{build['nodes']:,}"),
        ("BVH Depth", f"{build['depth']:,}"),
        ("BVH Memory", _memory(build)),
        ("SAH Cost", f"{build['sah_cost']:,.2f}"),
        ("Read Scene", f"{seconds['export']:.3f} s"),
        ("Build", f"{seconds['build']:.3f} s"),
        ("Trace", f"{seconds['trace']:.3f} s"),
        *((f"    {name.title()}", f"{spent:.3f} s") for name, spent in result.tracing().items()),
        *judged,
        ("Hand Over", f"{seconds['hand_over']:.3f} s"),
        *((f"{kind.title()} Rays", f"{count:,}") for kind, count in kinds),
        ("Speed", f"{result.rays_per_second() / 1e6:,.2f} Mrays/s"),
    ]


def _memory(build: dict[str, Any]) -> str:
    """Of both trees and the triangles, and how much that is for each triangle."""
    total = build["bytes_nodes"] + build["bytes_triangles"]
    return f"{total / 2**20:,.1f} MB ({total / max(1, build['triangles']):.0f} B a triangle)"


def _columns(layout: bpy.types.UILayout) -> bpy.types.UILayout:
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout


def _table(layout: bpy.types.UILayout, rows: list[tuple[str, str]]) -> None:
    split = layout.split(factor=0.45)
    names, values = split.column(align=True), split.column(align=True)
    for name, value in rows:
        names.label(text=name)
        values.label(text=value)


def _letters() -> int:
    """About how many letters a label has room for in the panel that is drawn."""
    region, system = bpy.context.region, bpy.context.preferences.system
    if region is None:
        return 44
    return max(20, int((region.width / system.ui_scale - 40) / 6.5))


def wrapped(layout: bpy.types.UILayout, text: str, icon: str = "NONE") -> None:
    """A long line as several short labels; Blender itself cuts what does not fit."""
    column = layout.column(align=True)
    line, letters = "", _letters()
    for word in text.split(" "):
        if line and len(line) + len(word) >= letters:
            column.label(text=line, icon=icon)
            line, icon = "", "BLANK1" if icon != "NONE" else icon
        line = f"{line} {word}".strip()
    column.label(text=line, icon=icon)


CLASSES = (
    WHITTLE_RENDER_PT_render,
    WHITTLE_RENDER_PT_sampling,
    WHITTLE_RENDER_PT_light_paths,
    WHITTLE_RENDER_PT_film,
    WHITTLE_RENDER_PT_performance,
    WHITTLE_RENDER_PT_heatmaps,
    WHITTLE_RENDER_PT_last,
    WHITTLE_VIEWLAYER_PT_passes,
    WHITTLE_DATA_PT_shadow,
    WHITTLE_OBJECT_PT_ray_visibility,
)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
