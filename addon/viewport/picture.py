# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a traced image over the region that it was traced for."""

import gpu
import numpy as np
from gpu_extras.presets import draw_texture_2d

from .tracer import Image


class Picture:
    """A texture that holds the last image drawn."""

    def __init__(self) -> None:
        self._image: Image | None = None
        self._texture: gpu.types.GPUTexture | None = None

    def draw(self, image: Image, width: int, height: int) -> None:
        """Draws an image over a region of this size in pixels, blended over what is there."""
        if image is not self._image:
            self._texture, self._image = _texture(image), image
        x0, y0, x1, y1 = image.part
        # A pixel of the image in pixels of the region; the last column may reach beyond its edge.
        across, up = width / image.size[0], height / image.size[1]
        gpu.state.blend_set("ALPHA_PREMULT")
        draw_texture_2d(self._texture, (x0 * across, y0 * up), (x1 - x0) * across, (y1 - y0) * up)
        gpu.state.blend_set("NONE")


def _texture(image: Image) -> gpu.types.GPUTexture:
    pixels = np.ascontiguousarray(image.pixels)
    height, width = pixels.shape[:2]
    buffer = gpu.types.Buffer("FLOAT", pixels.size, pixels.reshape(-1))
    texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=buffer)
    # Blender 5 draws textures smooth unless told otherwise, which blurs an image of full size.
    if hasattr(texture, "filter_mode"):
        texture.filter_mode(image.level.reduction > 1)
    return texture
