# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The one table of passes: what Blender calls them, what the core calls them, who wants them."""

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
    title: str = ""  # of a counter's heatmap


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
        title=f"{verb}, {kind or 'all'} rays",
    )
    for what, verb in (("nodes", "BVH nodes visited"), ("triangles", "Triangles tested"))
    for kind in ("", "primary", "shadow", "reflection", "refraction")
)

COUNTERS = tuple(row for row in PASSES if row.counter)


def wanted(scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> list[Pass]:
    """The passes that a view layer of a scene asks for, in the table's order."""
    return [row for row in PASSES if _is_wanted(row, scene, layer)]


def _is_wanted(row: Pass, scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> bool:
    if row.counter:
        return scene.whittle.use_counters
    return row.switch is None or getattr(layer, row.switch)
