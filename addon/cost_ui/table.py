# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The rows that the panels list, taken from the last render that counted."""

from __future__ import annotations

import fnmatch
from typing import TYPE_CHECKING, Any

import bpy

from .. import cost, results
from ..cost.compare import Change
from . import baseline, columns

if TYPE_CHECKING:
    from .properties import WhittleCostSession


class Table:
    """The rows of one view layer of the last render, all of them, dearest first."""

    def __init__(self) -> None:
        self.result: results.Result | None = None
        self.rows: list[cost.Row] = []
        self.changes: list[Change] = []  # since the baseline
        self.refused = ""  # why there are none
        self.filling = False  # the lists are being written: nobody has clicked

    def take(self, result: results.Result | None) -> None:
        if result is not self.result:
            self.result = result
            self.rows = cost.make_rows(result.cost) if result is not None else []
        self.changes, self.refused = baseline.compare(self.result, self.rows)

    def row(self, session: WhittleCostSession) -> cost.Row | None:
        """The active one."""
        place = active(session.rows, session.index)
        return None if place is None else self.rows[place]


shown = Table()


def active(items: Any, index: int) -> int | None:
    """The place that a list's active line stands for."""
    return items[index].place if index < len(items) else None


def counted() -> list[results.Result]:
    """The view layers of the last render that counted."""
    return [result for result in results.last if result.cost is not None]


def layers() -> list[str]:
    return [result.layer for result in counted()]


def fill(session: WhittleCostSession) -> None:
    """Lists the rows that the session asks for; the active row stays the same if it is listed."""
    found = counted()
    chosen = [result for result in found if result.layer == session.layer] or found
    before = shown.row(session)
    shown.take(chosen[0] if chosen else None)
    places = [
        place
        for place in columns.ordered(shown.rows, session.sort, session.descending)
        if _listed(shown.rows[place], session)
    ]
    _write(session.rows, places)
    same = [i for i, place in enumerate(places) if before and _same(shown.rows[place], before)]
    shown.filling = True
    try:
        session.index = same[0] if same else 0
        _fill_changes(session)
    finally:
        shown.filling = False


def _fill_changes(session: WhittleCostSession) -> None:
    """Lists the rows that differ from the baseline."""
    metric = columns.COMPARED[session.metric].metric
    listed = [
        place
        for place, change in enumerate(shown.changes)
        if _listed(change.row, session)
        and (change.difference(metric) or change.before is None or change.after is None)
    ]
    values = {place: _sort_value(shown.changes[place], session, metric) for place in listed}
    known = [place for place in listed if values[place] is not None]
    known.sort(key=values.__getitem__, reverse=session.change_descending)
    _write(session.changes, known + [place for place in listed if values[place] is None])
    session.change_index = 0


def _sort_value(change: Change, session: WhittleCostSession, metric: str) -> Any:
    before, after = change.values(metric)
    difference = change.difference(metric)
    return {
        "NAME": change.row.title.casefold(),
        "BEFORE": before,
        "AFTER": after,
        "DIFFERENCE": None if difference is None else abs(difference),
    }[session.change_sort]


def _listed(row: cost.Row, session: WhittleCostSession) -> bool:
    pattern = session.search.casefold().strip()
    if row.kind != session.kind.lower():
        return False
    return not pattern or fnmatch.fnmatchcase(row.title.casefold(), f"*{pattern}*")


def _same(row: cost.Row, other: cost.Row) -> bool:
    return (row.kind, row.name, row.shared) == (other.kind, other.name, other.shared)


def _write(items: Any, places: list[int]) -> None:
    items.clear()
    for place in places:
        items.add().place = place


def refresh(*_: Any) -> None:
    """Lists the last render, and draws the panels anew; on the main thread only."""
    manager = bpy.context.window_manager
    if manager is None:
        return
    fill(manager.whittle_cost)
    for window in manager.windows:
        for area in window.screen.areas:
            if area.type in ("PROPERTIES", "VIEW_3D"):
                area.tag_redraw()


def _rendered(result: results.Result) -> None:
    """Renders end on another thread, where Blender's data must not be written."""
    if not bpy.app.timers.is_registered(refresh):
        bpy.app.timers.register(refresh, persistent=True)


_loaded = bpy.app.handlers.persistent(refresh)


def register() -> None:
    results.listeners.append(_rendered)
    bpy.app.handlers.load_post.append(_loaded)
    if results.last:
        _rendered(results.last[-1])


def unregister() -> None:
    if bpy.app.timers.is_registered(refresh):
        bpy.app.timers.unregister(refresh)
    bpy.app.handlers.load_post.remove(_loaded)
    results.listeners.remove(_rendered)
    shown.__init__()
