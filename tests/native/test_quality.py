# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The tree judged: shape, overlap, fill, stretch and memory against plain numpy."""

import time
from itertools import product

import meshes
import numpy as np
import pytest
from numpy.typing import NDArray
from whittle_core import Cancelled, Scene

SPHERE = meshes.icosphere(2)


def scene_of(*placed, **build) -> Scene:
    """A built scene of (mesh, transform) pairs."""
    scene = Scene()
    for mesh, matrix in placed:
        scene.add_instance(scene.add_mesh(*mesh), matrix)
    scene.build(**build)
    return scene


def small_scene(**build) -> Scene:
    """Two clouds of large triangles that stand in each other, and a far one."""
    return scene_of(
        (meshes.random_triangles(24, 0.3, 1), np.eye(4)),
        (meshes.random_triangles(20, 0.2, 2), meshes.transform(1.0, (0.3, 0.1, 0.0))),
        (meshes.random_triangles(9, 0.1, 3), meshes.transform(0.5, (4.0, -1.0, 2.0))),
        **build,
    )


def walk(nodes: NDArray) -> dict[int, tuple[int, list[int]]]:
    """Depth and triangles of each node."""
    found: dict[int, tuple[int, list[int]]] = {}

    def visit(index: int, depth: int) -> list[int]:
        first, count = int(nodes["left_first"][index]), int(nodes["count"][index])
        below = (
            list(range(first, first + count))
            if count
            else visit(first, depth + 1) + visit(first + 1, depth + 1)
        )
        found[index] = depth, below
        return below

    if len(nodes):
        visit(0, 0)
    return found


def surface(low: NDArray, high: NDArray) -> float:
    x, y, z = np.float64(high) - np.float64(low)
    return 2 * float(x * y + y * z + z * x)


def box_of(corners: NDArray) -> tuple[NDArray, NDArray]:
    return corners.reshape(-1, 3).min(axis=0), corners.reshape(-1, 3).max(axis=0)


def areas(corners: NDArray) -> NDArray[np.float64]:
    a, b, c = np.moveaxis(corners.astype(np.float64), 1, 0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def area_inside(corners: NDArray, low: NDArray, high: NDArray) -> float:
    """Area of a triangle within a box: the hull of every point where their edges meet.

    Vertices in the box, edges through its planes, and the box's edges through the triangle; no
    polygon is clipped."""
    corners, low, high = (np.asarray(x, np.float64) for x in (corners, low, high))
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    points = list(corners)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        start, along = corners[a], corners[b] - corners[a]
        for axis, plane in product(range(3), (low, high)):
            if along[axis]:
                points.append(start + (plane[axis] - start[axis]) / along[axis] * along)
    for axis in range(3):
        if normal[axis]:
            for corner in product(*zip(low, high, strict=True)):
                point = np.array(corner)
                point[axis] -= np.dot(point - corners[0], normal) / normal[axis]
                points.append(point)
    points = np.array(points)
    near = 1e-9
    to_corners = corners[None] - points[:, None]
    sides = np.cross(to_corners, np.roll(to_corners, -1, axis=1)) @ normal
    inside = (points >= low - near).all(axis=1) & (points <= high + near).all(axis=1)
    points = points[inside & (sides >= -near * np.dot(normal, normal)).all(axis=1)]
    if len(points) < 3:
        return 0.0
    across = corners[1] - corners[0]
    flat = (points - points.mean(axis=0)) @ np.stack([across, np.cross(normal, across)], axis=1)
    flat /= np.linalg.norm(across) * np.array([1, np.linalg.norm(normal)])
    x, y = flat[np.argsort(np.arctan2(flat[:, 1], flat[:, 0]))].T
    return abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2


def plain_overlap(scene: Scene, cost: float, area_of=area_inside) -> NDArray[np.float64]:
    """Each triangle's part in the overlap, from its definition."""
    nodes, corners = scene.nodes(), scene.triangles()["vertices"]
    parts = np.zeros(len(corners))
    for index, (_, below) in walk(nodes).items():
        node, own = nodes[index], set(below)
        weight = int(node["count"]) or cost
        for triangle in range(len(corners)):
            if triangle not in own:
                box = node["bounds_min"], node["bounds_max"]
                parts[triangle] += weight * area_of(corners[triangle], *box)
    return parts / areas(corners).sum()


def test_the_shape_is_that_of_the_nodes():
    scene = scene_of((SPHERE, np.eye(4)), (meshes.boxes(), meshes.transform(1.0, (1, 0, 0))))
    stats = scene.build(traversal_cost=1.7, max_leaf=5)
    quality = scene.quality()
    nodes = scene.nodes()
    leaves = [(depth, len(below)) for i, (depth, below) in walk(nodes).items() if nodes["count"][i]]
    depth, size = np.array(leaves).T
    assert np.array_equal(quality["depth_histogram"], np.bincount(depth))
    assert np.array_equal(quality["leaf_size_histogram"], np.bincount(size))
    assert quality["sah_cost"] == pytest.approx(stats["sah_cost"], rel=1e-12)
    for name in ("triangles", "nodes", "leaves", "bytes", "depth", "largest_leaf"):
        assert quality[name] == stats[name], name
    assert len(quality["instance"]["triangles"]) == 2 and "overlap" not in quality


def test_the_overlap_is_that_of_the_definition():
    scene = small_scene(traversal_cost=1.5, max_leaf=4)
    quality = scene.quality(overlap=True)
    parts, instance = plain_overlap(scene, 1.5), scene.triangles()["instance"]
    assert quality["overlap"] == pytest.approx(parts.sum(), rel=1e-9)
    assert quality["overlap_samples"] == 53
    by_instance = np.bincount(instance, parts)
    assert quality["instance"]["overlap_part"] == pytest.approx(by_instance, rel=1e-9)
    assert quality["material"]["overlap_part"] == pytest.approx([parts.sum()], rel=1e-9)

    def whole(corners: NDArray, low: NDArray, high: NDArray) -> float:
        """What a test of boxes instead of clipping would say."""
        own_low, own_high = box_of(corners)
        return float(areas(corners[None])[0]) * bool(((own_low <= high) & (low <= own_high)).all())

    assert plain_overlap(scene, 1.5, whole).sum() > 1.5 * quality["overlap"]


def test_triangles_that_lie_in_a_flat_box_count_with_their_area():
    """Two squares in one plane, the one within the other: clipped by planes that they lie in."""
    square = (
        np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]),
        np.uint32([[0, 1, 2], [0, 2, 3]]),
    )
    scene = scene_of((square, np.eye(4)), (square, meshes.transform(0.5)), max_leaf=1)
    parts = plain_overlap(scene, 1.0)
    assert scene.quality(overlap=True)["overlap"] == pytest.approx(parts.sum(), rel=1e-9)
    assert parts.sum() > 0.3


def test_samples_estimate_the_overlap():
    scene = scene_of(*((meshes.random_triangles(3000, 0.1, seed), np.eye(4)) for seed in (1, 2)))
    exact = scene.quality(overlap=True)
    assert scene.quality(overlap=True, overlap_samples=10_000)["overlap"] == exact["overlap"]
    sampled = scene.quality(overlap=True, overlap_samples=1000)
    assert sampled["overlap_samples"] == 1000
    assert sampled["overlap"] == pytest.approx(exact["overlap"], rel=0.1)
    assert sampled["overlap"] != exact["overlap"]
    assert sampled["instance"]["overlap_part"].sum() == pytest.approx(sampled["overlap"])


def test_fill_is_1_for_a_right_triangle_along_the_axes_and_0_for_a_diagonal_sliver():
    right = [[0, 0, 0], [3, 0, 0], [0, 0, 0.001]]
    sliver = [[0, 0, 0], [1, 1, 1], [1, 1, 1.001]]
    for corners, fill in ((right, 1.0), (sliver, 0.0005)):
        quality = scene_of((meshes.soup(np.array([corners])), np.eye(4))).quality()
        assert quality["box_fill"] == pytest.approx(fill, rel=0.1)
        assert quality["slivers"] == (fill < 1 / 16)


def test_fill_and_areas_are_those_of_the_formula():
    mesh = meshes.random_triangles(500, 0.2, 4)
    scene = scene_of((mesh, meshes.transform(8.0, (100, 0, 0))), (SPHERE, np.eye(4)))
    quality, triangles = scene.quality(), scene.triangles()
    corners, instance = triangles["vertices"], triangles["instance"]
    box = np.array([surface(*box_of(t)) for t in corners])
    area = areas(corners)
    fill = 4 * area / box
    assert quality["box_fill"] == pytest.approx(fill.mean(), rel=1e-9)
    assert 0 < fill.min() and fill.max() <= 1 + 1e-9
    part = quality["instance"]
    count = np.bincount(instance)
    assert np.array_equal(part["triangles"], count)
    assert part["box_fill"] == pytest.approx(np.bincount(instance, fill) / count, rel=1e-9)
    assert np.array_equal(part["slivers"], np.bincount(instance, fill < 1 / 16))
    largest = [area[instance == i].max() / area[instance == i].sum() for i in (0, 1)]
    assert part["largest_triangle_share"] == pytest.approx(largest, rel=1e-9)
    # In the world's units, the scene's frame undone.
    world = [areas(meshes.corners(mesh)).sum() * 64, areas(meshes.corners(SPHERE)).sum()]
    assert part["area"] == pytest.approx(world, rel=1e-3)
    low, high = box_of(meshes.corners(mesh) * 8.0 + np.float32([100, 0, 0]))
    assert part["box_min"][0] == pytest.approx(low, abs=1e-4)
    assert part["box_max"][0] == pytest.approx(high, abs=1e-4)


def plain_stretch(scene: Scene, labels: NDArray, count: int) -> tuple[NDArray, NDArray]:
    """Nodes that hold one label only, and the share of shared surface that each label causes."""
    nodes, corners = scene.nodes(), scene.triangles()["vertices"]
    alone, lost, shared = np.zeros(count), np.zeros(count), 0.0
    for _, below in walk(nodes).values():
        mine = labels[below]
        if (mine == mine[0]).all():
            alone[mine[0]] += 1
            continue
        whole = surface(*box_of(corners[below]))
        shared += whole
        for label in np.unique(mine):
            others = np.array(below)[mine != label]
            lost[label] += whole - surface(*box_of(corners[others]))
    return alone, lost / shared


def test_stretch_is_what_shared_boxes_would_lose():
    scene = small_scene(max_leaf=3)
    part = scene.quality()["instance"]
    nodes, stretch = plain_stretch(scene, scene.triangles()["instance"], 3)
    assert np.array_equal(part["nodes"], nodes)
    assert part["stretch"] == pytest.approx(stretch, rel=1e-9)


def test_subtrees_and_edited_scenes_are_judged_alike():
    """Trees put together from subtrees, some of them rebuilt, are trees like others."""
    scene = small_scene()
    for edit in (lambda: None, lambda: scene.remove_instance(1)):
        edit()
        scene.set_transform(0, meshes.transform(1.0, (0.1, 0, 0)))
        stats = scene.build(by_instance=True, traversal_cost=1.5)
        quality = scene.quality(overlap=True, by_instance=True)
        assert quality["sah_cost"] == pytest.approx(stats["sah_cost"], rel=1e-12)
        nodes, stretch = plain_stretch(scene, scene.triangles()["instance"], 3)
        part = quality["instance"]
        assert np.array_equal(part["nodes"], nodes)
        assert part["stretch"] == pytest.approx(stretch, rel=1e-9)
    assert not any(part[name][1].any() for name in part), "nothing is left of what was removed"
    assert quality["overlap"] == pytest.approx(plain_overlap(scene, 1.5).sum(), rel=1e-9)


def test_a_stray_triangle_stretches_the_shared_boxes():
    stray = meshes.soup(np.array([[[50, 60, 70], [50.1, 60, 70], [50, 60.1, 70]]]))
    spheres = [(SPHERE, meshes.transform(1.0, (0.4 * i, 0, 0))) for i in range(4)]
    part = scene_of(*spheres, (stray, np.eye(4))).quality()["instance"]
    assert part["stretch"].argmax() == 4 and part["stretch"][4] > 0.3
    assert part["stretch"][:4].max() < 0.15


def test_materials_are_judged_like_instances():
    mesh = meshes.random_triangles(60, 0.3, 7)
    scene = Scene()
    which = np.arange(60, dtype=np.uint32) % 3
    scene.add_instance(scene.add_mesh(*mesh, materials=which), np.eye(4))
    scene.set_materials([{"diffuse": (1, 1, 1)}] * 4)
    scene.build()
    part, triangles = scene.quality()["material"], scene.triangles()
    labels = which[triangles["triangle"]].astype(int)
    nodes, stretch = plain_stretch(scene, labels, 4)
    assert np.array_equal(part["triangles"], [20, 20, 20, 0])
    assert np.array_equal(part["nodes"], nodes)
    assert part["stretch"] == pytest.approx(stretch, rel=1e-9)
    scene.set_materials([{}] * 2)
    with pytest.raises(ValueError, match="material 2 of 2 does not exist"):
        scene.quality()


def test_memory_is_shared_out_once():
    scene = small_scene()
    stats, part = scene.build(), scene.quality()["instance"]
    each = stats["bytes_nodes"] / stats["nodes"]
    shared = (stats["nodes"] - part["nodes"].sum()) * each
    assert part["bytes"].sum() + shared == pytest.approx(stats["bytes"], abs=7)
    alone = scene_of((SPHERE, np.eye(4)))
    assert alone.quality()["instance"]["bytes"][0] == alone.build()["bytes"]
    # Two instances of one mesh pay for it together.
    pair = Scene()
    mesh = pair.add_mesh(*SPHERE)
    for x in (0, 5):
        pair.add_instance(mesh, meshes.transform(1.0, (x, 0, 0)))
    stats = pair.build()
    bytes_ = pair.quality()["instance"]["bytes"]
    assert bytes_[0] == pytest.approx(stats["bytes"] / 2, rel=0.02)


def test_own_trees_cost_what_they_would_alone():
    parts = [(meshes.torus(), np.eye(4)), (meshes.boxes(), meshes.transform(2.0, (0.3, 0, 0)))]
    options = {"traversal_cost": 2.0, "max_leaf": 4, "bins": 8}
    together = scene_of(*parts, **options).quality(by_instance=True)["instance"]["sah_cost"]
    alone = [scene_of(part).build(**options)["sah_cost"] for part in parts]
    assert together == pytest.approx(alone, rel=1e-3)


def test_strays_are_told_from_the_rest_of_an_object():
    far = np.array([[[40, 0, 0], [40, 1, 0], [40, 0, 1]], [[40, 1, 1], [40, 1, 0], [40, 0, 1]]])
    mesh = meshes.join(meshes.icosphere(3), meshes.soup(far))
    part = scene_of((mesh, np.eye(4)), (SPHERE, np.eye(4))).quality(by_instance=True)["instance"]
    core, whole = (surface(*box_of(meshes.corners(m))) for m in (meshes.icosphere(3), mesh))
    assert part["stray_share"][0] == pytest.approx(1 - core / whole, rel=1e-4)
    assert part["stray_triangles"][0] == 2
    assert part["stray_share"][1] < 0.2 and part["stray_triangles"][1] <= 3


def plain_share(scene: Scene, instance: int) -> float:
    """Share of random points on an instance that lie in a leaf which is not its own alone."""
    nodes, triangles = scene.nodes(), scene.triangles()
    leaves = [i for i in range(len(nodes)) if nodes["count"][i]]
    below = {i: t for i, (_, t) in walk(nodes).items()}
    foreign = [i for i in leaves if (triangles["instance"][below[i]] != instance).any()]
    corners = triangles["vertices"][triangles["instance"] == instance].astype(np.float64)
    random = np.random.default_rng(1)
    area = areas(corners)
    chosen = corners[random.choice(len(corners), 8_000, p=area / area.sum())]
    weight = random.dirichlet((1, 1, 1), len(chosen))
    points = (chosen * weight[:, :, None]).sum(axis=1)
    inside = np.zeros(len(points), bool)
    for leaf in foreign:
        low, high = nodes["bounds_min"][leaf], nodes["bounds_max"][leaf]
        inside |= ((points >= low) & (points <= high)).all(axis=1)
    return float(inside.mean())


def test_the_share_inside_others_is_that_of_random_points():
    scene = scene_of(
        (SPHERE, np.eye(4)),
        (SPHERE, meshes.transform(1.0, (0.5, 0, 0))),
        (meshes.box((-1.2, -0.2, -0.2), (3, 0.2, 0.2)), np.eye(4)),
        (SPHERE, meshes.transform(1.0, (9, 0, 0))),
    )
    share = scene.quality(by_instance=True)["instance"]["overlap"]
    assert share == pytest.approx([plain_share(scene, i) for i in range(4)], abs=0.03)
    assert share[3] == 0 and share[:3].min() > 0.05


def test_results_are_the_same_for_any_number_of_threads():
    scene = scene_of(*((meshes.random_triangles(2000, 0.1, seed), np.eye(4)) for seed in (1, 2)))
    found = set()
    for threads in (1, 2, 5):
        quality = scene.quality(True, True, threads=threads)
        parts = [quality["instance"][name].tobytes() for name in sorted(quality["instance"])]
        found.add((quality["overlap"], quality["sah_cost"], *parts))
    assert len(found) == 1


def test_an_empty_scene_has_nothing_to_judge():
    scene = Scene()
    scene.build()
    quality = scene.quality(True, True)
    assert quality["triangles"] == quality["nodes"] == quality["overlap"] == 0
    assert quality["instance"]["sah_cost"].shape == (0,)


def test_an_instance_without_triangles_has_zeros():
    scene = scene_of((SPHERE, np.eye(4)))
    nothing = scene.add_mesh(np.zeros((0, 3)), np.zeros((0, 3), np.uint32))
    scene.add_instance(nothing, np.eye(4))
    with pytest.raises(RuntimeError, match="build it first"):
        scene.quality()
    scene.build()
    part = scene.quality(True, True)["instance"]
    assert all(not np.any(values[1]) for values in part.values())
    assert all(np.any(part[name][0]) for name in ("triangles", "bytes", "sah_cost", "area"))


@pytest.mark.parametrize("name, value", [("threads", -1), ("overlap_samples", "x")])
def test_arguments_that_make_no_sense_are_named(name, value):
    with pytest.raises(ValueError, match=name):
        scene_of((SPHERE, np.eye(4))).quality(**{name: value})


def test_progress_rises_and_can_cancel():
    scene = scene_of((meshes.random_triangles(30_000, 0.2, 8), np.eye(4)))
    seen: list[float] = []
    scene.quality(True, True, seen.append, overlap_samples=2000)
    assert seen == sorted(seen) and all(0 <= fraction <= 1 for fraction in seen)
    stopped: list[float] = []

    def stop(fraction: float) -> bool:
        stopped.append(time.monotonic())
        return fraction < 0.1

    with pytest.raises(Cancelled):
        scene.quality(True, True, stop)
    assert time.monotonic() - stopped[-1] < 0.5
    assert scene.quality()["triangles"] == 30_000, "the scene can still be judged"
