# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ratios over all scenes of a benchmark, for the front's table and the page."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

KINDS = ("primary", "shadow", "mirror", "random", "build")

Record = dict[str, Any]


@dataclass(frozen=True)
class Row:
    """Whittle's speed over Embree's best mode's, over the scenes, for a kind and a thread count."""

    kind: str
    threads: int
    scenes: int
    mean: float  # geometric
    least: float
    where: str  # the scene of the least
    most: float


def summary(records: Iterable[Record]) -> list[Row]:
    """A row for each kind and number of threads, in their order."""
    records = list(records)
    rows = []
    for kind in KINDS:
        for threads in sorted({r["threads"] for r in records if r["kind"] == kind}):
            own = [r for r in records if (r["kind"], r["threads"]) == (kind, threads)]
            least = min(own, key=lambda r: r["ratio"])
            mean = math.exp(sum(math.log(r["ratio"]) for r in own) / len(own))
            most = max(r["ratio"] for r in own)
            rows.append(Row(kind, threads, len(own), mean, least["ratio"], least["scene"], most))
    return rows


def medians(seconds: dict[str, list[float]]) -> dict[str, float]:
    """The median of each phase's rounds."""
    return {phase: statistics.median(values) for phase, values in seconds.items()}


def thread_gain(frame: dict[str, Any]) -> float:
    """How many times as fast all threads trace a frame as one thread does."""
    one, every = (statistics.median(frame["seconds"][run]["trace"]) for run in ("alone", "whittle"))
    return one / every


def cycles_a_ray(frame: dict[str, Any], phase: str) -> float:
    """All cores' clock cycles of a phase over the rays of the frame; nan without a clock."""
    seconds = statistics.median(frame["seconds"]["whittle"][phase])
    clock = frame["gigahertz"] or math.nan
    return seconds * frame["threads"] * clock * 1e9 / sum(frame["rays"].values())
