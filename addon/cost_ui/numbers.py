# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers of the cost panels as text."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..cost.packets import shares
from ..results import Result
from .columns import count, decimal, memory, percent

MOST_BARS = 12


def totals(result: Result) -> list[str]:
    """The sum of all rows: what the render's statistics say."""
    counted = result.cost.cost["instance"]
    visits, tests = int(counted["nodes"].sum()), int(counted["triangles"].sum())
    return [f"All: {visits:,} node visits", f"and {tests:,} triangle tests"]


def tree(result: Result) -> list[tuple[str, str]]:
    """What the whole tree is like."""
    quality, rays = result.cost.quality, max(1, result.rays())
    counted = result.cost.cost["instance"]
    visits, tests = int(counted["nodes"].sum()), int(counted["triangles"].sum())
    overlap = [("Overlap (EPO)", decimal(quality["overlap"]))] if "overlap" in quality else []
    return [
        ("SAH Cost", decimal(quality["sah_cost"])),
        *overlap,
        ("Visits per Ray", decimal(visits / rays)),
        ("Tests per Ray", decimal(tests / rays)),
        ("Nodes", f"{quality['nodes']:,}"),
        ("Leaves", f"{quality['leaves']:,}"),
        ("Memory", memory(quality["bytes"])),
        ("Depth", f"{quality['depth']:,}"),
        ("Largest Leaf", f"{quality['largest_leaf']:,} triangles"),
        ("Mean Box Fill", decimal(quality["box_fill"])),
        ("Slivers", percent(quality["slivers"] / max(1, quality["triangles"]))),
    ]


def packets(result: Result) -> list[tuple[str, str]]:
    """How the lecture's packets went; nothing if another traversal ran."""
    found = shares(result.render)
    if found is None:
        return []
    stats, share, decided = result.render, found["coherence"], found["decided"]
    return [
        ("Coherence", _percent(share)),
        ("Rays / Rays at a Node", f"{1 / share:.3f}" if share else "-"),
        (f"Use of {found['lanes']} Lanes, Nodes", _percent(found["node_lane_use"])),
        (f"Use of {found['lanes']} Lanes, Tests", _percent(found["triangle_lane_use"])),
        ("Packets", f"{stats['packets']:,}"),
        ("Rays per Packet", decimal(stats["packet_rays"] / stats["packets"])),
        ("Nodes per Packet", decimal(stats["packet_nodes"] / stats["packets"])),
        ("First Ray Decided", _percent(decided["first"])),
        ("Frustum Decided", _percent(decided["frustum"])),
        ("Ray by Ray Decided", _percent(decided["brute_force"])),
    ]


def _percent(share: float | None) -> str:
    return "-" if share is None else percent(share)


def histogram(counts: NDArray[np.uint64]) -> list[tuple[str, int, float]]:
    """Bars of a histogram: the values they stand for, their count, and its share of the largest.
    Neighbours are brought together until there are a dozen at most."""
    counts = np.asarray(counts)
    used = np.flatnonzero(counts)
    if not used.size:
        return []
    first, last = int(used[0]), int(used[-1])
    width = -(-(last - first + 1) // MOST_BARS)
    starts = range(first, last + 1, width)
    sums = [int(counts[start : start + width].sum()) for start in starts]
    ends = [min(start + width - 1, last) for start in starts]
    names = [f"{a}" if a == b else f"{a}-{b}" for a, b in zip(starts, ends, strict=True)]
    return [(name, n, n / max(sums)) for name, n in zip(names, sums, strict=True)]


def whole(before: Result, after: Result) -> list[tuple[str, ...]]:
    """The whole render before and after: name, two numbers, and the change in percent."""
    rows = []
    for name, form, of in (
        ("Visits", count, lambda one: int(one.cost.cost["instance"]["nodes"].sum())),
        ("Tests", count, lambda one: int(one.cost.cost["instance"]["triangles"].sum())),
        ("SAH Cost", decimal, lambda one: one.cost.quality["sah_cost"]),
        ("Nodes", count, lambda one: one.cost.quality["nodes"]),
        ("Memory", memory, lambda one: one.cost.quality["bytes"]),
    ):
        old, new = of(before), of(after)
        change = f"{100 * (new - old) / old:+.1f} %" if old else "-"
        rows.append((name, form(old), form(new), change))
    return rows


def plain(value: Any) -> str:
    """A setting's value: names as they read."""
    return value.title() if isinstance(value, str) else decimal(value)
