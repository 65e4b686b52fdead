# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The builder: its tree and its counts against plain numpy."""

import gc
import time
from collections.abc import Iterator

import meshes
import numpy as np
import pytest
from meshes import Mesh
from numpy.typing import NDArray
from trees import DEEPEST, LEAF, check_tree, half_areas, resident, scene_of, wait_after_cancel

SCENES = {
    "sphere": lambda: meshes.icosphere(4),
    "boxes": lambda: meshes.boxes(),
    "soup": lambda: meshes.random_triangles(3000, 0.1, 1),
    "needles": lambda: meshes.needles(2000, 1.0, 1e-6, 2),
    "duplicates": lambda: meshes.coplanar_duplicates(),
    "terrain": lambda: meshes.terrain(70),
}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("bins", [2, 8, 16, 64])
def test_tree_is_sound(name, bins):
    scene = scene_of(SCENES[name]())
    check_tree(scene, scene.build(bins=bins))


@pytest.mark.parametrize("max_leaf", [1, 2, 64])
@pytest.mark.parametrize("cost", [0.0, 0.1, 100.0])
def test_leaves_keep_their_limit_at_any_cost(max_leaf, cost):
    scene = scene_of(meshes.random_triangles(1000, 0.1, 1))
    check_tree(scene, scene.build(max_leaf=max_leaf, traversal_cost=cost), max_leaf)


def test_leaves_of_one_triangle_make_2n_minus_1_nodes():
    stats = scene_of(meshes.icosphere(3)).build(max_leaf=1)
    assert stats["nodes"] == 2 * 1280 - 1


@pytest.mark.parametrize("name", SCENES)
def test_stats_are_those_of_the_tree(name):
    scene = scene_of(SCENES[name]())
    stats = scene.build(traversal_cost=1.5)
    nodes = scene.nodes()
    area = half_areas(nodes["bounds_min"], nodes["bounds_max"])
    inner = nodes["count"] == 0
    cost = (1.5 * area[inner].sum() + (area * nodes["count"]).sum()) / area[0]
    assert stats["sah_cost"] == pytest.approx(cost, rel=1e-12)
    assert 32 * len(nodes) < stats["bytes_nodes"] < 90 * len(nodes), "this tree and the wide one"
    assert stats["bytes_triangles"] == (36 + 8 + 1) * stats["triangles"]
    assert stats["seconds"] >= stats["seconds_tree"] > 0


class PlainBuilder:
    """The heuristic again, written for clarity: doubles, one node at a time, lists."""

    def __init__(self, corners: NDArray, bins: int, max_leaf: int, cost: float):
        self.low = corners.min(axis=1).astype(np.float64)
        self.high = corners.max(axis=1).astype(np.float64)
        self.middle = (corners.min(axis=1) + corners.max(axis=1)).astype(np.float64)
        self.bins, self.max_leaf, self.cost = bins, max_leaf, cost
        self.areas = 0.0
        self.nodes = 0

    def area(self, which: NDArray) -> float:
        return float(half_areas(self.low[which].min(axis=0), self.high[which].max(axis=0)))

    def divisions(self, which: NDArray) -> Iterator[tuple[NDArray, NDArray]]:
        for axis in range(3):
            middle = self.middle[which, axis]
            if len(which) <= min(self.bins, 16):
                order = which[np.argsort(middle, kind="stable")]
                for plane in range(1, len(which)):
                    yield order[:plane], order[plane:]
            elif np.ptp(middle) > 0:
                scale = self.bins * (1 - 2**-20) / np.ptp(middle)
                bin_of = ((middle - middle.min()) * scale).astype(int)
                for plane in np.unique(bin_of)[1:]:
                    yield which[bin_of < plane], which[bin_of >= plane]

    def grow(self, which: NDArray) -> None:
        self.nodes += 1
        area = self.area(which)
        found = [
            (len(left) * self.area(left) + len(right) * self.area(right), i, left, right)
            for i, (left, right) in enumerate(self.divisions(which))
        ]
        best = min(found, key=lambda f: f[:2], default=None)
        as_leaf = best is None or len(which) * area <= self.cost * area + best[0]
        if as_leaf and len(which) <= self.max_leaf:
            self.areas += len(which) * area
            return
        self.areas += self.cost * area
        self.grow(best[2])
        self.grow(best[3])


@pytest.mark.parametrize("bins", [4, 16])
@pytest.mark.parametrize("mesh", [meshes.random_triangles(400, 0.15, 3), meshes.torus(24, 10)])
def test_splits_are_those_of_the_heuristic(bins, mesh):
    scene = scene_of(mesh)
    stats = scene.build(bins=bins)
    plain = PlainBuilder(scene.triangles()["vertices"], bins, LEAF, 1.0)
    every = np.arange(stats["triangles"])
    plain.grow(every)
    # Ties and roundings may send single triangles another way, but not change the whole.
    assert stats["sah_cost"] == pytest.approx(plain.areas / plain.area(every), rel=2e-3)
    assert stats["nodes"] == pytest.approx(plain.nodes, rel=0.02)


@pytest.mark.parametrize("mesh", [meshes.terrain(200), meshes.random_triangles(90_000, 0.02, 4)])
def test_the_same_tree_for_any_number_of_threads(mesh):
    scene = scene_of(mesh)
    trees = set()
    for threads in (1, 2, 3, 7, 2):
        stats = scene.build(threads=threads, on_progress=lambda fraction: True)
        triangles = scene.triangles()
        trees.add((scene.nodes().tobytes(), triangles["triangle"].tobytes(), stats["sah_cost"]))
    assert len(trees) == 1
    check_tree(scene, stats)


def identical(count: int) -> Mesh:
    return meshes.soup(np.tile([[0, 0, 0], [1, 0.2, 0.1], [0.3, 1, 0.4]], (count, 1, 1)))


def scaled(factor, offset=0.0) -> Mesh:
    positions, triangles = meshes.icosphere(3)
    return meshes.pack(positions.astype(np.float64) * factor + offset, triangles)


DEGENERATE = {
    "identical": lambda: identical(20_000),
    "concentric": lambda: meshes.concentric(2_000),
    "geometric spacing": meshes.geometric,
    "geometric spacing, deeper than the cap": lambda: meshes.geometric(300),
    "nested": meshes.nested,
    "far away": lambda: scaled(1.0, 1e6 * np.array([1, 0.7, -0.4])),
    "farther": lambda: scaled(1.0, 1e8 * np.array([1, 0.7, -0.4])),
    "one axis of 1e-40": lambda: scaled(np.array([1e-40, 1, 1])),
    "1e18": lambda: scaled(1e18),
    "3e38": lambda: scaled(3e38),
    "1e-21": lambda: scaled(1e-21),
    "1e-38": lambda: scaled(1e-38),
    "flat": lambda: scaled(np.array([1, 0, 1]), np.array([0, 0.125, 0])),
    "one triangle": lambda: identical(1),
    "two triangles": lambda: identical(2),
    "three triangles": lambda: meshes.concentric(4)[:1] + (meshes.concentric(4)[1][:3],),
    "none": lambda: (identical(1)[0], np.zeros((0, 3), np.uint32)),
    "nothing at all": lambda: meshes.pack(np.zeros((0, 3)), np.zeros((0, 3))),
    "mixed scales": lambda: meshes.join(scaled(1e6), scaled(1e-2), scaled(1e-9)),
}


@pytest.mark.parametrize("name", DEGENERATE)
def test_degenerate_scenes(name):
    mesh = DEGENERATE[name]()
    scene = scene_of(mesh)
    stats = scene.build(threads=3)
    check_tree(scene, stats)
    kept = stats["triangles"]
    assert kept + stats["dropped_zero_area"] == len(mesh[1])
    if kept:
        nodes = scene.nodes()
        assert np.abs(nodes["bounds_min"]).max() <= 1
        assert np.abs(nodes["bounds_max"]).max() <= 1
        assert np.isfinite(stats["sah_cost"])
        first = nodes.tobytes()
        scene.build(threads=1)
        assert scene.nodes().tobytes() == first


def test_the_depth_cap_is_reached_and_kept():
    """Clusters that the heuristic peels off one by one would go deeper than the cap."""
    stats = scene_of(meshes.geometric(300)).build(bins=2)
    assert stats["depth"] == DEEPEST
    assert stats["largest_leaf"] <= LEAF


@pytest.mark.parametrize("threads", [1, 0])
def test_cancelled_builds_end_soon_free_their_memory_and_leave_the_scene(threads, capsys):
    scene = scene_of(meshes.terrain(500))
    start = time.perf_counter()
    scene.build(threads=threads)
    whole = time.perf_counter() - start
    nodes = scene.nodes().tobytes()
    random = np.random.default_rng(57)
    gc.collect()
    before = resident()
    moments = random.uniform(0, whole, 10)
    every = [wait_after_cancel(scene, moment, threads=threads) for moment in moments]
    waits = [wait for wait in every if wait is not None]
    assert len(waits) >= 3
    assert resident() - before < 32 << 20
    assert scene.nodes().tobytes() == nodes
    with capsys.disabled():
        print(f"\ncancelled {len(waits)} builds; the slowest took {max(waits) * 1e3:.1f} ms")
    assert max(waits) < 0.1


def test_progress_grows_from_0_to_1():
    seen: list[float] = []
    scene_of(meshes.terrain(400)).build(on_progress=lambda fraction: seen.append(fraction) or True)
    assert seen[0] == 0
    assert seen == sorted(seen)
    assert seen[-1] <= 1


@pytest.mark.parametrize(
    ("options", "name"),
    [
        ({"bins": 1}, "bins"),
        ({"bins": 65}, "bins"),
        ({"max_leaf": 65}, "max_leaf"),
        ({"traversal_cost": -1.0}, "traversal_cost"),
        ({"traversal_cost": np.nan}, "traversal_cost"),
    ],
)
def test_options_out_of_range_name_themselves(options, name):
    with pytest.raises(ValueError, match=name):
        scene_of(identical(4)).build(**options)
