# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings that a scene keeps, and what the core is told of them."""

from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty

from .callbacks import late, late_get
from .heat import colormaps

# Numbers have soft limits only: a script that sets one beyond them gets an error from the render,
# not a value that was quietly changed.


BUILD_PRESETS = (
    ("PREVIEW", "Preview", "8 bins: the fewest seconds to the first picture"),
    ("STANDARD", "Standard", "16 bins"),
    ("FINAL", "Final", "64 bins: pays where tens of millions of rays are traced"),
    ("CUSTOM", "Custom", "Another number of bins"),
)
PRESET_BINS = (8, 16, 64)  # of all but the last


def _build_preset(settings: "WhittleSettings") -> int:
    """Which preset has the scene's number of bins: that is all there is to it."""
    return PRESET_BINS.index(settings.bins) if settings.bins in PRESET_BINS else len(PRESET_BINS)


def _set_build_preset(settings: "WhittleSettings", index: int) -> None:
    if index < len(PRESET_BINS):
        settings.bins = PRESET_BINS[index]


def _changed(settings: "WhittleSettings", context: bpy.types.Context) -> None:
    """Tells the rendered viewports; Blender itself does when a person edits, not when a script."""
    settings.id_data.update_tag()


class WhittleSettings(bpy.types.PropertyGroup):
    """Settings of the Whittle engine, kept in each scene as ``scene.whittle``."""

    samples: IntProperty(
        name="Samples",
        description="Primary rays per pixel, for anti-aliasing: a square number (1, 4, 9, 16, ...)",
        default=4,
        soft_min=1,
        soft_max=4096,
    )
    viewport_samples: IntProperty(
        name="Viewport Samples",
        description="Rays per pixel that a 3D viewport ends with: a square number",
        default=4,
        soft_min=1,
        soft_max=1024,
        update=late(__name__, "_changed"),
    )
    pattern: EnumProperty(
        name="Pattern",
        description="Where in the pixel the samples lie",
        items=(
            ("REGULAR", "Regular", "The centres of a grid: clean gradients, some aliasing"),
            ("STRATIFIED", "Stratified", "A random point in each cell of a grid: a little noise"),
        ),
        default="REGULAR",
        update=late(__name__, "_changed"),
    )
    seed: IntProperty(
        name="Seed",
        description="Of the stratified pattern; the same seed gives the same picture",
        default=0,
        soft_min=0,
        update=late(__name__, "_changed"),
    )
    max_depth: IntProperty(
        name="Depth",
        description="Mirror and glass bounces after the first hit; 0 leaves both out",
        default=8,
        soft_min=0,
        soft_max=64,
        update=late(__name__, "_changed"),
    )
    cutoff: FloatProperty(
        name="Cut-off",
        description="Rays that would add less than this share to their pixel are left out; 0: none",
        default=1 / 1024,
        soft_min=0.0,
        soft_max=0.1,
        precision=5,
        step=0.01,
        update=late(__name__, "_changed"),
    )
    use_ambient: BoolProperty(
        name="Ambient Light",
        description=(
            "The world's colour lights every diffuse surface, without shadows, "
            "unless the world is hidden from diffuse rays"
        ),
        default=True,
        update=late(__name__, "_changed"),
    )
    mode: EnumProperty(
        name="Traversal",
        description="How rays walk the BVH. The picture is the same to the bit",
        items=(
            ("FAST", "Fast", "The quickest that the processor can run"),
            ("LECTURE", "Packets with Statistics", "Binary packets that count their coherence"),
            ("SINGLE", "Single Rays", "One ray at a time"),
        ),
        default="FAST",
    )
    build_preset: EnumProperty(
        name="BVH Build",
        description="How much time the build takes to save rays some. The picture is the same",
        items=BUILD_PRESETS,
        get=late_get(__name__, "_build_preset"),
        set=late(__name__, "_set_build_preset"),
    )
    bins: IntProperty(
        name="Bins",
        description="Candidate planes per axis when the BVH is built",
        default=16,
        soft_min=2,
        soft_max=64,
    )
    use_counters: BoolProperty(
        name="Count Rays' Work",
        description=(
            "Count the BVH nodes visited and the triangles tested for each pixel: adds the passes "
            "that heatmaps are made of, and takes longer"
        ),
        default=False,
    )
    use_own_trees: BoolProperty(
        name="Judge Objects",
        description=(
            "With counting: build a BVH of its own for each object and measure how much objects "
            "overlap, to tell which of them are hard to trace; takes about as long as the build"
        ),
        default=False,
    )
    heat_map: EnumProperty(
        name="Colours",
        description="The colours of a heatmap, from low to high",
        items=colormaps.ITEMS,
        default="VIRIDIS",
    )
    heat_range: EnumProperty(
        name="Range",
        description="The counts that the colours span",
        items=(
            ("AUTO", "Automatic", "From 0 to what 99.5 % of the pixels stay below"),
            ("FIXED", "Fixed", "From 0 to the number given, so that pictures can be compared"),
        ),
        default="AUTO",
    )
    heat_max: FloatProperty(
        name="Highest",
        description="The count shown in the last colour, with a fixed range",
        default=1000.0,
        soft_min=1.0,
    )


def core_settings(scene: bpy.types.Scene, sources: list[str]) -> dict[str, Any]:
    """Settings of a render in the core's words; the core judges their range."""
    whittle = scene.whittle
    return {
        "passes": sources,
        "samples": whittle.samples,
        "pattern": whittle.pattern.lower(),
        "seed": whittle.seed,
        "max_depth": whittle.max_depth,
        "cutoff": whittle.cutoff,
        "transparent": scene.render.film_transparent,
        "mode": whittle.mode.lower(),
        "threads": threads(scene),
    }


def lean(scene: bpy.types.Scene) -> bool:
    """Whether a render with the scene's settings can do without the binary tree."""
    return not scene.whittle.use_counters and scene.whittle.mode != "LECTURE"


def kept(scene: bpy.types.Scene) -> dict[str, Any]:
    """The settings that change what a render costs, by their names in Blender."""
    rows = scene.whittle.bl_rna.properties
    names = ("samples", "pattern", "seed", "max_depth", "cutoff", "mode", "bins")
    return {rows[name].name: getattr(scene.whittle, name) for name in names}


def threads(scene: bpy.types.Scene) -> int:
    """Blender's own thread setting, ``-t`` included; 0: as many as the machine allows."""
    return scene.render.threads if scene.render.threads_mode == "FIXED" else 0


def register() -> None:
    bpy.utils.register_class(WhittleSettings)
    bpy.types.Scene.whittle = PointerProperty(type=WhittleSettings, name="Whittle")


def unregister() -> None:
    del bpy.types.Scene.whittle
    bpy.utils.unregister_class(WhittleSettings)
