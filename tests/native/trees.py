# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What tests of trees share: scenes, what every tree must be, builds that are cancelled."""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from meshes import Mesh
from numpy.typing import NDArray
from whittle_core import Cancelled, Scene

DEEPEST = 64
LEAF = 8


def scene_of(*placed: Mesh | tuple[Mesh, NDArray]) -> Scene:
    """A scene of meshes, each placed once; the transform is the identity unless given."""
    scene = Scene()
    for item in placed:
        mesh, matrix = item if isinstance(item[0], tuple) else (item, np.eye(4))
        scene.add_instance(scene.add_mesh(*mesh), matrix)
    return scene


def walk(nodes: NDArray) -> Iterator[tuple[int, int]]:
    """(node, depth) from the root on, children after their parents."""
    waiting = [(0, 0)] if len(nodes) else []
    while waiting:
        index, depth = waiting.pop()
        yield index, depth
        if nodes["count"][index] == 0:
            child = int(nodes["left_first"][index])
            waiting += [(child + 1, depth + 1), (child, depth + 1)]


def check_tree(scene: Scene, stats: dict, max_leaf: int = LEAF) -> None:
    """Every promise of the structure, node by node."""
    nodes, triangles = scene.nodes(), scene.triangles()
    corners = triangles["vertices"]
    count = len(corners)
    assert stats["triangles"] == count
    assert len(nodes) <= max(2 * count - 1, 0)
    order = list(walk(nodes))
    assert sorted(i for i, _ in order) == list(range(len(nodes))), "one parent each, no orphan"
    leaf = nodes["count"] > 0
    low, high = np.empty((len(nodes), 3), np.float32), np.empty((len(nodes), 3), np.float32)
    covered = np.zeros(count, int)
    for index, _ in reversed(order):
        first, length = int(nodes["left_first"][index]), int(nodes["count"][index])
        if length:
            covered[first : first + length] += 1
            inside = corners[first : first + length].reshape(-1, 3)
            low[index], high[index] = inside.min(axis=0), inside.max(axis=0)
        else:
            assert first > index, "children come after their parent"
            assert first % 2 == 1, "siblings share a cache line"
            low[index] = np.minimum(low[first], low[first + 1])
            high[index] = np.maximum(high[first], high[first + 1])
    assert (covered == 1).all(), "each triangle in exactly one leaf"
    assert np.array_equal(nodes["bounds_min"], low)
    assert np.array_equal(nodes["bounds_max"], high)
    if count:
        assert nodes["count"].max() <= max_leaf
    depth = max((d for _, d in order), default=0)
    assert depth <= DEEPEST
    assert (stats["nodes"], stats["leaves"]) == (len(nodes), leaf.sum())
    assert stats["depth"] == depth
    assert stats["largest_leaf"] == (nodes["count"].max() if count else 0)


def half_areas(low: NDArray, high: NDArray) -> NDArray[np.float64]:
    x, y, z = np.moveaxis(high.astype(np.float64) - low.astype(np.float64), -1, 0)
    return x * y + y * z + z * x


def resident() -> int:
    """Bytes of memory that this process holds."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


def wait_after_cancel(scene: Scene, moment: float, **options: Any) -> float | None:
    """Cancels a build some seconds after its start; how long it then went on. None: it was over."""
    said = 0.0
    begin = time.perf_counter()

    def report(fraction: float) -> bool:
        nonlocal said
        assert 0 <= fraction <= 1
        said = time.perf_counter()
        return said - begin < moment

    try:
        scene.build(**options, on_progress=report)
    except Cancelled:
        return time.perf_counter() - said
    return None
