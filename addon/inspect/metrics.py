# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a heatmap over the viewport can show, and how it follows from the core's passes."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

KINDS = ("primary", "shadow", "reflection", "refraction")


@dataclass(frozen=True)
class Metric:
    """One quantity per pixel."""

    name: str
    description: str
    unit: str  # of the legend's numbers
    passes: tuple[str, ...]  # the core's
    by_kind: bool = False  # whether each pass exists for each kind of ray
    mode: str = ""  # the traversal that it needs; "": the scene's own
    scale: float = 1.0  # from the pass to the unit
    top: float | None = None  # where an automatic range ends, if that is known beforehand


METRICS = {
    "NODES": Metric(
        "Nodes", "BVH nodes that the pixel's rays visit", "nodes visited", ("nodes",), by_kind=True
    ),
    "TRIANGLES": Metric(
        "Triangles",
        "Triangles that the pixel's rays are tested against",
        "triangles tested",
        ("triangles",),
        by_kind=True,
    ),
    "BOTH": Metric(
        "Nodes and Triangles",
        "Nodes visited and triangles tested, each times its weight",
        "weighted visits and tests",
        ("nodes", "triangles"),
        by_kind=True,
    ),
    "LEAF_DEPTH": Metric(
        "Leaf Depth",
        "The deepest leaf of the BVH that the pixel's rays visit, in edges from the root",
        "depth of the deepest leaf visited",
        ("leaf_depth",),
    ),
    "COHERENCE": Metric(
        "Packet Coherence",
        "How many of the rays of the pixel's packets entered the nodes that the packet visited; "
        "traced in packets on the binary tree",
        "% of the packets' rays active",
        ("coherence",),
        mode="lecture",
        scale=100.0,
        top=100.0,
    ),
    "SECONDS": Metric(
        "Time by Tile",
        "Wall time of the pixel's tile, shared evenly by its pixels. Unlike all others it differs "
        "from run to run",
        "microseconds by tile, not reproducible",
        ("seconds",),
        scale=1e6,
    ),
}


@dataclass(frozen=True)
class Choice:
    """A metric with all that changes its values; equal choices have equal heatmaps."""

    metric: str = "NODES"
    kinds: frozenset[str] = frozenset(KINDS)
    weights: tuple[float, float] = (1.0, 1.0)  # of a node and of a triangle, for BOTH

    @property
    def row(self) -> Metric:
        return METRICS[self.metric]

    def passes(self) -> list[str]:
        """The core's passes that the values follow from."""
        row = self.row
        if not row.by_kind or self.kinds == frozenset(KINDS):
            return list(row.passes)
        kinds = [kind for kind in KINDS if kind in self.kinds] or KINDS[:1]
        return [f"{name}_{kind}" for name in row.passes for kind in kinds]

    def values(self, image: Mapping[str, NDArray[np.float32]]) -> NDArray[np.float32]:
        """The metric (h, w), in its unit, of a render that holds passes()."""
        total: NDArray[np.float32] | None = None
        for name in self.passes():
            part = image[name][..., 0] * np.float32(self._factor(name))
            total = part if total is None else total + part
        return np.ascontiguousarray(total)

    def _factor(self, name: str) -> float:
        if self.row.by_kind and not self.kinds:
            return 0.0
        if self.metric != "BOTH":
            return self.row.scale
        return self.weights[0 if name.startswith("nodes") else 1]

    def kinds_text(self) -> str:
        """Whose rays are counted, for the legend."""
        if not self.row.by_kind or self.kinds == frozenset(KINDS):
            return "all rays"
        chosen = [kind for kind in KINDS if kind in self.kinds]
        return " + ".join(chosen) + " rays" if chosen else "no rays"
