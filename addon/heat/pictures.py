# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Heatmaps: from the counts of a render to images in Blender and files."""

import os

import bpy
import numpy as np
from numpy.typing import NDArray

from .. import passes
from ..results import Result
from . import colormaps, legend

NARROWEST = 480  # pixels; smaller pictures are enlarged, so that their legend can be read
PERCENTILE = 99.5


class HeatError(RuntimeError):
    """A heatmap cannot be made; the message says why."""


def draw(
    result: Result, source: str, colormap: str = "VIRIDIS", top: float | None = None
) -> NDArray[np.float32]:
    """One counter of a result as a picture (h, w, 3), sRGB in [0, 1], row 0 at the bottom.

    `source` is the core's name of the pass; `top` the number of the last colour in the legend's
    unit, by default what 99.5 % of the pixels stay below. HeatError if the render did not count.
    """
    row = next(row for row in passes.COUNTERS if row.source == source)
    if source not in result.counters:
        raise HeatError(_not_counted(row, result))
    counts = np.nan_to_num(result.counters[source]) * np.float32(row.scale)
    if top is None:
        top = float(np.percentile(counts, PERCENTILE))
    top = row.top or max(top, row.least)
    scale = -(-NARROWEST // counts.shape[1])
    picture = colormaps.apply(colormap, counts / top).repeat(scale, axis=0).repeat(scale, axis=1)
    band = legend.Legend(
        title=row.title,
        summary=f"mean {legend.number(counts.mean())}   highest {legend.number(counts.max())}",
        colormap=colormap,
        top=top,
    )
    return np.concatenate((legend.draw(band, picture.shape[1]), picture))


def _not_counted(row: passes.Pass, result: Result) -> str:
    if result.counters and row.mode:
        return (
            f"Only the traversal 'Packets with Statistics' counts {row.name.lower()}: choose it in "
            "the Performance panel and render again"
        )
    return "The last render did not count: switch on 'Count Rays' Work' and render again"


def show(name: str, pixels: NDArray[np.float32]) -> bpy.types.Image:
    """Makes or replaces an image of this name inside Blender."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.get(name)
    if image is not None and tuple(image.size) != (width, height):
        bpy.data.images.remove(image)
        image = None
    if image is None:
        image = bpy.data.images.new(name, width, height, alpha=False)
    opaque = np.ones((height, width, 4), dtype=np.float32)
    opaque[..., :3] = pixels
    image.pixels.foreach_set(opaque.reshape(-1))
    image.update()
    image.pack()
    return image


def write(path: str, pixels: NDArray[np.float32]) -> None:
    """Writes a PNG; it appears under its name only when it is whole."""
    image = show(os.path.basename(path), pixels)
    partial = f"{path}.partial.png"
    try:
        image.file_format = "PNG"
        image.save(filepath=partial)
        os.replace(partial, path)
    finally:
        bpy.data.images.remove(image)
