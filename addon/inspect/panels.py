# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Whittle tab in the sidebar of 3D viewports."""

import bpy

from .. import native
from ..panels import wrapped
from . import box_overlay, boxes, legend, overlay, preset_menu, probe_overlay, properties, source
from .probe import Ray

ICONS = {
    "primary": "CAMERA_DATA",
    "shadow": "LIGHT",
    "reflection": "NODE_MATERIAL",
    "refraction": "MATERIAL",
}
DEEPEST = 12  # levels that are indented
MOST_OBJECTS = 8  # rows of a ray's table


class ViewportPanel:
    """What the tab's panels share."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Whittle"


class WHITTLE_VIEW_PT_scene(ViewportPanel, bpy.types.Panel):
    bl_label = "Ray Cost"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        shared = source.shared
        problem = native.problem() or shared.error
        if problem:
            box = layout.box()
            box.alert = True
            wrapped(box, problem, icon="ERROR")
        row = layout.row(align=True)
        row.alert = shared.stale
        row.operator("whittle.update", icon="FILE_REFRESH")
        layout.prop(context.scene.whittle_overlay, "automatic")
        if shared.scene is not None:
            build = shared.build
            layout.label(text=f"{build['triangles']:,} triangles, {build['nodes']:,} nodes")
        if shared.scene is not None and shared.by_instance:
            wrapped(layout, "A tree for each object, as Rendered shading has it", icon="INFO")
        if shared.stale:
            layout.label(text="The scene has changed since", icon="INFO")


class WHITTLE_VIEW_PT_heat(ViewportPanel, bpy.types.Panel):
    bl_label = "Heatmap"

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.window_manager.whittle, "show_heat", text="")

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        preset_menu.WHITTLE_VIEW_PT_presets.draw_panel_header(self.layout)

    def draw(self, context: bpy.types.Context) -> None:
        layout = _columns(self.layout)
        settings = context.scene.whittle_overlay
        layout.prop(settings, "metric")
        row = properties.choice(settings).row
        if settings.metric == "BOTH":
            column = layout.column(align=True)
            column.prop(settings, "node_weight", text="Weight of a Node")
            column.prop(settings, "triangle_weight", text="of a Triangle")
        if row.by_kind:
            layout.column().prop(settings, "kinds")
        layout.prop(settings, "samples")
        layout.prop(settings, "opacity")


class WHITTLE_VIEW_PT_range(ViewportPanel, bpy.types.Panel):
    bl_label = "Colours"
    bl_parent_id = "WHITTLE_VIEW_PT_heat"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = _columns(self.layout)
        settings = context.scene.whittle_overlay
        layout.prop(settings, "colormap")
        layout.prop(settings, "range")
        if settings.range == "FIXED":
            column = layout.column(align=True)
            column.alert = settings.high <= settings.low
            column.prop(settings, "low")
            column.prop(settings, "high")
        layout.operator("whittle.fit_range", icon="FULLSCREEN_EXIT")
        layout.prop(settings, "show_legend")
        row = layout.row()
        row.enabled = settings.show_legend
        row.prop(settings, "show_histogram")


class WHITTLE_VIEW_PT_numbers(ViewportPanel, bpy.types.Panel):
    bl_label = "This View"
    bl_parent_id = "WHITTLE_VIEW_PT_heat"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        picture = overlay.picture_of(context)
        if picture is None:
            layout.label(text="No heatmap here yet")
            return
        split = layout.split(factor=0.5)
        names, values = split.column(align=True), split.column(align=True)
        for name, value in (
            ("Mean", legend.number(picture.mean)),
            ("95 % Below", legend.number(picture.p95)),
            ("Highest", legend.number(picture.highest)),
            ("Pixels", "{1} x {0}".format(*picture.values.shape)),
            ("Traced in", f"{1000 * picture.seconds:,.0f} ms"),
        ):
            names.label(text=name)
            values.label(text=value)


class WHITTLE_VIEW_PT_boxes(ViewportPanel, bpy.types.Panel):
    bl_label = "BVH Boxes"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.window_manager.whittle, "show_boxes", text="")

    def draw(self, context: bpy.types.Context) -> None:
        layout = _columns(self.layout)
        settings = context.scene.whittle_overlay
        column = layout.column(align=True)
        column.alert = settings.box_depth_max < settings.box_depth_min
        column.prop(settings, "box_depth_min")
        column.prop(settings, "box_depth_max")
        layout.prop(settings, "box_color")
        layout.prop(settings, "box_colormap")
        column = layout.column(heading="Only")
        row = column.row()
        row.enabled = settings.box_color != "LEAF"
        row.prop(settings, "box_leaves", text="Leaves")
        column.prop(settings, "box_selected", text="Selected Objects")
        column.prop(settings, "box_probed", text="Visited by the Ray")
        layout.prop(settings, "box_limit")
        layout.prop(settings, "box_opacity")
        layout.prop(settings, "box_in_front")
        if context.window_manager.whittle.show_boxes and box_overlay.shown is not None:
            wrapped(layout, boxes.caption(box_overlay.shown))


class WHITTLE_UL_rays(bpy.types.UIList):
    """The probe's rays, indented below the one that they descend from."""

    def draw_item(
        self,
        context: bpy.types.Context,
        layout: bpy.types.UILayout,
        data: bpy.types.AnyType,
        item: bpy.types.AnyType,
        icon: int,
        active_data: bpy.types.AnyType,
        active_property: str,
    ) -> None:
        row = layout.row(align=True)
        if item.level:
            row.separator(factor=min(item.level, DEEPEST))
        row.label(text=item.name, icon=ICONS[item.kind])
        counts = row.row()
        counts.alignment = "RIGHT"
        counts.label(text=f"{item.nodes:,} / {item.triangles:,}")


class WHITTLE_VIEW_PT_probe(ViewportPanel, bpy.types.Panel):
    bl_label = "Pixel Probe"

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.window_manager.whittle, "show_probe", text="")

    def draw(self, context: bpy.types.Context) -> None:
        draw_probe(self.layout, context)


class WHITTLE_IMAGE_PT_probe(bpy.types.Panel):
    bl_label = "Pixel Probe"
    bl_space_type = "IMAGE_EDITOR"
    bl_region_type = "UI"
    bl_category = "Whittle"

    def draw(self, context: bpy.types.Context) -> None:
        draw_probe(self.layout, context)


def draw_probe(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """The button, the rays, and what is known of the active one."""
    layout.operator("whittle.probe", icon="EYEDROPPER")
    session, found = context.window_manager.whittle, probe_overlay.current
    if found is None:
        return
    for kind, (rays, nodes, triangles) in found.counts().items():
        layout.label(text=f"{rays:,} {kind}: {nodes:,} nodes, {triangles:,} triangles")
    row = layout.row(align=True)
    row.operator("whittle.step_ray", text="Previous", icon="TRIA_LEFT").step = -1
    row.operator("whittle.step_ray", text="Next", icon="TRIA_RIGHT").step = 1
    layout.label(text="Ray: what it hit, nodes / triangles")
    layout.template_list("WHITTLE_UL_rays", "", session, "rays", session, "ray_index", rows=6)
    if len(found.rays) > len(session.rays):
        layout.label(text=f"{len(session.rays):,} of {len(found.rays):,} rays listed", icon="INFO")
    ray = probe_overlay.chosen(context)
    if ray is not None:
        _draw_ray(layout, ray)
    column = layout.column(heading="Show")
    column.prop(context.scene.whittle_overlay, "probe_all")
    column.prop(context.scene.whittle_overlay, "probe_triangles")


def _draw_ray(layout: bpy.types.UILayout, ray: Ray) -> None:
    box = layout.box().column(align=True)
    where = f"sample {ray.sample + 1}" + (f", light {ray.light + 1}" if ray.light >= 0 else "")
    box.label(text=f"{ray.kind.title()} ray, {where}", icon=ICONS[ray.kind])
    if ray.hit:
        box.label(text=f"Hits {ray.target} after {ray.distance:.4g} m")
        box.label(text=f"Triangle {ray.triangle:,}, material {ray.material}")
    else:
        box.label(text="Reaches the light" if ray.kind == "shadow" else "Leaves the scene")
    box.separator()
    table = box.grid_flow(row_major=True, columns=3, align=True)
    for title in ("Object", "Nodes", "Triangles"):
        table.label(text=title)
    rows = ray.work[:MOST_OBJECTS]
    for work in rows:
        if work.selects:
            row = table.operator("whittle.select_object", text=work.name, emboss=False)
            row.name = work.selects
        else:
            table.label(text="Shared by several")
        table.label(text=f"{work.nodes:,}")
        table.label(text=f"{work.triangles:,}")
    table.label(text="All")
    table.label(text=f"{len(ray.nodes):,}")
    table.label(text=f"{len(ray.triangles):,}")
    if len(ray.work) > len(rows):
        box.label(text=f"and {len(ray.work) - len(rows)} more objects")


def _columns(layout: bpy.types.UILayout) -> bpy.types.UILayout:
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout


CLASSES = (
    WHITTLE_VIEW_PT_scene,
    WHITTLE_VIEW_PT_heat,
    WHITTLE_VIEW_PT_range,
    WHITTLE_VIEW_PT_numbers,
    WHITTLE_VIEW_PT_probe,
    WHITTLE_VIEW_PT_boxes,
    WHITTLE_IMAGE_PT_probe,
    WHITTLE_UL_rays,
)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
