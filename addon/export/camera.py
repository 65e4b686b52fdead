# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's camera in the core's words."""

from typing import Any

import bpy
import numpy as np

from ..notes import Notes

Region = tuple[int, int, int, int]


def export(
    depsgraph: bpy.types.Depsgraph,
    camera: bpy.types.Object,
    size: tuple[int, int],
    region: Region,
    notes: Notes,
) -> dict[str, Any]:
    """The camera argument of Scene.render, for an image of the given width and height."""
    camera = camera.evaluated_get(depsgraph)
    render = depsgraph.scene_eval.render
    projection = camera.calc_matrix_camera(
        depsgraph,
        x=size[0],
        y=size[1],
        scale_x=render.pixel_aspect_x,
        scale_y=render.pixel_aspect_y,
    )
    _note_what_is_missing(camera, render, notes)
    return {
        "to_world": np.array(camera.matrix_world.normalized(), dtype=np.float64),
        "projection": np.array(projection, dtype=np.float64),
        "width": size[0],
        "height": size[1],
        "clip_start": camera.data.clip_start,
        "clip_end": camera.data.clip_end,
        "region": region,
    }


def region(render: bpy.types.RenderSettings, size: tuple[int, int]) -> Region:
    """The pixels (x0, y0, x1, y1) that are rendered, rounded as Blender rounds its border."""
    if not render.use_border:
        return (0, 0, *size)
    low = (render.border_min_x, render.border_min_y)
    high = (render.border_max_x, render.border_max_y)
    # Blender multiplies in single precision and cuts the fraction off.
    return tuple(
        int(np.float32(edge) * np.float32(pixels))
        for corner in (low, high)
        for edge, pixels in zip(corner, size, strict=True)
    )


def _note_what_is_missing(
    camera: bpy.types.Object, render: bpy.types.RenderSettings, notes: Notes
) -> None:
    data = camera.data
    if data.type not in ("PERSP", "ORTHO"):
        notes.add(f"Camera '{camera.name}': {data.type.lower()} is drawn as perspective")
    if data.dof.use_dof:
        notes.add(f"Camera '{camera.name}': depth of field is left out, everything is sharp")
    if render.use_motion_blur:
        notes.add("Motion blur is left out")
