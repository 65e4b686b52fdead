# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a traced image over the region that it was traced for."""

from functools import cache

import gpu
import numpy as np

from .. import quads
from .tracer import Image

# Blender 4 smooths every texture, and places quads a hundredth of a pixel beside where they belong:
# an image with a pixel for each of the region's is fetched, not sampled.
FRAGMENT = """
void main()
{
  ivec2 pixels = textureSize(image, 0);
  ivec2 pixel = min(ivec2(uv * vec2(pixels)), pixels - 1);
  color = smoothly ? texture(image, uv) : texelFetch(image, pixel, 0);
}
"""


class Picture:
    """A texture that holds the last image drawn."""

    def __init__(self) -> None:
        self._image: Image | None = None
        self._texture: gpu.types.GPUTexture | None = None

    def draw(self, image: Image) -> None:
        """Draws an image over its region, blended over what is there."""
        if image is not self._image:
            self._texture, self._image = _texture(image), image
        (x0, y0, x1, y1), (width, height) = image.part, image.size
        places = [(x / width, y / height) for x, y in ((x0, y0), (x1, y0), (x0, y1), (x1, y1))]
        shader = _shader()
        shader.bind()
        shader.uniform_bool("smoothly", image.level.reduction > 1)
        shader.uniform_sampler("image", self._texture)
        quads.draw(shader, "ALPHA_PREMULT", places)


@cache
def _shader() -> gpu.types.GPUShader:
    return quads.make_shader("whittle_picture", {"smoothly": "BOOL"}, ("image",), FRAGMENT)


def _texture(image: Image) -> gpu.types.GPUTexture:
    pixels = np.ascontiguousarray(image.pixels)
    height, width = pixels.shape[:2]
    buffer = gpu.types.Buffer("FLOAT", pixels.size, pixels.reshape(-1))
    return gpu.types.GPUTexture((width, height), format="RGBA16F", data=buffer)


def forget() -> None:
    """Lets go of the shader, before the add-on goes."""
    _shader.cache_clear()
