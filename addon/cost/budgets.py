# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Limits that a render must keep, such as "nodes_p95<=120" or "triangles(Tree.*)<=2e6"."""

import operator
import re
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from fnmatch import fnmatchcase
from math import isfinite

from .hints import percent
from .metrics import PIXEL_STATISTICS, ROW_METRICS, SCENE_METRICS, blame, pixel_metrics
from .rows import Row

FORM = re.compile(r"\s*(\w+)\s*(?:\((.*)\)\s*)?(<=|>=|<|>)\s*([^\s<>=]+)\s*", re.DOTALL)
COMPARE = {"<=": operator.le, "<": operator.lt, ">=": operator.ge, ">": operator.gt}
MATERIAL = "material:"


class BudgetError(ValueError):
    """A budget that cannot be judged; the message says how to write it."""


@dataclass(frozen=True)
class Verdict:
    """How a budget came out in one render."""

    budget: "Budget"
    value: float
    kept: bool
    row: Row | None  # whose number it is, or who has the largest part of it
    part: float | None  # that row's part of what is blamed, 0 to 1; None: the number is its own
    what: str  # what the part is of

    def sentence(self) -> str:
        """The budget, the number and who is behind it."""
        said = f"budget '{self.budget.text}' is {'kept' if self.kept else 'broken'}: {self.value:g}"
        if self.row is None:
            return said
        row = self.row
        who = f"{row.kind} '{row.title}'"
        if row.shared:
            who = f"nodes that several {row.kind}s share"
            if row.stretched_by:
                who += f" and '{row.stretched_by}' stretches most"
        if self.part is None:
            said += f" is that of {who}"
        else:
            said += f"; the largest part, {percent(self.part)} of the {self.what}, is that of {who}"
        return "; ".join([said, *(f"{hint.text}: {hint.mend}" for hint in row.hints)])


@dataclass(frozen=True)
class Budget:
    """One limit."""

    text: str
    metric: str
    pattern: str | None  # of names of rows; None: the whole render
    kind: str  # of those rows
    relation: str
    limit: float

    @classmethod
    def parse(cls, text: str, counters: Iterable[str]) -> "Budget":
        """Reads a budget; `counters` are the core's names of the counter passes."""
        found = FORM.fullmatch(text)
        if found is None:
            raise BudgetError(
                f"'{text}' is no budget: write METRIC<=NUMBER or METRIC(OBJECT)<=NUMBER, such as "
                "nodes_p95<=120 or 'triangles(Tree.*)<=2e6'"
            )
        metric, pattern, relation, number = found.groups()
        known = ROW_METRICS if pattern is not None else _scene_metrics(counters)
        if metric not in known:
            raise BudgetError(f"'{text}': {_unknown(metric, pattern is not None, known)}")
        try:
            limit = float(number)
        except ValueError:
            limit = float("nan")
        if not isfinite(limit):
            raise BudgetError(f"'{text}': '{number}' is not a finite number, such as 120 or 2e6")
        kind = "object"
        if pattern is not None:
            pattern = pattern.strip()
            if pattern.startswith(MATERIAL):
                kind, pattern = "material", pattern.removeprefix(MATERIAL)
        return cls(text.strip(), metric, pattern, kind, relation, limit)

    def judge(self, values: dict[str, float], rows: list[Row]) -> Verdict:
        """Holds the budget against one render; BudgetError if no row has the name, or the number
        was not measured. `values`: of the whole, as metrics.scene_values gives them."""
        if self.pattern is not None:
            return self._judge_rows(rows)
        if self.metric not in values:
            raise BudgetError(f"'{self.text}': this render does not measure {self.metric}")
        value = float(values[self.metric])
        blamed = blame(self.metric)
        parts = [(blamed.of(row), row) for row in rows if row.kind == "object"]
        total = sum(part for part, _ in parts)
        most, row = max(parts, key=lambda item: item[0], default=(0.0, None))
        if not total:
            return Verdict(self, value, self._keeps(value), None, None, "")
        return Verdict(self, value, self._keeps(value), row, most / total, blamed.what)

    def _judge_rows(self, rows: list[Row]) -> Verdict:
        of = ROW_METRICS[self.metric].of
        chosen = [row for row in rows if row.kind == self.kind and self._names(row)]
        if not chosen:
            raise BudgetError(
                f"'{self.text}': no {self.kind} of this render is called '{self.pattern}'"
            )
        values = [(of(row), row) for row in chosen]
        if any(value is None for value, _ in values):
            raise BudgetError(f"'{self.text}': {self.metric} is not measured of a {self.kind}")
        worst = max if self.relation in ("<=", "<") else min
        value, row = worst(values, key=lambda item: item[0])
        return Verdict(self, float(value), self._keeps(value), row, None, "")

    def _names(self, row: Row) -> bool:
        return not row.shared and (row.name == self.pattern or fnmatchcase(row.name, self.pattern))

    def _keeps(self, value: float) -> bool:
        return COMPARE[self.relation](value, self.limit)


def _scene_metrics(counters: Iterable[str]) -> list[str]:
    return [*SCENE_METRICS, *pixel_metrics(counters)]


def _unknown(metric: str, by_row: bool, known: Iterable[str]) -> str:
    known = list(known)
    near = get_close_matches(metric, known, 3) or known[:6]
    whose = "one object" if by_row else "the whole render"
    return f"there is no '{metric}' of {whose}, but {', '.join(near)} (--help lists all)"


def help_text(counters: Iterable[str]) -> str:
    """What budgets can be made of, for the command line's help."""
    lines = ["of the whole render, METRIC<=NUMBER (or <, >=, >):"]
    lines += [f"  {name:20} {text}" for name, text in SCENE_METRICS.items()]
    lines.append("  COUNTER_STATISTIC    by pixel, nodes and triangles for one of its samples")
    lines.append(f"    COUNTER: {', '.join(counters)}")
    lines.append(f"    STATISTIC: {', '.join(PIXEL_STATISTICS)}")
    lines.append("of objects, METRIC(NAME)<=NUMBER, where NAME may hold * and ?; of materials,")
    lines.append("METRIC(material:NAME)<=NUMBER:")
    return "\n".join(lines + [f"  {name:20} {row.text}" for name, row in ROW_METRICS.items()])
