# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The plots of docs/benchmarks.md."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from bench_summary import KINDS

Record = dict[str, Any]

OURS, THEIRS, PREDICTED = "#2a6f97", "#c98c3a", "#8a8a8a"


def _label(record: Record) -> str:
    return f"{record['scene']}  ({_short(record['triangles'])})"


def _short(count: float) -> str:
    """1200 as "1.2 k"."""
    for unit, name in ((1e6, " M"), (1e3, " k")):
        if count >= 0.9995 * unit:  # what three digits round up to it
            return f"{count / unit:.3g}{name}"
    return f"{count:.0f}"


def draw_scenes(records: list[Record], path: Path) -> None:
    """A panel for each kind of ray, a pair of bars for each scene; one thread."""
    alone = [r for r in records if r["threads"] == 1 and r["kind"] != "build"]
    kinds = [kind for kind in KINDS if any(r["kind"] == kind for r in alone)]
    scenes = list(dict.fromkeys(_label(r) for r in alone))
    size = (3.1 * len(kinds) + 2.2, 0.42 * len(scenes) + 1.7)
    figure, panels = plt.subplots(1, len(kinds), figsize=size, squeeze=False, layout="constrained")
    for axis, kind in zip(panels[0], kinds, strict=True):
        _draw_kind(axis, [r for r in alone if r["kind"] == kind], scenes)
        axis.set_title(kind, fontsize=11)
        axis.set_yticks(range(len(scenes)), scenes if axis is panels[0][0] else [], fontsize=9)
    figure.supxlabel(
        "millions of rays a second, one thread; the ratio behind each pair", fontsize=9
    )
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=2, frameon=False, fontsize=9)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw_kind(axis: plt.Axes, records: list[Record], scenes: list[str]) -> None:
    places = [scenes.index(_label(r)) for r in records]
    for key, label, colour, shift in (
        ("whittle", "Whittle", OURS, -0.2),
        ("embree", "Embree, its best mode", THEIRS, 0.2),
    ):
        axis.barh([p + shift for p in places], [r[key] for r in records], 0.38, None,
                  label=label, color=colour)  # fmt: skip
    top = max(max(r["whittle"], r["embree"]) for r in records)
    for place, r in zip(places, records, strict=True):
        end = max(r["whittle"], r["embree"]) + 0.02 * top
        axis.text(end, place, f"{r['ratio']:.2f} ×", va="center", fontsize=8)
    axis.set_xlim(0, 1.25 * top)
    axis.set_ylim(len(scenes) - 0.5, -0.5)
    axis.spines[["top", "right"]].set_visible(False)


def draw_growth(records: list[Record], caches: dict[str, int], path: Path) -> None:
    """Time per primary ray and per triangle built against the number of triangles; one thread."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.4), layout="constrained")
    rays = _alone(records, "primary")
    builds = _alone(records, "build")
    _draw_times(left, rays, "nanoseconds a primary ray")
    _draw_nodes(left, rays)
    _draw_times(right, builds, "nanoseconds of building a triangle")
    for axis in (left, right):
        _draw_caches(axis, builds, caches)
        axis.set_ylim(bottom=0)
        axis.set_xlabel("triangles")
        axis.spines["top"].set_visible(False)
    left.legend(loc="upper left", frameon=False, fontsize=8)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _alone(records: list[Record], kind: str) -> list[Record]:
    found = [r for r in records if r["kind"] == kind and r["threads"] == 1]
    return sorted(found, key=lambda r: r["triangles"])


def _draw_times(axis: plt.Axes, records: list[Record], title: str) -> None:
    counts = [r["triangles"] for r in records]
    for key, label, colour in (
        ("whittle", "Whittle", OURS),
        ("embree", "Embree, its best mode", THEIRS),
    ):
        times = [1e3 / r[key] for r in records]
        axis.plot(counts, times, "o-", color=colour, label=label)
    first = 1e3 / records[0]["whittle"]
    predicted = [first * math.log(n) / math.log(counts[0]) for n in counts]
    axis.plot(counts, predicted, "--", color=PREDICTED, label="log N from the first point")
    axis.set_xscale("log")
    axis.set_ylabel(title)


def _draw_nodes(axis: plt.Axes, records: list[Record]) -> None:
    """What a ray does by itself, beside the time that it takes."""
    other = axis.twinx()
    counts = [r["triangles"] for r in records]
    other.plot(counts, [r["nodes_per_ray"] for r in records], ":", color="#7a5195")
    other.set_ylabel("nodes a ray visits alone (dotted)", color="#7a5195")
    other.set_ylim(bottom=0)
    other.spines["top"].set_visible(False)


def _draw_caches(axis: plt.Axes, builds: list[Record], caches: dict[str, int]) -> None:
    """Where the finished structures outgrow each cache."""
    bytes_each = builds[-1]["whittle_bytes"] / builds[-1]["triangles"]
    low, high = builds[0]["triangles"], builds[-1]["triangles"]
    for name, size in caches.items():
        count = size / bytes_each
        if low < count < high:
            axis.axvline(count, color="#d0d0d0", linewidth=1, zorder=0)
            axis.text(count, 0.01, f" {name} is full", transform=axis.get_xaxis_transform(),
                      fontsize=8, color="#707070")  # fmt: skip
