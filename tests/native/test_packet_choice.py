# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Packets chosen for each stretch of rays: the hits are those of single rays in any case."""

from collections.abc import Callable

import meshes
import numpy as np
import pytest
from numpy.typing import NDArray
from trees import scene_of

Rays = tuple[NDArray, NDArray]
SIDE = 48


def grid(order: Callable[[NDArray], NDArray]) -> Rays:
    """From one point through a grid, in an order of its cells."""
    x, y = np.meshgrid(np.linspace(-1, 1, SIDE), np.linspace(-1, 1, SIDE))
    directions = np.stack([x, y, np.full_like(x, -2)], axis=-1).reshape(-1, 3)[
        order(np.arange(SIDE * SIDE))
    ]
    return np.broadcast_to([0.1, 0.2, 3.0], directions.shape), directions


def random_rays(parallel: bool) -> Rays:
    random = np.random.default_rng(8)
    origins = random.uniform(-2, 2, (3000, 3))
    directions = random.standard_normal((3000, 3))
    return origins, np.broadcast_to([0.2, -0.3, -1.0], directions.shape) if parallel else directions


def mixed() -> Rays:
    """Stretches of either kind, not as long as what is chosen for; and rays that cannot hit."""
    parts = [part[:200] for part in (random_rays(False), grid(lambda i: i), random_rays(True)) * 4]
    origins, directions = (np.concatenate([part[k][:200] for part in parts]) for k in (0, 1))
    origins[::37, 1] = np.nan
    directions[::41] = 0
    return origins, directions


STREAMS: dict[str, Callable[[], Rays]] = {
    "rows": lambda: grid(lambda i: i),
    "blocks": lambda: grid(lambda i: i.reshape(12, 4, 12, 4).swapaxes(1, 2).ravel()),
    "shuffled": lambda: grid(np.random.default_rng(3).permutation),
    "random": lambda: random_rays(False),
    "parallel": lambda: random_rays(True),
    "mixed": mixed,
}


@pytest.mark.parametrize("name", STREAMS)
def test_hits_are_those_of_single_rays(name: str) -> None:
    scene = scene_of(meshes.icosphere(4), (meshes.boxes(40), meshes.transform(0.7)))
    scene.build(lean=True)
    rays = STREAMS[name]()
    single, blocked = scene.intersect(*rays, packet=1), scene.occluded(*rays, packet=1)
    assert 0.1 < np.isfinite(single["t"]).mean() < 0.9
    for count in (len(rays[0]), 256, 255, 9, 2, 1):
        few = tuple(each[:count] for each in rays)
        hits = scene.intersect(*few)
        for key, values in hits.items():
            np.testing.assert_array_equal(values, single[key][:count], err_msg=key)
        np.testing.assert_array_equal(scene.occluded(*few), blocked[:count])


@pytest.mark.parametrize("cells", [300, 1050])
def test_hits_are_those_of_single_rays_where_a_pixel_holds_many_triangles(cells: int) -> None:
    """1050 cells are more triangles than the core takes for a scene that caches hold."""
    scene = scene_of(meshes.terrain(cells))
    scene.build(lean=True)
    low, high = meshes.terrain(2)[0].min(axis=0), meshes.terrain(2)[0].max(axis=0)
    eye, light = (low + high) / 2 + [0, 0, 2.0], np.array([*high[:2], 3.0])
    x, y = np.meshgrid(np.linspace(low[0], high[0], 64), np.linspace(low[1], high[1], 64))
    order = np.arange(64 * 64).reshape(16, 4, 16, 4).swapaxes(1, 2).ravel()
    ground = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)[order]
    eyes = np.broadcast_to(eye, ground.shape)
    single, hits = (scene.intersect(eyes, ground - eye, packet=n) for n in (1, 0))
    assert np.isfinite(single["t"]).mean() > 0.5
    for key, values in hits.items():
        np.testing.assert_array_equal(values, single[key], err_msg=key)
    points = eye + 0.999 * np.where(np.isfinite(hits["t"]), hits["t"], 0)[:, None] * (ground - eye)
    for direction, end in ((light - points, 1.0), ((ground - eye) * [1, 1, -1], np.inf)):
        alone, together = (
            (
                scene.occluded(points, direction, t_max=end, packet=n),
                scene.intersect(points, direction, t_max=end, packet=n),
            )
            for n in (1, 0)
        )
        np.testing.assert_array_equal(together[0], alone[0])
        for key, values in together[1].items():
            np.testing.assert_array_equal(values, alone[1][key], err_msg=key)
