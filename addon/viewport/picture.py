# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a traced image over the region that it was traced for."""

from functools import cache

import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from .tracer import Image

VERTEX = "void main() { uv = corner; gl_Position = vec4(2.0 * place - 1.0, 0.0, 1.0); }"

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
        corners = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0))
        shader = _shader()
        batch = batch_for_shader(shader, "TRI_STRIP", {"place": places, "corner": corners})
        shader.bind()
        shader.uniform_bool("smoothly", image.level.reduction > 1)
        shader.uniform_sampler("image", self._texture)
        gpu.state.blend_set("ALPHA_PREMULT")
        batch.draw(shader)
        gpu.state.blend_set("NONE")


@cache
def _shader() -> gpu.types.GPUShader:
    info = gpu.types.GPUShaderCreateInfo()
    info.push_constant("BOOL", "smoothly")
    info.sampler(0, "FLOAT_2D", "image")
    info.vertex_in(0, "VEC2", "place")
    info.vertex_in(1, "VEC2", "corner")
    between = gpu.types.GPUStageInterfaceInfo("whittle_picture")
    between.smooth("VEC2", "uv")
    info.vertex_out(between)
    info.fragment_out(0, "VEC4", "color")
    info.vertex_source(VERTEX)
    info.fragment_source(FRAGMENT)
    return gpu.shader.create_from_info(info)


def _texture(image: Image) -> gpu.types.GPUTexture:
    pixels = np.ascontiguousarray(image.pixels)
    height, width = pixels.shape[:2]
    buffer = gpu.types.Buffer("FLOAT", pixels.size, pixels.reshape(-1))
    return gpu.types.GPUTexture((width, height), format="RGBA16F", data=buffer)


def forget() -> None:
    """Lets go of the shader, before the add-on goes."""
    _shader.cache_clear()
