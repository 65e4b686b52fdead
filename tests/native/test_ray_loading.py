# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The quick way to load ordinary float rays gives what the careful way gives."""

from __future__ import annotations

import numpy as np
import pytest
import whittle_core

SPECIAL = [0.0, -0.0, np.inf, -np.inf, np.nan, 1e-45, -1e-40, 3e38, -3e38, 1e-20, 2.0**61, 2.0**-61]


def odd_floats(generator: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Mostly ordinary numbers, among them all the special ones."""
    values = generator.uniform(-2, 2, shape)
    picks = generator.integers(0, 8 * len(SPECIAL), shape)
    for index, special in enumerate(SPECIAL):
        values = np.where(picks == index, special, values)
    return values.astype(np.float32)


@pytest.mark.filterwarnings("ignore:overflow:RuntimeWarning", "ignore:invalid:RuntimeWarning")
@pytest.mark.parametrize("scale", [1.0, 1e-12, 1e6, 1e25])
def test_floats_and_doubles_give_the_same_bits(scale: float) -> None:
    # Rays given as doubles take the careful way, one by one.
    generator = np.random.default_rng(11)
    scene = whittle_core.Scene()
    corners = generator.uniform(-1, 1, (600, 3)) * scale
    indices = np.arange(600, dtype=np.uint32).reshape(-1, 3)
    mesh = scene.add_mesh(corners.astype(np.float32), indices)
    scene.add_instance(mesh, np.eye(4))
    scene.build()
    count = 20_000
    # Origins among the triangles, so that many rays hit; directions of every length.
    origins = np.where(generator.random((count, 1)) < 0.9, 1, odd_floats(generator, (count, 3)))
    origins = (origins * generator.uniform(-1, 1, (count, 3)) * scale).astype(np.float32)
    directions = odd_floats(generator, (count, 3)) * np.float32(2) ** generator.integers(-70, 70)
    limits = {
        "t_min": np.where(generator.random(count) < 0.5, 0, odd_floats(generator, (count,))),
        "t_max": np.where(generator.random(count) < 0.5, np.inf, odd_floats(generator, (count,))),
    }
    floats = {name: (value * scale).astype(np.float32) for name, value in limits.items()}
    doubles = {name: value.astype(np.float64) for name, value in floats.items()}
    quick = scene.intersect(origins, directions, **floats)
    careful = scene.intersect(origins.astype(float), directions.astype(float), **doubles)
    for name in ("t", "instance", "triangle", "u", "v"):
        assert quick[name].tobytes() == careful[name].tobytes(), name
    assert 100 < np.count_nonzero(quick["instance"] >= 0) < count


def test_one_origin_for_all_rays() -> None:
    scene = whittle_core.Scene()
    mesh = scene.add_mesh(np.float32([[-5, -5, 0], [5, -5, 0], [0, 5, 0]]), np.uint32([[0, 1, 2]]))
    scene.add_instance(mesh, np.eye(4))
    scene.build()
    directions = np.random.default_rng(2).normal(size=(1000, 3)).astype(np.float32)
    origin = np.float32([[0.1, 0.2, 3]])
    shared = scene.intersect(np.broadcast_to(origin, (1000, 3)), directions)
    apart = scene.intersect(np.repeat(origin, 1000, axis=0), directions)
    assert shared["t"].tobytes() == apart["t"].tobytes()
    assert np.isfinite(shared["t"]).any()
