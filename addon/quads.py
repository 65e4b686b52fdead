# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quads over a viewport, coloured by a shader: what the heatmap and traced images share."""

from collections.abc import Mapping, Sequence

import gpu
from gpu_extras.batch import batch_for_shader

CORNERS = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0))

VERTEX = "void main() { uv = corner; gl_Position = vec4(2.0 * place - 1.0, 0.0, 1.0); }"


def make_shader(
    name: str, constants: Mapping[str, str], textures: Sequence[str], fragment: str
) -> gpu.types.GPUShader:
    """Compiles a shader whose fragment code sets ``color`` by ``uv``, (0, 0) to (1, 1) on the quad.

    The code sees the constants, given with their types in capitals, and the textures by name.
    """
    info = gpu.types.GPUShaderCreateInfo()
    for constant, kind in constants.items():
        info.push_constant(kind, constant)
    for slot, texture in enumerate(textures):
        info.sampler(slot, "FLOAT_2D", texture)
    info.vertex_in(0, "VEC2", "place")
    info.vertex_in(1, "VEC2", "corner")
    between = gpu.types.GPUStageInterfaceInfo(name)
    between.smooth("VEC2", "uv")
    info.vertex_out(between)
    info.fragment_out(0, "VEC4", "color")
    info.vertex_source(VERTEX)
    info.fragment_source(fragment)
    return gpu.shader.create_from_info(info)


def draw(
    shader: gpu.types.GPUShader, blend: str, places: Sequence[tuple[float, float]] = CORNERS
) -> None:
    """Draws a quad with a shader that is bound and has its constants.

    ``places`` (4, 2) are its corners in the region, which reaches from (0, 0) to (1, 1), in the
    order of ``CORNERS``.
    """
    batch = batch_for_shader(shader, "TRI_STRIP", {"place": places, "corner": CORNERS})
    gpu.state.blend_set(blend)
    batch.draw(shader)
    gpu.state.blend_set("NONE")
