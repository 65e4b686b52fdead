# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which rows changed between two renders of the same size. No bpy."""

from collections.abc import Sequence
from dataclasses import dataclass

from .metrics import ROW_METRICS
from .rows import Row

# A row with any other of these has changed.
TELLING = ("node_visits", "triangle_tests", "triangles", "instances", "memory")


class CompareError(ValueError):
    """Two renders cannot be compared; the message says what to do."""


@dataclass(frozen=True)
class Side:
    """A render, as far as it is compared."""

    layer: str
    size: tuple[int, int]
    samples: int  # per pixel
    rows: Sequence[Row]


@dataclass(frozen=True)
class Change:
    """A row before and after; None: it was not there."""

    before: Row | None
    after: Row | None

    @property
    def row(self) -> Row:
        """The newest that there is of it."""
        return self.after or self.before

    def values(self, metric: str) -> tuple[float | None, float | None]:
        """A number before and after (see number); None: not measured."""
        return number(self.before, metric), number(self.after, metric)

    def difference(self, metric: str) -> float | None:
        """By how much a number has grown; None if it is not known of both."""
        before, after = self.values(metric)
        return None if before is None or after is None else after - before


def number(row: Row | None, metric: str) -> float | None:
    """A metric of ROW_METRICS, or "work": visits and tests. A row that is not there has none of
    what can be counted."""
    if row is None:
        return 0 if metric in (*TELLING, "work") else None
    if metric == "work":
        return sum(row.node_visits.values()) + sum(row.triangle_tests.values())
    return ROW_METRICS[metric].of(row)


def changes(before: Side, after: Side) -> list[Change]:
    """The rows that differ, those first whose work differs most. CompareError if the renders have
    another size or number of samples: then the counts say nothing."""
    if tuple(before.size) != tuple(after.size):
        raise CompareError(
            "the baseline has {} x {} pixels and this render {} x {}: render at the baseline's "
            "size, or keep a new baseline".format(*before.size, *after.size)
        )
    if before.samples != after.samples:
        raise CompareError(
            f"the baseline has {before.samples} samples a pixel and this render {after.samples}: "
            "render with as many, or keep a new baseline"
        )
    old, new = ({_key(row): row for row in side.rows} for side in (before, after))
    pairs = [Change(old.get(key), new.get(key)) for key in dict.fromkeys([*new, *old])]
    changed = [pair for pair in pairs if any(pair.difference(name) for name in TELLING)]
    return sorted(changed, key=lambda pair: -abs(pair.difference("work")))


def _key(row: Row) -> tuple[str, str, bool]:
    return row.kind, row.name, row.shared


def sentence(change: Change) -> str:
    """How the work of a row changed."""
    before, after = change.values("work")
    said = (
        f"{change.row.kind} '{change.row.title}': {before:,} visits and tests before, {after:,} now"
    )
    return f"{said} ({100 * (after - before) / before:+.1f} %)" if before else f"{said} (new)"
