# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras for Scene.render."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike


def perspective(
    width: int,
    height: int,
    eye: ArrayLike,
    target: ArrayLike,
    half_width: float = 0.36,
    near: float = 0.01,
    far: float = 1000.0,
) -> dict[str, Any]:
    """Looks from `eye` at `target`, z up; `half_width` is the tangent of half the field of view."""
    eye = np.asarray(eye, np.float64)
    forward = np.asarray(target, np.float64) - eye
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, (0, 0, 1) if abs(forward[2]) < 0.99 else (0, 1, 0))
    right /= np.linalg.norm(right)
    to_world = np.eye(4)
    to_world[:3, 0], to_world[:3, 1], to_world[:3, 2] = right, np.cross(right, forward), -forward
    to_world[:3, 3] = eye
    projection = np.zeros((4, 4))
    projection[0, 0] = 1 / half_width
    projection[1, 1] = width / height / half_width
    projection[2, 2:] = (far + near) / (near - far), 2 * far * near / (near - far)
    projection[3, 2] = -1
    return _camera(width, height, to_world, projection, near, far)


def orthographic(
    width: int,
    height: int,
    eye: ArrayLike,
    half_width: float,
    near: float = 0.0,
    far: float = 100.0,
) -> dict[str, Any]:
    """Looks down along -z from `eye`, x to the right."""
    to_world = np.eye(4)
    to_world[:3, 3] = eye
    projection = np.diag([1 / half_width, width / height / half_width, -2 / (far - near), 1.0])
    projection[2, 3] = -(far + near) / (far - near)
    return _camera(width, height, to_world, projection, near, far)


def _camera(width, height, to_world, projection, near, far) -> dict[str, Any]:
    return {
        "to_world": to_world,
        "projection": projection,
        "width": width,
        "height": height,
        "clip_start": near,
        "clip_end": far,
    }
