# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a 3D viewport looks at, as a camera of the core."""

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ..viewport import camera


@dataclass(frozen=True)
class View:
    """A viewport's matrices (row by row), its size in pixels and the depths that it shows."""

    view: tuple[float, ...]
    window: tuple[float, ...]
    size: tuple[int, int]
    clip: tuple[float, float]  # of perspective views; others have theirs in the window matrix

    def camera(self, divisor: int = 1) -> dict[str, Any]:
        """The camera argument of Scene.render, at the size divided by the divisor."""
        matrices = (np.reshape(matrix, (4, 4)) for matrix in (self.view, self.window))
        eye = camera.eye_of(*matrices, self.clip)
        width, height = (max(1, -(-pixels // divisor)) for pixels in self.size)
        return {
            "to_world": eye.to_world,
            "projection": eye.projection,
            "width": width,
            "height": height,
            "clip_start": eye.clip[0],
            "clip_end": eye.clip[1],
        }


def of_region(
    region: bpy.types.Region, space: bpy.types.SpaceView3D, data: bpy.types.RegionView3D
) -> View:
    """What one region of a 3D viewport shows now."""
    clip = camera.clip(space, data)
    return View(_flat(data.view_matrix), _flat(data.window_matrix), _size(region), clip)


def _flat(matrix: Any) -> tuple[float, ...]:
    return tuple(value for row in matrix for value in row)


def _size(region: bpy.types.Region) -> tuple[int, int]:
    return (max(1, region.width), max(1, region.height))
