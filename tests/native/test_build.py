# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The builder: its tree, its frame and its counts against plain numpy."""

import gc
import time
from collections.abc import Iterator
from pathlib import Path

import meshes
import numpy as np
import pytest
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


def terrain(cells: int) -> Mesh:
    """A hilly square of 2 * cells^2 triangles."""
    x, y = np.meshgrid(np.linspace(0, 9, cells + 1), np.linspace(0, 9, cells + 1), indexing="ij")
    z = np.sin(x) * np.cos(1.3 * y) + 0.1 * np.sin(17 * x + 11 * y)
    corner = np.arange(cells * (cells + 1)).reshape(cells, cells + 1)[:, :-1].ravel()
    right, up = corner + cells + 1, corner + 1
    triangles = np.stack([corner, right, right + 1, corner, right + 1, up], axis=1)
    return meshes.pack(np.stack([x, y, z], axis=-1), triangles)


SCENES = {
    "sphere": lambda: meshes.icosphere(4),
    "boxes": lambda: meshes.boxes(),
    "soup": lambda: meshes.random_triangles(3000, 0.1, 1),
    "needles": lambda: meshes.needles(2000, 1.0, 1e-6, 2),
    "duplicates": lambda: meshes.coplanar_duplicates(),
    "terrain": lambda: terrain(70),
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


@pytest.mark.parametrize("mesh", [terrain(200), meshes.random_triangles(90_000, 0.02, 4)])
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


def concentric(count: int) -> Mesh:
    one = np.array([[[-1, -1, 0.1], [1, -1, 0.2], [0, 1, -0.3]]])
    pair = np.concatenate([one, -one])
    return meshes.soup(
        (pair * np.linspace(1, 3, count // 2)[:, None, None, None]).reshape(-1, 3, 3)
    )


def geometric(copies: int = 1) -> Mesh:
    size = np.repeat(2.0 ** np.arange(-60, 60), copies)[:, None, None]
    one = np.array([[1, 0, 0], [1.3, 0.5, 0], [1.3, 0, 0.5]])
    return meshes.soup(one * size)


def nested(count: int = 250) -> Mesh:
    one = np.array([[0, 0, 0], [1, 0.1, 0], [0.1, 1, 0.3]])
    return meshes.soup(one * 2.0 ** (0.4 * np.arange(count))[:, None, None])


def scaled(factor, offset=0.0) -> Mesh:
    positions, triangles = meshes.icosphere(3)
    return meshes.pack(positions.astype(np.float64) * factor + offset, triangles)


DEGENERATE = {
    "identical": lambda: identical(20_000),
    "concentric": lambda: concentric(2_000),
    "geometric spacing": geometric,
    "geometric spacing, deeper than the cap": lambda: geometric(300),
    "nested": nested,
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
    "three triangles": lambda: concentric(4)[:1] + (concentric(4)[1][:3],),
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
    stats = scene_of(geometric(300)).build(bins=2)
    assert stats["depth"] == DEEPEST
    assert stats["largest_leaf"] <= LEAF


def in_scene_space(world: NDArray, stats: dict) -> NDArray[np.float32]:
    return np.ldexp(world - np.array(stats["center"]), -stats["exponent"]).astype(np.float32)


def placed(mesh: Mesh, matrix: NDArray) -> NDArray[np.float64]:
    """World positions by the rounding that the core promises: products added from x to z."""
    x, y, z = np.moveaxis(mesh[0].astype(np.float64), 1, 0)
    with np.errstate(all="ignore"):
        return np.stack([((r[0] * x + r[1] * y) + r[2] * z) + r[3] for r in matrix[:3]], axis=1)


def random_matrix(seed: int) -> NDArray[np.float64]:
    random = np.random.default_rng(seed)
    matrix = np.eye(4)
    matrix[:3] = random.normal(size=(3, 4)) * [1, 1, 1, 50]
    return matrix


def test_frame_and_vertices_match_numpy():
    parts = [(meshes.icosphere(2), random_matrix(1)), (meshes.torus(), random_matrix(2))]
    scene = scene_of(*parts)
    stats = scene.build()
    world = [placed(mesh, matrix) for mesh, matrix in parts]
    every = np.concatenate(world)
    extent, step = np.ptp(every, axis=0).max(), 2.0 ** stats["exponent"]
    assert step / 2 < extent <= step
    middle = every.min(axis=0) / 2 + every.max(axis=0) / 2
    assert np.array_equal(np.mod(stats["center"], step), np.zeros(3))
    assert (np.abs(middle - stats["center"]) <= step / 2).all()
    triangles = scene.triangles()
    for instance, (mesh, _) in enumerate(parts):
        mine = triangles["instance"] == instance
        want = in_scene_space(world[instance], stats)[mesh[1][triangles["triangle"][mine]]]
        assert np.array_equal(triangles["vertices"][mine], want)
    assert not np.signbit(triangles["vertices"][triangles["vertices"] == 0]).any()


def test_moving_one_object_keeps_the_bits_of_the_others():
    still = (meshes.icosphere(3), random_matrix(3))
    seen = set()
    for x in (0.0, 0.37, 1.1, -0.9):
        scene = scene_of(
            (meshes.icosphere(1), meshes.transform(20.0)),
            still,
            (meshes.torus(), meshes.transform(1.0, (x, 0.2, 0))),
        )
        scene.build()
        triangles = scene.triangles()
        own = triangles["instance"] == 1
        order = np.argsort(triangles["triangle"][own])
        seen.add(triangles["vertices"][own][order].tobytes())
    assert len(seen) == 1


@pytest.mark.parametrize("subdivisions", [2, 6], ids=["small", "shared by threads"])
def test_vertices_that_no_good_triangle_uses_do_not_stretch_the_frame(subdivisions):
    positions, triangles = meshes.icosphere(subdivisions)
    alone = scene_of((positions, triangles))
    alone.build()
    stray = np.array([[1e30, 0, 0], [0, -1e20, 0], [np.nan, 0, 0]], np.float32)
    bad = np.arange(3, dtype=np.uint32)[None] + np.uint32(len(positions))
    scene = scene_of((np.concatenate([positions, stray]), np.concatenate([triangles, bad])))
    stats = scene.build()
    assert stats["dropped_non_finite"] == 1
    assert scene.nodes().tobytes() == alone.nodes().tobytes()


def test_vertices_of_no_triangle_do_not_stretch_the_frame_of_a_large_mesh():
    positions, triangles = meshes.icosphere(6)
    alone = scene_of((positions, triangles))
    alone.build()
    for place in (0, len(positions) // 2, len(positions)):
        grown = np.insert(positions, place, [[1e30, 0, 0]], axis=0)
        scene = scene_of((grown, np.where(triangles < place, triangles, triangles + 1)))
        scene.build()
        assert scene.nodes().tobytes() == alone.nodes().tobytes()


def test_the_first_bad_index_of_a_large_mesh_is_named():
    positions, triangles = meshes.icosphere(6)
    broken = triangles.copy()
    broken[[70_001, 70_000, 81_000], [0, 1, 2]] = len(positions) + np.arange(3)
    named = f"Triangle 70000 names vertex {len(positions) + 1}, but the mesh has {len(positions)}"
    with pytest.raises(ValueError, match=named):
        scene_of((positions, broken))


def test_many_vertices_in_a_row_that_no_triangle_uses():
    """Whole pieces of the work have nothing to bound then."""
    corners = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    padding = np.full((40_000, 3), 5, np.float32)
    mesh = np.concatenate([padding, corners, padding]), np.uint32([[40_000, 40_001, 40_002]])
    scene = scene_of(mesh)
    stats = scene.build()
    assert (stats["center"], stats["exponent"]) == ((1.0, 1.0, 0.0), 0)
    assert scene.intersect([[0.2, 0.2, 1]], [[0, 0, -1]])["t"] == 1


def judged(mesh: Mesh, matrix: NDArray, stats: dict) -> tuple[NDArray, NDArray]:
    """Which triangles are not finite, and which have no area, by the stated definitions."""
    with np.errstate(all="ignore"):
        world = placed(mesh, matrix)
        finite = (np.abs(world) <= np.finfo(np.float32).max).all(axis=1)[mesh[1]].all(axis=1)
        corners = in_scene_space(world, stats)[mesh[1]].astype(np.float64)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return ~finite, finite & (normal == 0).all(axis=1)


def test_bad_triangles_are_dropped_and_counted_by_mesh():
    random = np.random.default_rng(5)
    positions, triangles = meshes.random_triangles(4000, 0.2, 6)
    positions[random.integers(len(positions), size=300), random.integers(3, size=300)] = np.array(
        [np.nan, np.inf, -np.inf], np.float32
    )[np.arange(300) % 3]
    triangles[random.integers(4000, size=200), 1] = triangles[0, 2]
    points = triangles.copy()
    points[::3, 1] = points[::3, 0]
    huge = np.diag([1e38, 1e38, 1e38, 1.0])
    parts = [
        ((positions, triangles), random_matrix(7)),
        ((positions, points), np.eye(4)),
        (meshes.icosphere(1, 2.0), np.eye(4)),
        (meshes.icosphere(1, 9.0), huge),
    ]
    scene = scene_of(*parts)
    # A second instance of the second mesh: its triangles are dropped, and counted, twice.
    scene.add_instance(1, random_matrix(8))
    parts.append((parts[1][0], random_matrix(8)))
    stats = scene.build()
    expected: dict[int, list[int]] = {}
    kept = set()
    for instance, (mesh, matrix) in enumerate(parts):
        bad, flat = judged(mesh, matrix, stats)
        counts = expected.setdefault(instance if instance < 4 else 1, [0, 0])
        counts[0] += int(bad.sum())
        counts[1] += int(flat.sum())
        kept |= {(instance, int(t)) for t in np.flatnonzero(~bad & ~flat)}
    got = {d["mesh"]: [d["non_finite"], d["zero_area"]] for d in stats["dropped"]}
    assert got == {mesh: counts for mesh, counts in expected.items() if any(counts)}
    assert min(expected[1]) > 0
    assert expected[3][0] > 0
    found = scene.triangles()
    pairs = list(zip(found["instance"].tolist(), found["triangle"].tolist(), strict=True))
    assert set(pairs) == kept
    assert len(pairs) == len(kept)
    check_tree(scene, stats)


def resident() -> int:
    """Bytes of memory that this process holds."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


def wait_after_cancel(scene: Scene, threads: int, moment: float) -> float | None:
    """Cancels a build some seconds after its start; how long it then went on. None: it was over."""
    said = 0.0
    begin = time.perf_counter()

    def report(fraction: float) -> bool:
        nonlocal said
        assert 0 <= fraction <= 1
        said = time.perf_counter()
        return said - begin < moment

    try:
        scene.build(threads=threads, on_progress=report)
    except Cancelled:
        return time.perf_counter() - said
    return None


@pytest.mark.parametrize("threads", [1, 0])
def test_cancelled_builds_end_soon_free_their_memory_and_leave_the_scene(threads, capsys):
    scene = scene_of(terrain(500))
    start = time.perf_counter()
    scene.build(threads=threads)
    whole = time.perf_counter() - start
    nodes = scene.nodes().tobytes()
    random = np.random.default_rng(57)
    gc.collect()
    before = resident()
    moments = random.uniform(0, whole, 10)
    waits = [w for w in (wait_after_cancel(scene, threads, m) for m in moments) if w is not None]
    assert len(waits) >= 3
    assert resident() - before < 32 << 20
    assert scene.nodes().tobytes() == nodes
    with capsys.disabled():
        print(f"\ncancelled {len(waits)} builds; the slowest took {max(waits) * 1e3:.1f} ms")
    assert max(waits) < 0.1


def test_progress_grows_from_0_to_1():
    seen: list[float] = []
    scene_of(terrain(400)).build(on_progress=lambda fraction: seen.append(fraction) or True)
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


def test_triangles_of_corners_are_those_of_their_vertices():
    for subdivisions in (2, 6):
        positions, triangles = meshes.icosphere(subdivisions)
        order = np.random.default_rng(4).permutation(triangles.size).astype(np.uint32)
        corners = triangles.reshape(-1)[np.argsort(order)]
        built = []
        for arrays in ({"triangles": triangles}, {"triangles": order.reshape(-1, 3)}):
            scene = Scene()
            given = {"corners": corners} if built else {}
            scene.add_instance(scene.add_mesh(positions, **arrays, **given), np.eye(4))
            scene.build()
            built.append(scene.triangles()["vertices"].tobytes() + scene.nodes().tobytes())
        assert built[0] == built[1]
        replaced = Scene()
        replaced.add_instance(replaced.add_mesh(*meshes.icosphere(1)), np.eye(4))
        replaced.replace_mesh(0, positions, order.reshape(-1, 3), corners=corners)
        replaced.build()
        assert replaced.nodes().tobytes() == scene.nodes().tobytes()


@pytest.mark.parametrize(
    ("triangle", "corners", "sentence"),
    [
        ((0, 1, 4), (0, 1, 2, 0), "Triangle 0 names corner 4, but there are 4"),
        ((0, 1, 3), (0, 1, 2, 3), "Corner 3 names vertex 3, but the mesh has 3 vertices"),
        ((0, 1, 2), [(0, 1, 2)], r"corners must have the shape|corners .*\(k,\)"),
    ],
)
def test_a_bad_corner_is_named(triangle, corners, sentence):
    positions = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    with pytest.raises(ValueError, match=sentence):
        Scene().add_mesh(positions, np.uint32([triangle]), corners=np.uint32(corners))
