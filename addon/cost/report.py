# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The cost of rendered frames, held against budgets and written as cost.json and cost.csv."""

import os
from collections.abc import Sequence
from typing import Any

from ..results import Result
from . import files
from .budgets import Budget, Verdict
from .compare import Change, Side, changes
from .metrics import scene_values
from .packets import shares
from .rows import Row, make_rows


class Report:
    """Grows by a frame at a time."""

    def __init__(
        self, file: str, budgets: Sequence[Budget], before: files.Before | None = None
    ) -> None:
        """`file`: the .blend's path, "" for a scene that was never saved; `before`: what each
        frame is compared with."""
        self._file = file
        self._budgets = budgets
        self._before = before
        self._frames: list[dict[str, Any]] = []
        self.changes: list[Change] = []  # of the view layer added last

    def add(self, result: Result) -> list[Verdict]:
        """Adds a view layer of a frame that was rendered with cost, and judges it. BudgetError or
        CompareError if that cannot be done; then it is added without verdicts or changes."""
        rows = make_rows(result.cost)
        values = scene_values(result.cost, result.counters, result.rays())
        place = {name: getattr(result, name) for name in ("scene", "layer", "frame", "size")}
        frame = files.frame_dict(place, result.cost, rows, values, shares(result.render))
        self._frames.append(frame)
        self.changes = self._compare(result, rows, frame)
        verdicts = [budget.judge(values, rows) for budget in self._budgets]
        frame["budgets"] = [files.verdict_dict(verdict) for verdict in verdicts]
        return verdicts

    def _compare(self, result: Result, rows: list[Row], frame: dict[str, Any]) -> list[Change]:
        if self._before is None:
            return []
        number, before = self._before.of(result.frame, result.layer)
        after = Side(result.layer, result.size, result.cost.samples, rows)
        changed = changes(before, after)
        frame["baseline"] = files.baseline_dict(self._before, number, changed)
        return changed

    def write(self, folder: str) -> list[str]:
        """Writes both files; each appears under its name only when it is whole."""
        texts = {
            "cost.json": files.to_json(self._file, self._frames),
            "cost.csv": files.to_csv(self._frames),
        }
        paths = []
        for name, text in texts.items():
            path = os.path.join(folder, name)
            with open(f"{path}.partial", "w", encoding="utf-8", newline="") as file:
                file.write(text)
            os.replace(f"{path}.partial", path)
            paths.append(path)
        return paths
