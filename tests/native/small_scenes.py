# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes and cameras that the tests of the Python module share."""

from typing import Any

import numpy as np
import whittle_core
from numpy.typing import NDArray

TRIANGLE: NDArray[np.float32] = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
ONE: NDArray[np.uint32] = np.uint32([[0, 1, 2]])

# A ray that meets the triangle at t = 1, u = v = 1/4.
DOWN = np.float64([[0.25, 0.25, 1.0]]), np.float64([[0.0, 0.0, -1.0]])


def changed(row: int, column: int, value: float) -> NDArray[np.float64]:
    """The identity with one other number."""
    matrix = np.eye(4)
    matrix[row, column] = value
    return matrix


def built(
    positions: Any, triangles: Any, transforms: Any = None, **build: Any
) -> whittle_core.Scene:
    """A built scene of one mesh, once for each transform (default: once where it is)."""
    scene = whittle_core.Scene()
    mesh = scene.add_mesh(positions, triangles)
    for transform in np.eye(4)[None] if transforms is None else transforms:
        scene.add_instance(mesh, transform)
    scene.build(**build)
    return scene


def rays(count: int, seed: int = 2) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Rays from inside the unit cube into all directions."""
    rng = np.random.default_rng(seed)
    return rng.random((count, 3)), rng.standard_normal((count, 3))


def camera(width: int = 32, height: int = 24, **more: Any) -> dict[str, Any]:
    """Looks down on the unit square from z = 2, which fills the image from bottom to top."""
    near, far = 0.1, 100.0
    to_world = np.eye(4)
    to_world[:3, 3] = 0.5, 0.5, 2.0
    projection = np.zeros((4, 4))
    projection[0, 0] = 4.0 * height / width
    projection[1, 1] = 4.0
    projection[2, 2:] = (near + far) / (near - far), 2 * near * far / (near - far)
    projection[3, 2] = -1
    size = {"width": width, "height": height, "clip_start": near, "clip_end": far}
    return {"to_world": to_world, "projection": projection, **size, **more}
