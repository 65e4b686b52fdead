# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions with zeros of both signs: packets, single rays and shadows of a sun straight above."""

import itertools

import numpy as np
import pytest
import whittle_core

AXES = [
    (axis, sign, zeros)
    for axis in range(3)
    for sign in (-1.0, 1.0)
    for zeros in itertools.product((0.0, -0.0), repeat=2)
]


@pytest.fixture(scope="module")
def soup() -> whittle_core.Scene:
    """Three thousand small random triangles in the unit cube."""
    random = np.random.default_rng(5)
    corners = random.random((3000, 1, 3)) + random.normal(0.0, 0.05, (3000, 3, 3))
    scene = whittle_core.Scene()
    triangles = np.arange(9000, dtype=np.uint32).reshape(-1, 3)
    scene.add_instance(scene.add_mesh(corners.reshape(-1, 3), triangles), np.eye(4))
    scene.build()
    return scene


@pytest.mark.parametrize(("axis", "sign", "zeros"), AXES)
def test_packets_hit_what_single_rays_hit(
    soup: whittle_core.Scene, axis: int, sign: float, zeros: tuple[float, float]
) -> None:
    random = np.random.default_rng(6)
    origins = random.random((4096, 3)).astype(np.float32)
    origins[:, axis] = -2.0 * sign
    direction = np.array([0.0, 0.0, 0.0], np.float32)
    direction[axis] = sign
    direction[[i for i in range(3) if i != axis]] = zeros
    directions = np.broadcast_to(direction, origins.shape).copy()
    single = soup.intersect(origins, directions, packet=1)
    assert (single["instance"] >= 0).sum() > 1000
    for packet in (16, 64, 256):
        together = soup.intersect(origins, directions, packet=packet)
        for name, values in single.items():
            np.testing.assert_array_equal(together[name].view(np.uint32), values.view(np.uint32))
        blocked = soup.occluded(origins, directions, packet=packet)
        np.testing.assert_array_equal(blocked, single["instance"] >= 0)


def test_a_sun_straight_above_casts_the_same_shadows_in_every_mode(
    soup: whittle_core.Scene,
) -> None:
    soup.set_lights([{"kind": "sun", "direction": (0.0, 0.0, -1.0), "intensity": (1.0, 1.0, 1.0)}])
    projection = np.array([[2, 0, 0, 0], [0, 2, 0, 0], [0, 0, -1, -1], [0, 0, -1, 0]], float)
    camera = {
        "to_world": [[1, 0, 0, 0.5], [0, 1, 0, 0.5], [0, 0, 1, 3.0], [0, 0, 0, 1]],
        "projection": projection,
        "width": 64,
        "height": 64,
        "clip_start": 0.01,
        "clip_end": 100.0,
    }
    pictures = [
        soup.render(camera, {"mode": mode})["combined"] for mode in ("single", "fast", "lecture")
    ]
    assert 0.0 < pictures[0][..., 0].mean() < 0.25
    for picture in pictures[1:]:
        np.testing.assert_array_equal(picture, pictures[0])
