# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a 3D viewport looks at, as a camera of the core."""

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class View:
    """A viewport's matrices (row by row), its size in pixels and the depths that it shows."""

    view: tuple[float, ...]
    window: tuple[float, ...]
    size: tuple[int, int]
    clip: tuple[float, float]  # of perspective views; others have theirs in the window matrix

    def camera(self, divisor: int = 1) -> dict[str, Any]:
        """The camera argument of Scene.render, at the size divided by the divisor."""
        to_world = np.linalg.inv(np.array(self.view).reshape(4, 4))
        projection = np.array(self.window).reshape(4, 4)
        near, far = self.clip
        if not projection[3, :3].any():
            near, far = self._flatten(to_world, projection)
        width, height = (max(1, -(-pixels // divisor)) for pixels in self.size)
        return {
            "to_world": to_world,
            "projection": projection,
            "width": width,
            "height": height,
            "clip_start": near,
            "clip_end": far,
        }

    @staticmethod
    def _flatten(to_world: NDArray[np.float64], projection: NDArray[np.float64]) -> tuple:
        """Moves an orthographic view to its near plane, which lies behind it in a viewport."""
        scale, offset = projection[2, 2:]
        near, far = (offset + 1.0) / scale, (offset - 1.0) / scale
        to_world[:3, 3] -= near * to_world[:3, 2]
        return 0.0, far - near


def of_region(
    region: bpy.types.Region, space: bpy.types.SpaceView3D, data: bpy.types.RegionView3D
) -> View:
    """What one region of a 3D viewport shows now."""
    clip = (space.clip_start, space.clip_end)
    if data.view_perspective == "CAMERA" and space.camera is not None:
        lens = space.camera.data
        if space.camera.type == "CAMERA":
            clip = (lens.clip_start, lens.clip_end)
    return View(_flat(data.view_matrix), _flat(data.window_matrix), _size(region), clip)


def _flat(matrix: Any) -> tuple[float, ...]:
    return tuple(value for row in matrix for value in row)


def _size(region: bpy.types.Region) -> tuple[int, int]:
    return (max(1, region.width), max(1, region.height))
