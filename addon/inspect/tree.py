# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The nodes of a BVH as arrays: where they are, how deep, what they cost, whose they are."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

# Corners of a box by bits (x, y, z), and the pairs of them that its twelve edges join.
CORNERS = np.array([[(c >> axis) & 1 for axis in range(3)] for c in range(8)], dtype=bool)
EDGES = np.array(
    [(c, c | 1 << axis) for c in range(8) for axis in range(3) if not c >> axis & 1],
    dtype=np.uint32,
)


@dataclass(frozen=True)
class Tree:
    """A node a row, in the core's order."""

    low: NDArray[np.float32]  # (n, 3), in scene space: (world - center) / scale
    high: NDArray[np.float32]  # (n, 3)
    center: NDArray[np.float64]
    scale: float
    depth: NDArray[np.int32]  # edges from the root
    count: NDArray[np.int32]  # triangles of a leaf; 0: not a leaf
    cost: NDArray[np.float64]  # expected share of a random ray's work, in triangle tests
    instance: NDArray[np.int32]  # whose triangles lie below; -1: those of several

    @property
    def deepest(self) -> int:
        return int(self.depth.max(initial=0))


def read(scene: Any, build: dict[str, Any], traversal_cost: float = 1.0) -> Tree:
    """The tree of a built scene, whose build statistics say where scene space lies."""
    nodes = scene.nodes()
    count = nodes["count"].astype(np.int32)
    low, high = (np.ascontiguousarray(nodes[name]) for name in ("bounds_min", "bounds_max"))
    size = (high - low).astype(np.float64)
    area = size[:, 0] * size[:, 1] + size[:, 1] * size[:, 2] + size[:, 2] * size[:, 0]
    work = np.where(count > 0, count, traversal_cost)
    return Tree(
        low=low,
        high=high,
        center=np.array(build["center"]),
        scale=float(np.ldexp(1.0, int(build["exponent"]))),
        depth=depths(nodes["left_first"], count),
        count=count,
        cost=area / max(area[0], 1e-300) * work if len(area) else area,
        instance=scene.owners()["instance"],
    )


def depths(left: NDArray[np.unsignedinteger], count: NDArray[np.int32]) -> NDArray[np.int32]:
    """Edges from the root to each node; one step of numpy for each level."""
    depth = np.zeros(len(count), dtype=np.int32)
    level, nodes = 0, np.zeros(min(1, len(count)), dtype=np.int64)
    while len(nodes):
        depth[nodes] = level
        inner = left[nodes[count[nodes] == 0]].astype(np.int64)
        nodes = np.concatenate((inner, inner + 1))
        level += 1
    return depth


def corners(tree: Tree, chosen: NDArray[np.integer]) -> NDArray[np.float32]:
    """The eight corners (k, 8, 3) of the chosen nodes' boxes, in the world."""
    low, high = tree.low[chosen, np.newaxis], tree.high[chosen, np.newaxis]
    scene = np.where(CORNERS, high, low).astype(np.float64)
    return (tree.center + tree.scale * scene).astype(np.float32)


def edges(boxes: int) -> NDArray[np.uint32]:
    """The edges (12 k, 2) of so many boxes, as indices into their corners one after another."""
    first = 8 * np.arange(boxes, dtype=np.uint32)
    return (first[:, np.newaxis, np.newaxis] + EDGES).reshape(-1, 2)
