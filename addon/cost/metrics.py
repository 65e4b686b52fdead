# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers that budgets can limit: of the whole render, and of one row."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .measured import Measured
from .rows import KINDS, Row

PIXEL_STATISTICS: dict[str, Callable[[NDArray[np.floating]], float]] = {
    "mean": lambda counts: float(np.mean(counts, dtype=np.float64)),
    "p50": lambda counts: float(np.percentile(counts, 50)),
    "p90": lambda counts: float(np.percentile(counts, 90)),
    "p95": lambda counts: float(np.percentile(counts, 95)),
    "p99": lambda counts: float(np.percentile(counts, 99)),
    "max": lambda counts: float(np.max(counts)),
}


@dataclass(frozen=True)
class RowMetric:
    """A number of a row."""

    text: str
    of: Callable[[Row], float | None]


ROW_METRICS = {
    "triangles": RowMetric("in the tree, all instances together", lambda row: row.triangles),
    "instances": RowMetric("of the object", lambda row: row.instances),
    "memory": RowMetric("bytes", lambda row: row.memory),
    "node_visits": RowMetric("of all rays", lambda row: sum(row.node_visits.values())),
    "triangle_tests": RowMetric("of all rays", lambda row: sum(row.triangle_tests.values())),
    "share": RowMetric("of all visits and tests, 0 to 1", lambda row: row.share),
    "node_share": RowMetric("of all node visits, 0 to 1", lambda row: row.node_share),
    "test_share": RowMetric("of all triangle tests, 0 to 1", lambda row: row.test_share),
    "memory_share": RowMetric("of all memory, 0 to 1", lambda row: row.memory_share),
    "build_share": RowMetric("of all triangles, 0 to 1", lambda row: row.build_share),
    "box_fill": RowMetric("mean of the triangles, 0 to 1", lambda row: row.box_fill),
    "sliver_share": RowMetric("of the triangles, 0 to 1", lambda row: _slivers(row)),
    "stretch": RowMetric("of the surface of shared boxes, 0 to 1", lambda row: row.stretch),
    "overlap": RowMetric("of its surface in others' leaf boxes, 0 to 1", lambda row: row.overlap),
    "sah_cost": RowMetric("of a tree of its own", lambda row: row.sah_cost),
    "stray_share": RowMetric("of its own box's surface, 0 to 1", lambda row: row.stray_share),
    "triangles_per_pixel": RowMetric("in its place in the picture", lambda row: _density(row)),
}


def _slivers(row: Row) -> float:
    return row.slivers / row.triangles if row.triangles else 0.0


def _density(row: Row) -> float | None:
    """Out of the picture no pixel has too many triangles."""
    if row.triangles_per_pixel is None and row.kind == "object":
        return 0.0
    return row.triangles_per_pixel


SCENE_METRICS = {
    "triangles": "in the tree, all instances together",
    "instances": "of meshes",
    "memory": "bytes",
    "rays": "of all kinds",
    "node_visits": "of all rays",
    "triangle_tests": "of all rays",
    "sah_cost": "of the whole tree",
    "overlap": "of the whole tree (EPO)",
    "depth": "of the deepest leaf",
    "box_fill": "mean of all triangles, 0 to 1",
    "sliver_share": "of all triangles, 0 to 1",
}


def pixel_metrics(counters: Iterable[str]) -> list[str]:
    """Names of the numbers made of counts by pixel: "nodes_shadow_p95"."""
    return [f"{counter}_{name}" for counter in counters for name in PIXEL_STATISTICS]


def is_summed(counter: str) -> bool:
    """Whether a counter adds up over the samples of a pixel."""
    return counter.split("_")[0] in ("nodes", "triangles")


def scene_values(
    measured: Measured, counters: Mapping[str, NDArray[np.floating]], rays: int
) -> dict[str, float]:
    """All numbers of a whole render by name. Those of pixels are for one sample, whatever the
    number of samples; `counters`: (h, w) by name, as the render gives them."""
    quality, cost = measured.quality, measured.cost["instance"]
    values = {
        "triangles": quality["triangles"],
        "instances": len(measured.names.objects),
        "memory": quality["bytes"],
        "rays": rays,
        "node_visits": int(cost["nodes"].sum()),
        "triangle_tests": int(cost["triangles"].sum()),
        "sah_cost": quality["sah_cost"],
        "depth": quality["depth"],
        "box_fill": quality["box_fill"],
        "sliver_share": quality["slivers"] / max(1, quality["triangles"]),
    }
    if "overlap" in quality:
        values["overlap"] = quality["overlap"]
    for counter, counts in counters.items():
        scale = measured.samples if is_summed(counter) else 1
        for name, statistic in PIXEL_STATISTICS.items():
            values[f"{counter}_{name}"] = statistic(counts) / scale
    return values


@dataclass(frozen=True)
class Blame:
    """By which numbers of the rows a metric of the whole is divided among them."""

    what: str
    of: Callable[[Row], float]


def blame(metric: str) -> Blame:
    """What a row has to have most of to be named when a metric of the whole is too large."""
    kinds = [kind for kind in KINDS if f"_{kind}" in metric] or list(KINDS)
    rays = f" of {kinds[0]} rays" if len(kinds) == 1 else ""
    if metric.startswith("node"):
        return Blame(f"node visits{rays}", lambda row: sum(row.node_visits[kind] for kind in kinds))
    if metric.startswith("triangle") and metric != "triangles":
        return Blame(
            f"triangle tests{rays}", lambda row: sum(row.triangle_tests[kind] for kind in kinds)
        )
    if metric in ("triangles", "instances", "memory"):
        return Blame(metric, lambda row: getattr(row, metric))
    if metric in ("box_fill", "sliver_share"):
        return Blame("slivers", lambda row: row.slivers)
    return Blame("node visits and triangle tests", lambda row: row.share)
