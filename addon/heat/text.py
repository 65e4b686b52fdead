# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Text drawn into an array by Blender's own fonts, without a window or a graphics card."""

import os
import tempfile

import blf
import bpy
import imbuf
import numpy as np
from numpy.typing import NDArray

from . import outlines
from .labels import Label

FONT = 0  # Blender's own
FINER = 3  # drawn this much larger and averaged: Blender's own edges are hard in a buffer


def cover(labels: list[Label], size: int, width: int, height: int) -> NDArray[np.float32]:
    """How much of each pixel the text covers, in [0, 1], (height, width), row 0 at the bottom."""
    if hasattr(blf, "bind_imbuf"):
        return _drawn(labels, size, width, height)
    return outlines.cover(labels, size, width, height)


def _drawn(labels: list[Label], size: int, width: int, height: int) -> NDArray[np.float32]:
    """By Blender's own drawing of text, which 4.5 and newer do into images."""
    buffer = imbuf.new((FINER * width, FINER * height))
    blf.size(FONT, FINER * size)
    blf.color(FONT, 1.0, 1.0, 1.0, 1.0)
    with blf.bind_imbuf(FONT, buffer):
        for label in labels:
            length = blf.dimensions(FONT, label.text)[0]
            shift = {"LEFT": 0.0, "CENTER": 0.5, "RIGHT": 1.0}[label.align]
            blf.position(FONT, FINER * label.x - shift * length, FINER * label.y, 0.0)
            blf.draw_buffer(FONT, label.text)
    pixels = _red(buffer, FINER * width, FINER * height)
    return pixels.reshape(height, FINER, width, FINER).mean(axis=(1, 3))


def _red(buffer: imbuf.types.ImBuf, width: int, height: int) -> NDArray[np.float32]:
    """The red channel. Blender 4.5 shows no pixels of such a buffer but in a file."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "text.png")
        imbuf.write(buffer, filepath=path)
        image = bpy.data.images.load(path)
        image.colorspace_settings.name = "Non-Color"
        image.alpha_mode = "CHANNEL_PACKED"
        try:
            values = np.empty(width * height * 4, dtype=np.float32)
            image.pixels.foreach_get(values)
        finally:
            bpy.data.images.remove(image)
    return values.reshape(height, width, 4)[..., 0]
