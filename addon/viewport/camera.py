# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a 3D viewport looks at, in the core's words."""

from dataclasses import dataclass
from math import ceil, floor

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from numpy.typing import ArrayLike, NDArray

from .tracer import Region

Frame = tuple[float, float, float, float]  # x0, y0, x1, y1


@dataclass(frozen=True)
class Eye:
    """A viewport's camera."""

    to_world: NDArray[np.float64]  # (4, 4)
    projection: NDArray[np.float64]  # (4, 4)
    clip: tuple[float, float]


def eye(space: bpy.types.SpaceView3D, view: bpy.types.RegionView3D) -> Eye:
    """The camera of a region, with its zoom and offset where it looks through a camera object."""
    return eye_of(view.view_matrix, view.window_matrix, clip(space, view))


def clip(space: bpy.types.SpaceView3D, view: bpy.types.RegionView3D) -> tuple[float, float]:
    """The depths that a region shows in perspective."""
    camera = space.camera if view.view_perspective == "CAMERA" else None
    lens = space if camera is None or camera.type != "CAMERA" else camera.data
    return (lens.clip_start, lens.clip_end)


def eye_of(view: ArrayLike, window: ArrayLike, clip: tuple[float, float]) -> Eye:
    """The camera of a region's view and window matrix (4, 4); `clip` as of perspective."""
    to_world = np.linalg.inv(np.array(view, dtype=np.float64))
    projection = np.array(window, dtype=np.float64)
    if projection[3, 3] == 0.0:
        return Eye(to_world, projection, clip)
    # An orthographic view may begin behind its own place: it steps back to where it begins.
    scale, shift = projection[2, 2:]
    start, end = sorted(((1.0 + shift) / scale, (shift - 1.0) / scale))
    if start < 0.0:
        to_world[:3, 3] -= start * to_world[:3, 2]
        start, end = 0.0, end - start
    return Eye(to_world, projection, (start, end))


def part(
    scene: bpy.types.Scene,
    space: bpy.types.SpaceView3D,
    region: bpy.types.Region,
    view: bpy.types.RegionView3D,
) -> Region:
    """The pixels (x0, y0, x1, y1) of a region that are drawn: all, or its render border's."""
    everything = (0, 0, region.width, region.height)
    if view.view_perspective != "CAMERA":
        edges = _edges(space, "render_border_") if space.use_render_border else None
        return _inside(everything, edges, everything) if edges else everything
    camera = space.camera
    if not scene.render.use_border or camera is None or camera.type != "CAMERA":
        return everything
    frame = camera_frame(scene, camera, region, view)
    return _inside(frame, _edges(scene.render, "border_"), everything) if frame else everything


def _edges(owner: bpy.types.SpaceView3D | bpy.types.RenderSettings, prefix: str) -> Frame:
    return tuple(getattr(owner, prefix + name) for name in ("min_x", "min_y", "max_x", "max_y"))


def _inside(frame: Frame, edges: Frame, everything: Region) -> Region:
    """The pixels between edges that are fractions of a frame, as far as they can be seen."""
    found = []
    for axis, outwards in ((0, floor), (1, floor), (0, ceil), (1, ceil)):
        extent = frame[axis + 2] - frame[axis]
        edge = outwards(frame[axis] + edges[len(found)] * extent)
        found.append(min(max(0, edge), everything[axis + 2]))
    return tuple(found)


def camera_frame(
    scene: bpy.types.Scene,
    camera: bpy.types.Object,
    region: bpy.types.Region,
    view: bpy.types.RegionView3D,
) -> Frame | None:
    """Where a region that looks through a camera shows its picture, in pixels of the region."""
    place = camera.matrix_world.normalized()
    corners = camera.data.view_frame(scene=scene)
    points = [location_3d_to_region_2d(region, view, place @ corner) for corner in corners]
    if None in points:
        return None
    xs, ys = [point.x for point in points], [point.y for point in points]
    return (min(xs), min(ys), max(xs), max(ys))
