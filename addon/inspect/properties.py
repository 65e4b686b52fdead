# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the overlays show: settings kept in each scene, and switches of the session."""

from functools import partial
from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from .. import properties
from ..callbacks import late
from ..heat import colormaps
from .metrics import KINDS, METRICS, Choice

KIND_ITEMS = (
    ("primary", "Primary", "Rays from the view", 1),
    ("shadow", "Shadow", "Rays to the lights", 2),
    ("reflection", "Reflection", "Rays that mirrors and glass reflect", 4),
    ("refraction", "Refraction", "Rays that glass lets through", 8),
)
METRIC_ITEMS = tuple((key, row.name, row.description) for key, row in METRICS.items())


def redraw(owner: Any = None, context: Any = None) -> None:
    """Draws all 3D viewports anew; what they then need is made in the background."""
    manager = bpy.context.window_manager
    for window in manager.windows if manager else ():
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


# Whatever is set is seen at once.
Bool, Enum, Float, Int = (
    partial(kind, update=late(__name__, "redraw"))
    for kind in (BoolProperty, EnumProperty, FloatProperty, IntProperty)
)
Switch = partial(Bool, default=False, options={"SKIP_SAVE"})


class WhittleOverlay(bpy.types.PropertyGroup):
    """Settings of the overlays, kept in each scene as ``scene.whittle_overlay``."""

    metric: Enum(
        name="Metric",
        description="What the colours stand for",
        items=METRIC_ITEMS,
        default="NODES",
    )
    kinds: Enum(
        name="Rays",
        description="The kinds of rays whose work is counted",
        items=KIND_ITEMS,
        default=set(KINDS),
        options={"ENUM_FLAG"},
    )
    node_weight: Float(
        name="Node",
        description="What a visit to a BVH node counts",
        default=1.0,
        min=0.0,
        soft_max=10.0,
    )
    triangle_weight: Float(
        name="Triangle",
        description="What a test of a triangle counts",
        default=1.0,
        min=0.0,
        soft_max=10.0,
    )
    samples: Enum(
        name="Samples",
        description="Primary rays for each pixel; their work adds up",
        items=tuple((str(n), str(n), f"{n} for each pixel") for n in (1, 4, 9, 16)),
        default="1",
    )
    colormap: Enum(
        name="Colours",
        description="The colours from low to high",
        items=colormaps.ITEMS,
        default="VIRIDIS",
    )
    opacity: Float(
        name="Opacity",
        description="How much of the viewport the heatmap covers; 1 shows the colours exactly",
        default=0.85,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
    )
    range: Enum(
        name="Range",
        description="The values that the colours span",
        items=(
            ("AUTO", "Automatic", "From 0 to what 99.5 % of the view's pixels stay below"),
            ("FIXED", "Fixed", "Between two numbers, so that views and scenes can be compared"),
        ),
        default="AUTO",
    )
    low: Float(
        name="Lowest",
        description="The value of the first colour, with a fixed range",
        default=0.0,
    )
    high: Float(
        name="Highest",
        description="The value of the last colour, with a fixed range",
        default=100.0,
    )
    show_legend: Bool(
        name="Legend",
        description="Show what the colours mean, with numbers",
        default=True,
    )
    show_histogram: Bool(
        name="Histogram",
        description="Show in the legend how many pixels have each colour (by its square root)",
        default=True,
    )
    automatic: Bool(
        name="Automatic Update",
        description=(
            "Read the scene again shortly after it changes, "
            "unless reading it makes the window wait for more than half a second"
        ),
        default=True,
    )
    box_depth_min: Int(
        name="From Depth",
        description="Boxes nearer to the root of the BVH are not drawn; 0 is the root",
        default=0,
        min=0,
        soft_max=40,
    )
    box_depth_max: Int(
        name="To Depth",
        description="Boxes farther from the root of the BVH are not drawn",
        default=8,
        min=0,
        soft_max=40,
    )
    box_color: Enum(
        name="Colour By",
        description="What the colours of boxes stand for",
        items=(
            ("DEPTH", "Depth", "How far the node is from the root"),
            (
                "COST",
                "Surface Area Cost",
                "The work that a random ray is expected to have at the node: its share of the "
                "root's area, times its triangles if it is a leaf",
            ),
            ("LEAF", "Leaf Size", "How many triangles the leaf holds; only leaves are drawn"),
        ),
        default="DEPTH",
    )
    box_colormap: Enum(
        name="Colours",
        description="The colours of boxes from low to high",
        items=colormaps.ITEMS,
        default="TURBO",
    )
    box_leaves: Bool(
        name="Only Leaves",
        description="Draw only the boxes that hold triangles",
        default=False,
    )
    box_selected: Bool(
        name="Only Selected Objects",
        description="Draw only the boxes that hold triangles of a single, selected object",
        default=False,
    )
    box_probed: Bool(
        name="Only Visited by the Ray",
        description="Draw only the boxes that the probe's active ray visited",
        default=False,
    )
    box_limit: Int(
        name="At Most",
        description="Boxes drawn at once, twelve lines each; those nearest to the root come first",
        default=20_000,
        min=1,
        soft_max=200_000,
    )
    box_opacity: Float(
        name="Opacity",
        description="How much the lines of boxes cover what lies behind",
        default=0.8,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
    )
    box_in_front: Bool(
        name="In Front",
        description="Draw boxes over the objects, not hidden by them",
        default=True,
    )
    probe_all: Bool(
        name="All Rays",
        description="Draw all rays of the pixel, not only the active one",
        default=True,
    )
    probe_triangles: Bool(
        name="Tested Triangles",
        description="Fill the triangles that the active ray was tested against",
        default=True,
    )


class WhittleRay(bpy.types.PropertyGroup):
    """A row of the probe's list."""

    kind: StringProperty(name="Kind", description="What the ray was traced for")
    level: IntProperty(name="Level", description="Rays between this one and the view")
    nodes: IntProperty(name="Nodes", description="Nodes of the BVH that it visited")
    triangles: IntProperty(name="Triangles", description="Triangles that it was tested against")


class WhittleSession(bpy.types.PropertyGroup):
    """What is switched on, until Blender ends: ``window_manager.whittle``."""

    show_heat: Switch(
        name="Heatmap",
        description="Colour 3D viewports by the work that rays through their pixels make",
    )
    show_boxes: Switch(
        name="BVH Boxes",
        description="Draw the boxes of the BVH in 3D viewports",
    )
    show_probe: Switch(
        name="Pixel Probe",
        description="Draw the rays of the pixel that was probed last",
    )
    rays: CollectionProperty(
        type=WhittleRay,
        name="Rays",
        description="The rays of the probed pixel, each below the one that it descends from",
        options={"SKIP_SAVE"},
    )
    ray_index: IntProperty(
        name="Active Ray",
        description="The ray that is drawn thicker and told about below",
        default=0,
        min=0,
        options={"SKIP_SAVE"},
        update=late(__name__, "redraw"),
    )


def choice(settings: WhittleOverlay) -> Choice:
    """What the heatmap shows, in the words of metrics.py."""
    weights = (settings.node_weight, settings.triangle_weight)
    return Choice(
        metric=settings.metric,
        kinds=frozenset(settings.kinds) if METRICS[settings.metric].by_kind else frozenset(KINDS),
        weights=weights if settings.metric == "BOTH" else (1.0, 1.0),
    )


def core_settings(scene: bpy.types.Scene) -> dict[str, Any]:
    """The core's settings of all that is traced through viewports, but for the passes."""
    settings = properties.core_settings(scene, []) | {
        "samples": int(scene.whittle_overlay.samples),
        "transparent": False,
    }
    del settings["passes"]
    return settings


CLASSES = (WhittleOverlay, WhittleRay, WhittleSession)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.whittle_overlay = PointerProperty(type=WhittleOverlay, name="Whittle Overlay")
    bpy.types.WindowManager.whittle = PointerProperty(
        type=WhittleSession, name="Whittle", options={"SKIP_SAVE"}
    )


def unregister() -> None:
    del bpy.types.WindowManager.whittle
    del bpy.types.Scene.whittle_overlay
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
