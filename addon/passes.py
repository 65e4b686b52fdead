# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The one table of passes: what Blender calls them, what the core calls them, who wants them."""

from collections.abc import Container
from dataclasses import dataclass

import bpy


@dataclass(frozen=True)
class Pass:
    """An image that a render can make, as Blender and as the core name it."""

    name: str  # Blender's, also in files
    source: str  # the core's
    channels: str  # a letter each
    kind: str  # COLOR, VALUE or VECTOR: how colour management treats it
    switch: str | None = None  # the view layer's property that asks for it; None: always
    counter: bool = False  # asked for by scene.whittle.use_counters instead
    mode: str = ""  # the only traversal that has it, as scene.whittle.mode names it; "": all
    title: str = ""  # of a counter's heatmap, with its unit
    scale: float = 1.0  # from the pass to that unit
    top: float | None = None  # the value of the last colour, if it is always the same
    least: float = 1.0  # a heatmap's colours span at least this much


PASSES = (
    Pass("Combined", "combined", "RGBA", "COLOR"),
    Pass("Depth", "depth", "Z", "VALUE", "use_pass_z"),
    Pass("Position", "position", "XYZ", "VECTOR", "use_pass_position"),
    Pass("Normal", "normal", "XYZ", "VECTOR", "use_pass_normal"),
    Pass("Object Index", "object_index", "X", "VALUE", "use_pass_object_index"),
) + tuple(
    Pass(
        f"{what.title()}{kind and ' ' + kind.title()}",
        f"{what}{kind and '_' + kind}",
        "X",
        "VALUE",
        counter=True,
        title=f"{verb}, {kind or 'all'} rays, per pixel",
    )
    for what, verb in (("nodes", "BVH nodes visited"), ("triangles", "Triangles tested"))
    for kind in ("", "primary", "shadow", "reflection", "refraction")
)
PASSES += (
    Pass(
        "Leaf Depth",
        "leaf_depth",
        "X",
        "VALUE",
        counter=True,
        title="Deepest leaf visited, edges from the root",
    ),
    Pass(
        "Coherence",
        "coherence",
        "X",
        "VALUE",
        counter=True,
        mode="LECTURE",
        title="Coherence of packets, % of their rays active",
        scale=100.0,
        top=100.0,
    ),
    Pass(
        "Seconds",
        "seconds",
        "X",
        "VALUE",
        counter=True,
        title="Microseconds per pixel, by tile (not reproducible)",
        scale=1e6,
        least=1e-3,
    ),
)

COUNTERS = tuple(row for row in PASSES if row.counter)


def counted(sources: Container[str]) -> list[Pass]:
    """The counters among the core's names of passes that a render has made."""
    return [row for row in COUNTERS if row.source in sources]


def wanted(scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> list[Pass]:
    """The passes that a view layer of a scene asks for, in the table's order."""
    return [row for row in PASSES if _is_wanted(row, scene, layer)]


def _is_wanted(row: Pass, scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> bool:
    if row.counter:
        return scene.whittle.use_counters and row.mode in ("", scene.whittle.mode)
    return row.switch is None or getattr(layer, row.switch)
