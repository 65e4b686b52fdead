# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The columns of the table of cost: their titles, numbers and texts."""

from collections.abc import Callable
from dataclasses import dataclass
from math import log10

from ..cost.metrics import ROW_METRICS
from ..cost.rows import Row

NOT_MEASURED = "-"


def percent(share: float) -> str:
    """A share with a digit that tells small ones from nothing."""
    return f"{100 * share:.1f} %" if share == 0 or share >= 0.0005 else "< 0.1 %"


def count(number: float) -> str:
    """A count as short as a column is narrow: 12,345 or 1.23 M."""
    for size, unit in ((1e12, "T"), (1e9, "G"), (1e6, "M")):
        if number >= size:
            digits = max(0, 2 - int(log10(number / size)))
            return f"{number / size:.{digits}f} {unit}"
    return f"{number:,.0f}"


def memory(number: float) -> str:
    """Bytes in the unit that fits."""
    for size, unit in ((2**30, "GiB"), (2**20, "MiB"), (2**10, "KiB")):
        if number >= size:
            return f"{number / size:.1f} {unit}"
    return f"{number:.0f} B"


def decimal(number: float) -> str:
    return f"{number:,.3g}" if number < 1000 else f"{number:,.0f}"


@dataclass(frozen=True)
class Column:
    """A number of each row that the table can show, and sort by."""

    title: str
    name: str
    description: str
    metric: str  # in ROW_METRICS
    form: Callable[[float], str]

    def of(self, row: Row) -> float | None:
        """None: it is not measured of such a row."""
        if row.shared and self.metric in ("box_fill", "overlap", "sah_cost"):
            return None
        return ROW_METRICS[self.metric].of(row)

    def text(self, row: Row) -> str:
        value = self.of(row)
        return NOT_MEASURED if value is None else self.form(value)


COLUMNS = {
    "WORK": Column("Work", "Work", "Share of all node visits and triangle tests", "share", percent),
    "NODES": Column("Visits", "Node Visits", "Share of all node visits", "node_share", percent),
    "TESTS": Column(
        "Tests", "Triangle Tests", "Share of all triangle tests", "test_share", percent
    ),
    "TRIANGLES": Column(
        "Triangles", "Triangles", "In the BVH, all instances together", "triangles", count
    ),
    "MEMORY": Column(
        "Memory",
        "Memory",
        "Of triangles, nodes, and the mesh that instances share",
        "memory",
        memory,
    ),
    "BUILD": Column(
        "Build",
        "Build Time",
        "Share of the build's time, judged by triangles",
        "build_share",
        percent,
    ),
    "FILL": Column(
        "Fill",
        "Box Fill",
        "How well triangles fill their boxes: near 0 they are long, thin and diagonal",
        "box_fill",
        decimal,
    ),
    "OVERLAP": Column(
        "Overlap",
        "Overlap",
        "Share of the surface in leaf boxes of other objects; with Judge Objects",
        "overlap",
        percent,
    ),
    "SAH": Column(
        "Own SAH",
        "SAH Cost of its Own",
        "What a ray pays in a BVH of this object alone; with Judge Objects",
        "sah_cost",
        decimal,
    ),
}

ITEMS = tuple((key, row.name, row.description) for key, row in COLUMNS.items())
FLAGS = tuple((*item, 1 << index) for index, item in enumerate(ITEMS))
SORTS = (("NAME", "Name", "Alphabetically"), *ITEMS)


def ordered(rows: list[Row], sort: str, descending: bool) -> list[int]:
    """Places of the rows in the order of a column ("NAME" or a key of COLUMNS); rows of which the
    number is not measured come last either way."""
    places = range(len(rows))
    if sort == "NAME":
        return sorted(places, key=lambda i: rows[i].title.casefold(), reverse=descending)
    values = [COLUMNS[sort].of(row) for row in rows]
    known = [place for place in places if values[place] is not None]
    known.sort(key=lambda place: values[place], reverse=descending)
    return known + [place for place in places if values[place] is None]


@dataclass(frozen=True)
class Compared:
    """A number that is compared between renders."""

    name: str
    description: str
    metric: str  # of cost.compare.number
    form: Callable[[float], str]


COMPARED = {
    "WORK": Compared("Work", "Node visits and triangle tests together", "work", count),
    "NODES": Compared("Node Visits", "Of all rays", "node_visits", count),
    "TESTS": Compared("Triangle Tests", "Of all rays", "triangle_tests", count),
    "TRIANGLES": Compared("Triangles", "In the BVH", "triangles", count),
    "MEMORY": Compared("Memory", "In the BVH and its meshes", "memory", memory),
    "FILL": Compared("Box Fill", "How well triangles fill their boxes", "box_fill", decimal),
    "OVERLAP": Compared("Overlap", "Share in leaf boxes of others", "overlap", percent),
    "SAH": Compared("SAH Cost of its Own", "In a BVH of this object alone", "sah_cost", decimal),
}

CHANGES = tuple((key, row.name, row.description) for key, row in COMPARED.items())


def signed(value: float, form: Callable[[float], str]) -> str:
    """A difference with its sign."""
    return f"{'+' if value > 0 else '-' if value < 0 else ''}{form(abs(value))}"
