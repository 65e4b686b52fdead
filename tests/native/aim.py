# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays that the tests share: origins and directions float32 (k, 3), unless they say otherwise."""

import numpy as np
from meshes import Mesh, corners
from numpy.typing import ArrayLike, NDArray

Rays = tuple[NDArray[np.float32], NDArray[np.float32]]

KINDS = ("random", "edges", "vertices")


def targets(mesh: Mesh, kind: str, count: int, seed: int) -> NDArray[np.float64]:
    """Points on triangles, on their edges, or at their vertices, (count, 3)."""
    random = np.random.default_rng(seed)
    chosen = corners(mesh)[random.integers(len(mesh[1]), size=count)].astype(np.float64)
    turn = random.integers(3, size=count)
    a = chosen[np.arange(count), turn]
    b = chosen[np.arange(count), (turn + 1) % 3]
    if kind == "vertices":
        return a
    if kind == "edges":
        along = random.uniform(size=(count, 1))
        return a + along * (b - a)
    weights = random.dirichlet((1, 1, 1), count)
    return np.einsum("ki,kij->kj", weights, chosen)


def from_point(mesh: Mesh, kind: str, count: int, eye: ArrayLike, seed: int = 1) -> Rays:
    """Rays from one point to the mesh; the eye and then the directions are rounded to float."""
    eye = np.asarray(eye, np.float32)
    point = targets(mesh, kind, count, seed)
    return np.tile(eye, (count, 1)), (point - eye.astype(np.float64)).astype(np.float32)


def from_around(mesh: Mesh, kind: str, count: int, seed: int = 2) -> Rays:
    """Rays from random places in three times the mesh's box, most of them outside it."""
    random = np.random.default_rng(seed + 1000)
    low, high = mesh[0].min(axis=0).astype(float), mesh[0].max(axis=0).astype(float)
    origin = random.uniform(2 * low - high, 2 * high - low, (count, 3)).astype(np.float32)
    if kind == "random":
        return origin, random.normal(size=(count, 3)).astype(np.float32)
    point = targets(mesh, kind, count, seed)
    return origin, (point - origin.astype(np.float64)).astype(np.float32)


def pinhole(width: int, height: int, eye: ArrayLike, target: ArrayLike, degrees: float) -> Rays:
    """One ray through the centre of each pixel, row by row from the bottom."""
    eye, target = np.asarray(eye, np.float64), np.asarray(target, np.float64)
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, (0.0, 0.0, 1.0) if abs(forward[2]) < 0.9 else (0.0, 1.0, 0.0))
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    half = np.tan(np.radians(degrees) / 2)
    x = ((np.arange(width) + 0.5) / width * 2 - 1) * half
    y = ((np.arange(height) + 0.5) / height * 2 - 1) * half * height / width
    grid_y, grid_x = np.meshgrid(y, x, indexing="ij")
    direction = forward + grid_x[..., None] * right + grid_y[..., None] * up
    direction = direction.reshape(-1, 3).astype(np.float32)
    return np.tile(eye.astype(np.float32), (len(direction), 1)), direction


def tiled(rays: Rays, width: int, height: int, tile: int = 16) -> Rays:
    """The rays of an image in the order of square tiles, so that packets are coherent."""
    y, x = np.divmod(np.arange(width * height), width)
    order = np.lexsort((x % tile, y % tile, x // tile, y // tile))
    return rays[0][order], rays[1][order]
