# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the cost panels are set to, until Blender ends: ``window_manager.whittle_cost``."""

from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from ..callbacks import late
from ..cost.rows import Row
from . import columns, table

KIND_ITEMS = (
    ("OBJECT", "Objects", "A row for each object, with all its instances"),
    ("MATERIAL", "Materials", "A row for each material"),
)
CHANGE_SORTS = (
    ("NAME", "Name", "Alphabetically"),
    ("BEFORE", "Before", "By the number in the baseline"),
    ("AFTER", "Now", "By the number in the last render"),
    ("DIFFERENCE", "Difference", "By how much the number changed, up or down"),
)


def _list(session: "WhittleCostSession", context: Any) -> None:
    table.fill(session)


def _select(session: "WhittleCostSession", context: Any) -> None:
    """A click on a row of cost selects what it stands for."""
    if not table.shown.filling:
        select(table.shown.row(session))


def _select_changed(session: "WhittleCostSession", context: Any) -> None:
    place = table.active(session.changes, session.change_index)
    if not table.shown.filling and place is not None:
        select(table.shown.changes[place].row)


def select(row: Row | None) -> None:
    """Selects as a step that can be undone."""
    name = "" if row is None else row.stretched_by if row.shared else row.name
    if name:
        bpy.ops.whittle.select_cost("EXEC_DEFAULT", True, kind=row.kind, name=name)


def _layers(session: "WhittleCostSession | None", context: Any) -> list[tuple[str, str, str]]:
    # Blender does not keep such texts: they must live on here.
    _layers.items = [(name, name, f"The view layer {name}") for name in table.layers()] or [
        ("NONE", "None", "Nothing was counted yet")
    ]
    return _layers.items


class WhittleCostRow(bpy.types.PropertyGroup):
    """A line of one of the lists."""

    place: IntProperty(name="Place", description="Of the row among all, dearest first")


class WhittleCostSession(bpy.types.PropertyGroup):
    """The table of cost and what it is compared with."""

    kind: EnumProperty(
        name="Rows",
        description="By what the cost is divided",
        items=KIND_ITEMS,
        default="OBJECT",
        options={"SKIP_SAVE"},
        update=late(__name__, "_list"),
    )
    layer: EnumProperty(
        name="View Layer",
        description="Of the last render, the view layer whose cost is listed",
        items=late(__name__, "_layers"),
        options={"SKIP_SAVE"},
        update=late(__name__, "_list"),
    )
    search: StringProperty(
        name="Filter",
        description="List only rows with this in their name; * and ? stand for anything",
        options={"SKIP_SAVE", "TEXTEDIT_UPDATE"},
        update=late(__name__, "_list"),
    )
    columns: EnumProperty(
        name="Columns",
        description="The numbers that the table shows",
        items=columns.FLAGS,
        default={"WORK", "TRIANGLES", "MEMORY"},
        options={"SKIP_SAVE", "ENUM_FLAG"},
    )
    sort: EnumProperty(
        name="Sort By",
        description="The column that the rows are sorted by",
        items=columns.SORTS,
        default="WORK",
        options={"SKIP_SAVE"},
        update=late(__name__, "_list"),
    )
    descending: BoolProperty(
        name="Descending",
        description="Begin with the largest, or with the last name",
        default=True,
        options={"SKIP_SAVE"},
        update=late(__name__, "_list"),
    )
    rows: CollectionProperty(
        type=WhittleCostRow,
        name="Rows",
        description="The rows that are listed, in their order",
        options={"SKIP_SAVE"},
    )
    index: IntProperty(
        name="Active Row",
        description="The row that is told about below the list; a click selects its object",
        default=0,
        min=0,
        options={"SKIP_SAVE"},
        update=late(__name__, "_select"),
    )
    metric: EnumProperty(
        name="Number",
        description="The number that is compared",
        items=columns.CHANGES,
        default="WORK",
        options={"SKIP_SAVE"},
        update=late(__name__, "_list"),
    )
    change_sort: EnumProperty(
        name="Sort By",
        description="What the changed rows are sorted by",
        items=CHANGE_SORTS,
        default="DIFFERENCE",
        options={"SKIP_SAVE"},
        update=late(__name__, "_list"),
    )
    change_descending: BoolProperty(
        name="Descending",
        description="Begin with the largest, or with the last name",
        default=True,
        options={"SKIP_SAVE"},
        update=late(__name__, "_list"),
    )
    changes: CollectionProperty(
        type=WhittleCostRow,
        name="Changed Rows",
        description="The rows that differ from the baseline, in their order",
        options={"SKIP_SAVE"},
    )
    change_index: IntProperty(
        name="Active Change",
        description="The row that was chosen last; a click selects its object",
        default=0,
        min=0,
        options={"SKIP_SAVE"},
        update=late(__name__, "_select_changed"),
    )


CLASSES = (WhittleCostRow, WhittleCostSession)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.WindowManager.whittle_cost = PointerProperty(
        type=WhittleCostSession, name="Whittle Cost", options={"SKIP_SAVE"}
    )


def unregister() -> None:
    del bpy.types.WindowManager.whittle_cost
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
