# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Text for Blender 4.2 and 4.3: the outlines of Blender's font, filled by the core's own rays."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from .. import native
from .labels import Label

SAMPLES = 16  # of a pixel
DIGIT = 0.72  # height of a digit by the size of the font, as blf draws it


def cover(labels: Sequence[Label], size: int, width: int, height: int) -> NDArray[np.float32]:
    """How much of each pixel the text covers, in [0, 1], (height, width), row 0 at the bottom."""
    scene = native.load().Scene()
    with _writer() as outline:
        scale = DIGIT * size / np.ptp(outline("0", "LEFT")["positions"][:, 1])
        for label in labels:
            shape = outline(label.text, label.align)
            if len(shape["triangles"]):
                scene.add_instance(scene.add_mesh(**shape), _place(label, scale))
    scene.set_materials([{"emission": (1.0, 1.0, 1.0)}])
    scene.build(threads=1)
    return scene.render(_camera(width, height), {"samples": SAMPLES})["combined"][..., 0]


@contextmanager
def _writer() -> Iterator[Any]:
    """A function from a text and its alignment to the arguments of Scene.add_mesh."""
    curve = bpy.data.curves.new("Whittle Text", "FONT")
    ob = bpy.data.objects.new("Whittle Text", curve)
    try:
        yield lambda body, align: _outline(ob, body, align)
    finally:
        bpy.data.objects.remove(ob)
        bpy.data.curves.remove(curve)


def _outline(ob: bpy.types.Object, body: str, align: str) -> dict[str, Any]:
    ob.data.body, ob.data.align_x = body, align
    mesh = ob.to_mesh()
    mesh.calc_loop_triangles()
    positions = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", positions)
    triangles = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    ob.to_mesh_clear()
    return {"positions": positions.reshape(-1, 3), "triangles": triangles.reshape(-1, 3)}


def _place(label: Label, scale: float) -> NDArray[np.float64]:
    matrix = np.diag([scale, scale, 1.0, 1.0])
    matrix[:2, 3] = label.x, label.y
    return matrix


def _camera(width: int, height: int) -> dict[str, Any]:
    """Looks down on the pixels of an image, one unit wide each."""
    projection = np.diag([2.0 / width, 2.0 / height, -1.0, 1.0])
    projection[:3, 3] = -1.0, -1.0, -1.0
    to_world = np.eye(4)
    to_world[2, 3] = 1.0
    return {
        "to_world": to_world,
        "projection": projection,
        "width": width,
        "height": height,
        "clip_start": 0.0,
        "clip_end": 2.0,
    }
