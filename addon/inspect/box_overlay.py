# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The boxes of the BVH as lines in the scene: one batch, made anew only when something changes."""

from typing import Any

import bpy

from . import boxes, draw, legend, probe_overlay, source, tree
from .properties import WhittleOverlay

shown: boxes.Drawing | None = None
"""What was drawn last."""

_key: Any = None
_batch: Any = None
_tree: tuple[int, tree.Tree] | None = None


def of_source() -> tree.Tree:
    """The tree of the scene that is ready, read once for each."""
    global _tree
    shared = source.shared
    if _tree is None or _tree[0] != shared.generation:
        _tree = (shared.generation, tree.read(shared.scene, shared.build))
    return _tree[1]


def wanted(context: bpy.types.Context) -> boxes.Filter:
    """What the settings, the selection and the probe ask for."""
    settings = context.scene.whittle_overlay
    instances = nodes = None
    if settings.box_selected:
        names = {ob.name for ob in context.selected_objects}
        instances = boxes.instances_of(source.shared.places, names)
    if settings.box_probed:
        nodes = probe_overlay.visited(context)
    return boxes.Filter(
        depth=(settings.box_depth_min, settings.box_depth_max),
        leaves=settings.box_leaves,
        instances=instances,
        nodes=nodes,
        color=settings.box_color,
        limit=settings.box_limit,
    )


def paint(context: bpy.types.Context) -> None:
    """Draws the boxes that are asked for."""
    global _key, _batch, shown
    shared, settings = source.shared, context.scene.whittle_overlay
    if shared.scene is None and not shared.building:
        return
    ask = wanted(context)
    key = (shared.generation, ask, settings.box_colormap, settings.box_opacity)
    if key != _key and shared.scene is not None:
        grown = of_source()
        shown = boxes.choose(grown, ask)
        points = tree.corners(grown, shown.chosen).reshape(-1, 3)
        colors = boxes.colors(shown, settings.box_colormap, settings.box_opacity)
        pairs = tree.edges(len(shown.chosen))
        _batch = draw.line_batch(points, colors, pairs) if len(pairs) else None
        _key = key
    if _batch is not None:
        draw.lines(_batch, in_front=settings.box_in_front)


def explain(settings: WhittleOverlay) -> legend.Legend | None:
    """What the boxes' colours mean, and how many are drawn."""
    if shown is None or (source.shared.scene is None and not source.shared.building):
        return None
    cut = shown.asked > len(shown.chosen)
    return legend.Legend(
        title=f"BVH boxes by {shown.unit}",
        lines=() if cut else (boxes.caption(shown),),
        warning=boxes.caption(shown) if cut else "",
        colormap=settings.box_colormap,
        span=shown.span if len(shown.chosen) else None,
        logarithmic=settings.box_color == "COST",
    )


def forget() -> None:
    """Lets go of the batch and the tree."""
    global _key, _batch, _tree, shown
    _key = _batch = _tree = shown = None
