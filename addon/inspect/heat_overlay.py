# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The heatmap as a viewport shows it: asked for, put on the graphics card, drawn, explained."""

from dataclasses import dataclass, field
from typing import Any

import bpy

from . import draw, legend, properties, source, view
from .heat import Heat, Picture, Want


@dataclass
class HeatOverlay:
    """The heatmap of one region of a 3D viewport."""

    heat: Heat = field(default_factory=Heat)
    _texture: Any = None
    _shown: Picture | None = None  # what the texture holds

    def want(self, context: bpy.types.Context) -> None:
        """Tells the heatmap what is looked at now."""
        if source.shared.scene is None:
            return
        scene = context.scene
        want = Want(
            view=view.of_region(context.region, context.space_data, context.region_data),
            choice=properties.choice(scene.whittle_overlay),
            settings=tuple(sorted(properties.core_settings(scene).items())),
            generation=source.shared.generation,
        )
        self.heat.want(want)

    def paint(self, settings: properties.WhittleOverlay) -> None:
        """Draws what there is."""
        picture = self.heat.picture
        if picture is None:
            return
        if self._shown is not picture:
            self._texture, self._shown = draw.texture(picture.values), picture
        draw.heat(self._texture, settings.colormap, span(settings, picture), settings.opacity)

    def legend(self, settings: properties.WhittleOverlay) -> legend.Legend | None:
        """What the colours mean, or why there are none; None: nothing to say."""
        picture, scene = self.heat.picture, source.shared
        problem = scene.error or self.heat.error
        if problem:
            return legend.Legend("No heatmap", (), warning=problem)
        if picture is None:
            return legend.Legend(_waiting(scene), ())
        return _explain(settings, picture) if settings.show_legend else None


def span(settings: properties.WhittleOverlay, picture: Picture) -> tuple[float, float]:
    """The values of the first and the last colour."""
    if settings.range == "FIXED":
        return (settings.low, settings.high)
    return (0.0, picture.top)


def staleness(scene: source.Shared) -> str:
    """What to say of a picture whose scene has changed; "": nothing."""
    if scene.building:
        return f"The scene changed: building the BVH, {scene.progress:.0%}"
    return "The scene has changed since: press Update" if scene.stale else ""


def _waiting(scene: source.Shared) -> str:
    if scene.scene is not None:
        return "Tracing the first picture"
    return f"Building the BVH, {scene.progress:.0%}" if scene.building else "Reading the scene"


def _explain(settings: properties.WhittleOverlay, picture: Picture) -> legend.Legend:
    row, low_high = picture.want.choice.row, span(settings, picture)
    samples = dict(picture.want.settings)["samples"]
    coarse = f"1/{picture.divisor} resolution" if picture.divisor > 1 else "full resolution"
    many = f"{samples} samples a pixel   " if samples > 1 else ""
    return legend.Legend(
        title=f"{row.unit[0].upper()}{row.unit[1:]}, {picture.want.choice.kinds_text()}",
        lines=(
            f"mean {legend.number(picture.mean)}   95 % below {legend.number(picture.p95)}"
            f"   highest {legend.number(picture.highest)}",
            many + coarse + (", trees by object" if source.shared.by_instance else ""),
        ),
        warning=staleness(source.shared),
        colormap=settings.colormap,
        span=low_high if low_high[1] > low_high[0] else None,
        over=picture.highest > low_high[1],
        bars=picture.histogram(*low_high) if settings.show_histogram else None,
    )
