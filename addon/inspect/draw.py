# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Drawing with Blender's gpu module: heatmaps, rectangles, lines and text in a viewport."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

import blf
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader
from numpy.typing import NDArray

from .. import quads
from ..heat import colormaps

Color = tuple[float, float, float, float]

# A viewport's overlays are kept encoded: what a shader writes is taken for linear light.
FRAGMENT = """
vec3 linear(vec3 c)
{
  return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(vec3(0.04045), c));
}

void main()
{
  ivec2 pixels = textureSize(counts, 0);
  float value = texelFetch(counts, min(ivec2(uv * vec2(pixels)), pixels - 1), 0).r;
  int last = textureSize(stops, 0).x - 1;
  float position = clamp((value - low) / (high - low), 0.0, 1.0) * float(last);
  int below = min(int(position), last - 1);
  vec3 first = texelFetch(stops, ivec2(below, 0), 0).rgb;
  vec3 second = texelFetch(stops, ivec2(below + 1, 0), 0).rgb;
  color = vec4(linear(mix(first, second, position - float(below))), opacity);
}
"""


@cache
def _heat_shader() -> gpu.types.GPUShader:
    constants = dict.fromkeys(("low", "high", "opacity"), "FLOAT")
    return quads.make_shader("whittle_heat", constants, ("counts", "stops"), FRAGMENT)


@cache
def _stops(name: str) -> gpu.types.GPUTexture:
    colors = colormaps.stops(name)
    pixels = np.ones((1, len(colors), 4), dtype=np.float32)
    pixels[0, :, :3] = colors
    buffer = gpu.types.Buffer("FLOAT", pixels.shape, pixels)
    return gpu.types.GPUTexture((len(colors), 1), format="RGBA32F", data=buffer)


def texture(values: NDArray[np.float32]) -> gpu.types.GPUTexture:
    """Values (h, w) on the graphics card; the array may be let go afterwards."""
    height, width = values.shape
    buffer = gpu.types.Buffer("FLOAT", (height, width), values)
    return gpu.types.GPUTexture((width, height), format="R32F", data=buffer)


def heat(
    counts: gpu.types.GPUTexture,
    colormap: str,
    span: tuple[float, float],
    opacity: float,
) -> None:
    """Fills the region with values, coloured by where in the span they lie."""
    shader = _heat_shader()
    shader.bind()
    shader.uniform_float("low", span[0])
    shader.uniform_float("high", max(span[1], span[0] + 1e-30))
    shader.uniform_float("opacity", opacity)
    shader.uniform_sampler("counts", counts)
    shader.uniform_sampler("stops", _stops(colormap))
    quads.draw(shader, "ALPHA")


def rectangles(boxes: NDArray[np.floating], color: Color) -> None:
    """Filled rectangles (n, 4): x0, y0, x1, y1 in pixels."""
    x0, y0, x1, y1 = np.asarray(boxes, dtype=np.float32).T
    corners = np.stack((x0, y0, x1, y0, x1, y1, x0, y0, x1, y1, x0, y1), axis=-1)
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    batch = batch_for_shader(shader, "TRIS", {"pos": corners.reshape(-1, 2)})
    shader.bind()
    shader.uniform_float("color", color)
    gpu.state.blend_set("ALPHA")
    batch.draw(shader)
    gpu.state.blend_set("NONE")


def ramp(colormap: str, box: tuple[float, float, float, float]) -> None:
    """The colours of a map from left to right."""
    x0, y0, x1, y1 = box
    colors = colormaps.stops(colormap)
    x = np.linspace(x0, x1, len(colors), dtype=np.float32)
    points = np.empty((len(colors), 2, 2), dtype=np.float32)
    points[:, :, 0] = x[:, np.newaxis]
    points[:, :, 1] = (y0, y1)
    opaque = np.ones((len(colors), 2, 4), dtype=np.float32)
    opaque[:, :, :3] = colors[:, np.newaxis]
    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    content = {"pos": points.reshape(-1, 2), "color": opaque.reshape(-1, 4)}
    batch = batch_for_shader(shader, "TRI_STRIP", content)
    shader.bind()
    batch.draw(shader)


def line_batch(
    points: NDArray[np.float32],
    colors: NDArray[np.float32],
    pairs: NDArray[np.uint32] | None = None,
    wide: bool = False,
) -> gpu.types.GPUBatch:
    """Lines between points (n, 3) of the world with colours (n, 4): two by two, or by pairs."""
    content = {"pos": points, "color": colors}
    return batch_for_shader(_line_shader(wide), "LINES", content, indices=pairs)


def lines(batch: gpu.types.GPUBatch, width: float | None = None, in_front: bool = True) -> None:
    """Draws lines of the world, in front of all or hidden by objects; `width` in pixels is for
    batches of wide lines, all others are as thin as can be."""
    shader = _line_shader(width is not None)
    shader.bind()
    if width is not None:
        shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
        shader.uniform_float("lineWidth", width)
    with _blended(in_front):
        batch.draw(shader)


def triangles(vertices: NDArray[np.float32], color: Color) -> None:
    """Fills triangles (n, 3, 3) of the world, in front of all."""
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    batch = batch_for_shader(shader, "TRIS", {"pos": vertices.reshape(-1, 3)})
    shader.bind()
    shader.uniform_float("color", color)
    with _blended(True):
        batch.draw(shader)


@contextmanager
def _blended(in_front: bool) -> Iterator[None]:
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("NONE" if in_front else "LESS_EQUAL")
    try:
        yield
    finally:
        gpu.state.blend_set("NONE")
        gpu.state.depth_test_set("NONE")


@cache
def _line_shader(wide: bool) -> gpu.types.GPUShader:
    return gpu.shader.from_builtin("POLYLINE_FLAT_COLOR" if wide else "FLAT_COLOR")


def text(
    line: str, x: float, y: float, size: float, color: Color, align: str = "LEFT"
) -> tuple[float, float]:
    """A line of text whose baseline's left end, middle or right end is at (x, y); its extent."""
    blf.size(0, size)
    width, height = blf.dimensions(0, line)
    shift = {"LEFT": 0.0, "CENTER": 0.5, "RIGHT": 1.0}[align]
    blf.color(0, *color)
    blf.position(0, round(x - shift * width), round(y), 0)
    blf.draw(0, line)
    return width, height


def forget() -> None:
    """Lets go of shaders and textures, before the add-on goes."""
    _heat_shader.cache_clear()
    _stops.cache_clear()
    _line_shader.cache_clear()
