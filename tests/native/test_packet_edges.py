# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles that cover much of a packet, aimed at along their edges: no lane group is left out.

Each ray comes eight times or more, so that lane groups have no size: what is left out is then only
held back by the bounds of rounding.
"""

from __future__ import annotations

import numpy as np
import pytest
import whittle_core
from numpy.typing import NDArray

POINT = np.array([0.3, -0.2, 0.4])
RAYS, ALIKE = 64, 16


def large_triangles(generator: np.random.Generator, count: int, size: float) -> NDArray:
    """count x 3 x 3 corners: some before the point, many with corners before and behind it."""
    centers = POINT + generator.uniform(-1, 1, (count, 1, 3))
    return (centers + size * generator.uniform(-1, 1, (count, 3, 3))).astype(np.float32)


def along_edge(
    generator: np.random.Generator, corners: NDArray, off: float
) -> tuple[NDArray, NDArray]:
    """Points on or beside an edge, in order, each several times, and the way from the point."""
    first, second, third = corners.astype(float)
    share = np.linspace(-0.05, 1.05, RAYS)[:, None]
    beside = off * generator.choice([-1, 0, 1], (RAYS, 1)) * (third - first)
    points = np.repeat(first + share * (second - first) + beside, ALIKE, axis=0)
    return points, points - POINT


def scene_of_corners(corners: NDArray) -> whittle_core.Scene:
    scene = whittle_core.Scene()
    flat = corners.reshape(-1, 3)
    mesh = scene.add_mesh(flat, np.arange(len(flat), dtype=np.uint32).reshape(-1, 3))
    scene.add_instance(mesh, np.eye(4))
    scene.build(lean=True)
    return scene


@pytest.mark.parametrize("off", [0.0, 1e-7, 1e-6, 1e-3])
@pytest.mark.parametrize("size", [0.05, 1.0])
def test_edges_of_large_triangles(size: float, off: float) -> None:
    generator = np.random.default_rng(5)
    hits = 0
    for _ in range(12):
        corners = large_triangles(generator, 6, size)
        scene = scene_of_corners(corners)
        for triangle in corners:
            points, directions = along_edge(generator, triangle, off)
            origins = np.broadcast_to(POINT, points.shape)
            alone = scene.intersect(origins, directions, packet=1)
            packets = scene.intersect(origins, directions, packet=256)
            for name, values in alone.items():
                np.testing.assert_array_equal(packets[name], values, err_msg=name)
            # And towards the point, from as far behind the edge.
            starts, back = points + directions, -2 * directions
            np.testing.assert_array_equal(
                scene.occluded(starts, back, t_max=1.0, packet=256),
                scene.occluded(starts, back, t_max=1.0, packet=1),
            )
            hits += np.count_nonzero(alone["instance"] >= 0)
    assert hits > 1000
