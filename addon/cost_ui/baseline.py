# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The result that later ones are compared with, and the map of their differences."""

from dataclasses import dataclass
from typing import Any

from .. import cost, heat, results
from ..cost.compare import Change, CompareError, Side, changes


@dataclass
class Baseline:
    """A kept render: all its view layers that counted."""

    name: str
    layers: list[results.Result]
    rows: dict[str, list[cost.Row]]  # by view layer

    def of(self, layer: str) -> results.Result | None:
        return next((result for result in self.layers if result.layer == layer), None)


kept: Baseline | None = None


def keep(name: str, counted: list[results.Result]) -> None:
    """Makes a render the baseline; `counted`: its view layers, each with cost."""
    global kept
    rows = {result.layer: cost.make_rows(result.cost) for result in counted}
    kept = Baseline(name, list(counted), rows)


def clear() -> None:
    global kept
    kept = None


def compare(result: results.Result | None, rows: list[cost.Row]) -> tuple[list[Change], str]:
    """The rows that differ from the baseline, and why it cannot be told (or "")."""
    if kept is None or result is None:
        return [], ""
    before = kept.of(result.layer)
    if before is result:
        return [], ""
    if before is None:
        return [], f"the baseline has no view layer '{result.layer}': keep a new baseline"
    sides = (_side(before, kept.rows[before.layer]), _side(result, rows))
    try:
        return changes(*sides), ""
    except CompareError as error:
        return [], str(error)


def _side(result: results.Result, rows: list[cost.Row]) -> Side:
    return Side(result.layer, result.size, result.cost.samples, rows)


def settings_changed(result: results.Result) -> list[tuple[str, Any, Any]]:
    """Settings that are not those of the baseline: name, before, now."""
    before = kept.of(result.layer) if kept else None
    if before is None:
        return []
    names = dict.fromkeys([*before.settings, *result.settings])
    pairs = [(name, before.settings.get(name), result.settings.get(name)) for name in names]
    return [pair for pair in pairs if pair[1] != pair[2]]


def difference_map(result: results.Result) -> Any:
    """The picture (h, w, 3) of where work was added and saved; CompareError, heat.HeatError."""
    before = kept.of(result.layer) if kept else None
    if before is None:
        raise CompareError("there is no baseline with this view layer: keep one")
    if before.size != result.size or before.cost.samples != result.cost.samples:
        raise CompareError(compare(result, [])[1])
    work = [one.counters["nodes"] + one.counters["triangles"] for one in (before, result)]
    return heat.draw_difference(*work, "Visits and tests per pixel, now - before")


def unregister() -> None:
    clear()


def register() -> None:
    """Nothing is kept at first."""
