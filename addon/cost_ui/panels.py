# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The cost panels, the same in the Render properties and in the 3D viewport's sidebar."""

import bpy

from ..cost.compare import Change
from ..cost.rows import KINDS, Row
from ..inspect.panels import ViewportPanel
from ..panels import WhittlePanel, wrapped
from . import baseline, columns, numbers, preset_menu, table

NAME_SHARE = 0.36  # of a line's width
LISTED = 7  # lines of a list
MOST_SETTINGS = 6  # that are said to differ


class WHITTLE_UL_cost(bpy.types.UIList):
    """Rows of cost, in the order and by the filter of the session."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        if item.place >= len(table.shown.rows):
            return
        row = table.shown.rows[item.place]
        texts = [columns.COLUMNS[key].text(row) for key in chosen(data)]
        name, *cells = _cells(layout, len(texts))
        _name(name, row)
        _fill(cells, texts)

    def draw_filter(self, context: bpy.types.Context, layout: bpy.types.UILayout) -> None:
        """The filter is above the list."""


class WHITTLE_UL_changes(bpy.types.UIList):
    """Rows that differ from the baseline."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        if item.place >= len(table.shown.changes):
            return
        change = table.shown.changes[item.place]
        texts = change_texts(change, data.metric)
        name, *cells = _cells(layout, len(texts))
        _name(name, change.row)
        _fill(cells, texts)

    def draw_filter(self, context: bpy.types.Context, layout: bpy.types.UILayout) -> None:
        """The filter is above the table of cost."""


def change_texts(change: Change, key: str) -> list[str]:
    """Before, after and difference of a number of columns.COMPARED."""
    compared = columns.COMPARED[key]
    texts = [
        columns.NOT_MEASURED if value is None else compared.form(value)
        for value in change.values(compared.metric)
    ]
    difference = change.difference(compared.metric)
    if difference is None:
        return [*texts, columns.NOT_MEASURED]
    return [*texts, columns.signed(difference, compared.form)]


def chosen(session: bpy.types.PropertyGroup) -> list[str]:
    """The columns that are shown, in their order."""
    return [key for key in columns.COLUMNS if key in session.columns]


def _cells(layout: bpy.types.UILayout, count: int) -> list[bpy.types.UILayout]:
    """A place for the name, and as many for numbers, all of one width."""
    places, rest = [], layout.split(factor=NAME_SHARE, align=True)
    for left in range(count, 0, -1):
        places.append(rest.row(align=True))
        rest = rest.split(factor=1 / left, align=True) if left > 1 else rest
    return [*places, rest.row(align=True)] if count else [rest.row(align=True)]


def _fill(cells: list[bpy.types.UILayout], texts: list[str]) -> None:
    for cell, text in zip(cells, texts, strict=True):
        cell.alignment = "RIGHT"
        cell.label(text=text)


def _name(layout: bpy.types.UILayout, row: Row) -> None:
    icon = "LINKED" if row.shared else "MATERIAL" if row.kind == "material" else "OBJECT_DATA"
    title = f"shared ({row.stretched_by})" if row.stretched_by else row.title
    layout.label(text=title, icon=icon)


def _header(
    layout: bpy.types.UILayout, action: str, sort: str, descending: bool, titles: dict[str, str]
) -> None:
    """Buttons that sort, over the columns of a list."""
    for place, (key, title) in zip(_cells(layout, len(titles) - 1), titles.items(), strict=True):
        arrow = ("TRIA_DOWN" if descending else "TRIA_UP") if sort == key else "NONE"
        place.operator(action, text=title, icon=arrow, depress=sort == key).column = key


def draw_cost(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """The table, the row that was chosen, and its hints."""
    session = context.window_manager.whittle_cost
    result = table.shown.result
    if result is None:
        wrapped(layout, "Nothing was counted yet: switch on Count Rays' Work and render.")
        layout.operator("whittle.count", icon="RENDER_STILL")
        return
    if len(table.layers()) > 1:
        layout.prop(session, "layer", text="")
    layout.row().prop(session, "kind", expand=True)
    row = layout.row(align=True)
    row.prop(session, "search", text="", icon="VIEWZOOM")
    row.popover(panel="WHITTLE_PT_cost_columns", text="", icon="COLLAPSEMENU")
    titles = {"NAME": "Name"} | {key: columns.COLUMNS[key].title for key in chosen(session)}
    column = layout.column(align=True)
    _header(column, "whittle.sort_cost", session.sort, session.descending, titles)
    column.template_list("WHITTLE_UL_cost", "", session, "rows", session, "index", rows=LISTED)
    column = layout.column(align=True)
    for line in numbers.totals(result):
        column.label(text=line)
    active = table.shown.row(session)
    if active is not None:
        _draw_row(layout, active, "sah_cost" in result.cost.quality["instance"])


def _draw_row(layout: bpy.types.UILayout, row: Row, judged: bool) -> None:
    """What is known of one row."""
    box = layout.box().column(align=True)
    box.label(text="Shared by Several" if row.shared else row.title, icon="INFO")
    grid = box.grid_flow(row_major=True, columns=3, even_columns=True, align=True)
    for text in ("Rays", "Node Visits", "Triangle Tests"):
        grid.label(text=text)
    for kind in KINDS:
        if row.node_visits[kind] or row.triangle_tests[kind]:
            grid.label(text=kind.title())
            grid.label(text=f"{row.node_visits[kind]:,}")
            grid.label(text=f"{row.triangle_tests[kind]:,}")
    if row.shared:
        wrapped(box, "Visits to nodes that hold triangles of several.")
        if row.stretched_by:
            wrapped(box, f"'{row.stretched_by}' stretches their boxes most.", icon="ERROR")
        return
    if row.instances > 1:
        box.label(text=f"{row.instances:,} instances, {row.triangles:,} triangles")
    for hint in row.hints:
        wrapped(box, f"{hint.text}.", icon="ERROR")
        wrapped(box, f"{hint.mend[0].upper()}{hint.mend[1:]}.", icon="BLANK1")
    if not row.hints and row.kind == "object":
        found = (
            "None of the usual causes of cost" if judged else "No cause seen without its own BVH"
        )
        wrapped(box, f"{found}.", icon="CHECKMARK" if judged else "QUESTION")
    if row.kind == "object" and not judged:
        box.operator("whittle.measure_overlap", icon="RENDER_STILL")


def draw_quality(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """The numbers of the whole tree, and of the lecture's packets."""
    result = table.shown.result
    if result is None:
        layout.label(text="Nothing was counted yet")
        return
    _numbers(layout, numbers.tree(result))
    if "overlap" not in result.cost.quality:
        layout.operator("whittle.measure_overlap", icon="RENDER_STILL")
    for title, name in (
        ("Leaves by Depth", "depth_histogram"),
        ("Leaves by Triangles", "leaf_size_histogram"),
    ):
        header, body = layout.panel(f"whittle_{name}", default_closed=True)
        header.label(text=title)
        if body is not None:
            _histogram(body, numbers.histogram(result.cost.quality[name]))
    header, body = layout.panel("whittle_packets", default_closed=True)
    header.label(text="Packets")
    if body is None:
        return
    rows = numbers.packets(result)
    if rows:
        _numbers(body, rows)
    else:
        wrapped(body, "Choose the traversal 'Packets with Statistics' and render to see them.")


def _numbers(layout: bpy.types.UILayout, rows: list[tuple[str, str]]) -> None:
    split = layout.split(factor=0.55)
    names, values = split.column(align=True), split.column(align=True)
    for name, value in rows:
        names.label(text=name)
        values.label(text=value)


def _histogram(layout: bpy.types.UILayout, bars: list[tuple[str, int, float]]) -> None:
    split = layout.split(factor=0.2)
    names, values = split.column(align=True), split.column(align=True)
    for name, count, length in bars:
        names.label(text=name)
        values.progress(text=f"{count:,}", factor=length)


def draw_compare(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """The baseline, and what has changed since."""
    session, kept = context.window_manager.whittle_cost, baseline.kept
    row = layout.row(align=True)
    row.operator("whittle.keep_baseline", icon="PINNED")
    if kept is None:
        wrapped(layout, "Keep a render that counted, change something, and render again.")
        return
    row.operator("whittle.clear_baseline", text="", icon="X")
    layout.label(text=f"Baseline: {kept.name}", icon="PINNED")
    result = table.shown.result
    if result is None or kept.of(result.layer) is result:
        wrapped(layout, "Change something and render again.")
        return
    if table.shown.refused:
        box = layout.box()
        box.alert = True
        text = table.shown.refused
        wrapped(box, f"{text[0].upper()}{text[1:]}.", icon="ERROR")
        return
    for name, before, after in baseline.settings_changed(result)[:MOST_SETTINGS]:
        layout.label(text=f"{name}: {numbers.plain(before)}, now {numbers.plain(after)}")
    _whole(layout, numbers.whole(kept.of(result.layer), result))
    layout.row().prop(session, "kind", expand=True)
    layout.prop(session, "metric", text="")
    titles = {"NAME": "Name", "BEFORE": "Before", "AFTER": "Now", "DIFFERENCE": "Change"}
    column = layout.column(align=True)
    _header(column, "whittle.sort_changes", session.change_sort, session.change_descending, titles)
    column.template_list(
        "WHITTLE_UL_changes", "", session, "changes", session, "change_index", rows=LISTED
    )
    if not session.changes:
        layout.label(text="No row differs in this number")
    layout.operator("whittle.difference_map", icon="IMAGE_DATA")


def _whole(layout: bpy.types.UILayout, rows: list[tuple[str, ...]]) -> None:
    """A table of the whole render, before and after."""
    grid = layout.box().grid_flow(row_major=True, columns=4, even_columns=False, align=True)
    for line in (("", "Before", "Now", "Change"), *rows):
        for text in line:
            grid.label(text=text)


class WHITTLE_PT_cost_columns(bpy.types.Panel):
    """Which columns the table shows."""

    bl_label = "Columns"
    bl_space_type = "PROPERTIES"
    bl_region_type = "HEADER"

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.column().prop(context.window_manager.whittle_cost, "columns")


class CostPanel:
    bl_label = "Cost by Object"

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        preset_menu.WHITTLE_COST_PT_presets.draw_panel_header(self.layout)

    def draw(self, context: bpy.types.Context) -> None:
        draw_cost(self.layout, context)


class QualityPanel:
    bl_label = "Quality of the BVH"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        draw_quality(self.layout, context)


class ComparePanel:
    bl_label = "Compare"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        draw_compare(self.layout, context)


class WHITTLE_RENDER_PT_cost(CostPanel, WhittlePanel, bpy.types.Panel):
    bl_parent_id = "WHITTLE_RENDER_PT_heatmaps"


class WHITTLE_RENDER_PT_quality(QualityPanel, WhittlePanel, bpy.types.Panel):
    bl_parent_id = "WHITTLE_RENDER_PT_heatmaps"


class WHITTLE_RENDER_PT_compare(ComparePanel, WhittlePanel, bpy.types.Panel):
    bl_parent_id = "WHITTLE_RENDER_PT_heatmaps"


class WHITTLE_VIEW_PT_cost(CostPanel, ViewportPanel, bpy.types.Panel):
    bl_options = {"DEFAULT_CLOSED"}


class WHITTLE_VIEW_PT_quality(QualityPanel, ViewportPanel, bpy.types.Panel):
    bl_parent_id = "WHITTLE_VIEW_PT_cost"


class WHITTLE_VIEW_PT_compare(ComparePanel, ViewportPanel, bpy.types.Panel):
    bl_parent_id = "WHITTLE_VIEW_PT_cost"


CLASSES = (
    WHITTLE_UL_cost,
    WHITTLE_UL_changes,
    WHITTLE_PT_cost_columns,
    WHITTLE_RENDER_PT_cost,
    WHITTLE_RENDER_PT_quality,
    WHITTLE_RENDER_PT_compare,
    WHITTLE_VIEW_PT_cost,
    WHITTLE_VIEW_PT_quality,
    WHITTLE_VIEW_PT_compare,
)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
