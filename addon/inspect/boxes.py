# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which boxes of the BVH are drawn, and in which colours."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..export.meshes import Place
from ..heat import colormaps
from .tree import Tree

DECADES = 4.0  # of cost that the colours span, below the highest


@dataclass(frozen=True)
class Filter:
    """What the panel asks for; equal filters of equal trees draw the same boxes."""

    depth: tuple[int, int] = (0, 64)  # lowest and highest, both drawn
    leaves: bool = False  # only those
    instances: frozenset[int] | None = None  # only nodes that are theirs alone; None: any
    nodes: tuple[int, ...] | None = None  # only these, such as a ray visited; None: any
    color: str = "DEPTH"  # DEPTH, COST or LEAF
    limit: int = 20_000  # boxes


@dataclass(frozen=True)
class Drawing:
    """The boxes that are drawn."""

    chosen: NDArray[np.int64]  # their nodes
    asked: int  # how many the filter lets through; more than were chosen if the limit was met
    shade: NDArray[np.float32]  # of each, in [0, 1]: where on the colour map
    span: tuple[float, float]  # the values of the map's ends
    unit: str


def choose(tree: Tree, wanted: Filter) -> Drawing:
    """Applies a filter; beyond the limit, the nodes nearest to the root are taken."""
    low, high = wanted.depth
    keep = (tree.depth >= low) & (tree.depth <= high)
    if wanted.leaves or wanted.color == "LEAF":
        keep &= tree.count > 0
    if wanted.instances is not None:
        keep &= np.isin(tree.instance, np.array(sorted(wanted.instances), dtype=np.int64))
    if wanted.nodes is not None:
        visited = np.zeros(len(keep), dtype=bool)
        visited[list(wanted.nodes)] = True
        keep &= visited
    chosen = np.flatnonzero(keep)
    asked = len(chosen)
    if asked > wanted.limit:
        chosen = _nearest(tree.depth[chosen], chosen, wanted.limit)
    return Drawing(chosen, asked, *_shade(tree, chosen, wanted))


def _nearest(depth: NDArray[np.int32], nodes: NDArray[np.int64], limit: int) -> NDArray[np.int64]:
    """So many nodes of the lowest depths, in their order; of the last depth the first ones."""
    below = np.cumsum(np.bincount(depth))
    last = int(np.searchsorted(below, limit))
    whole, edge = nodes[depth < last], nodes[depth == last]
    return np.sort(np.concatenate((whole, edge[: limit - len(whole)])))


def _shade(
    tree: Tree, chosen: NDArray[np.int64], wanted: Filter
) -> tuple[NDArray[np.float32], tuple[float, float], str]:
    """Place of each box on the colour map, the values of the map's ends, and their name."""
    if wanted.color == "COST":
        cost = np.log10(np.maximum(tree.cost[chosen], 1e-30))
        top = float(cost.max(initial=-30.0))
        shade = (cost - (top - DECADES)) / DECADES
        return _clipped(shade), (10.0 ** (top - DECADES), 10.0**top), "expected work, logarithmic"
    if wanted.color == "LEAF":
        top = float(max(tree.count[chosen].max(initial=1), 2))
        return _clipped((tree.count[chosen] - 1) / (top - 1)), (1.0, top), "triangles in the leaf"
    top = float(max(min(wanted.depth[1], tree.deepest), 1))
    low = float(min(wanted.depth[0], top - 1))
    return _clipped((tree.depth[chosen] - low) / (top - low)), (low, top), "depth"


def _clipped(values: NDArray[np.floating]) -> NDArray[np.float32]:
    return np.clip(values, 0.0, 1.0).astype(np.float32)


def colors(drawing: Drawing, colormap: str, opacity: float) -> NDArray[np.float32]:
    """A colour (8 k, 4) for each corner of each box, in the order of tree.corners."""
    made = np.full((len(drawing.chosen), 4), opacity, dtype=np.float32)
    made[:, :3] = colormaps.apply(colormap, drawing.shade)
    return np.repeat(made, 8, axis=0)


def instances_of(places: Mapping[int, Place], names: set[str]) -> frozenset[int]:
    """The instances that show these objects, or were placed by them."""
    return frozenset(
        index
        for index, place in places.items()
        if place.object in names or place.instancer in names
    )


def caption(drawing: Drawing) -> str:
    """How many boxes are drawn, and how many are not."""
    count = len(drawing.chosen)
    if drawing.asked > count:
        return f"{count:,} of {drawing.asked:,} boxes: the limit; those nearest to the root"
    return f"{count:,} boxes" if count != 1 else "1 box"
