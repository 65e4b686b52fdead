# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays through whittle_core: types, limits, misses, drops, ties, and the tree that they meet."""

from math import inf, nan

import meshes
import numpy as np
import pytest
import whittle_core
from hypothesis import given
from hypothesis import strategies as st
from small_scenes import DOWN, ONE, TRIANGLE, built, camera, changed, rays
from whittle_core import Scene


@pytest.fixture(scope="module")
def soup() -> Scene:
    return built(*meshes.random_triangles(2000, 0.1, seed=3))


def test_hits_have_the_promised_types(soup):
    hits = soup.intersect(*rays(100), counters=True)
    types = {name: column.dtype.name for name, column in hits.items()}
    kinds = dict.fromkeys(("instance", "triangle"), "int32")
    kinds |= dict.fromkeys(("t", "u", "v"), "float32")
    assert types == kinds | dict.fromkeys(("nodes", "triangles"), "uint32")
    assert all(column.shape == (100,) for column in hits.values())
    miss = hits["instance"] < 0
    assert 0 < miss.sum() < 100
    assert np.isposinf(hits["t"][miss]).all() and (hits["triangle"][miss] == -1).all()
    assert (hits["nodes"] > 0).all()
    assert soup.reference_intersect(*rays(100)).keys() == kinds.keys()
    blocked = soup.occluded(*rays(100))
    assert blocked.dtype == bool
    np.testing.assert_array_equal(blocked, ~miss)


def test_u_and_v_weigh_the_second_and_third_vertex():
    positions, triangles = meshes.random_triangles(2000, 0.1, seed=3)
    scene = built(positions, triangles)
    origins, directions = rays(2000)
    hits = scene.intersect(origins, directions)
    hit = hits["triangle"] >= 0
    a, b, c = np.moveaxis(positions[triangles[hits["triangle"][hit]]].astype(float), 1, 0)
    u, v = hits["u"][hit, None], hits["v"][hit, None]
    place = origins[hit] + hits["t"][hit, None] * directions[hit]
    np.testing.assert_allclose(a + u * (b - a) + v * (c - a), place, atol=1e-5)


def test_strides_and_types_of_rays_do_not_matter(soup):
    origins, directions = (values.astype(np.float32) for values in rays(1000))
    wanted = soup.intersect(origins, directions)
    wide = np.zeros(1000, np.dtype([("pad", "u1"), ("o", "f4", 3), ("d", "f8", 3)]))
    wide["o"], wide["d"] = origins, directions
    both = np.zeros((1000, 3, 2), np.float32)
    both[..., 0], both[..., 1] = origins, directions
    variants = [
        (origins.astype(np.float64), directions),
        (origins, directions.astype(">f8")),
        (np.asfortranarray(origins), np.asfortranarray(directions.astype(np.float64))),
        (wide["o"], wide["d"]),
        (both[..., 0], both[..., 1]),
        (origins[::-1].copy()[::-1], directions.tolist()),
    ]
    for variant in variants:
        for name, column in soup.intersect(*variant).items():
            np.testing.assert_array_equal(column, wanted[name])


def test_one_origin_may_stand_for_all(soup):
    directions = rays(500)[1]
    shared = np.broadcast_to([0.5, 0.5, 0.5], (500, 3))
    wanted = soup.intersect(np.array(shared), directions)
    np.testing.assert_array_equal(soup.intersect(shared, directions)["t"], wanted["t"])


@given(st.integers(-140, 140), st.floats(0.5, 2))
def test_t_is_in_units_of_the_direction(exponent, length):
    scale = length * 2.0**exponent
    hits = built(TRIANGLE, ONE).intersect(DOWN[0], DOWN[1] * scale)
    wanted = min(1 / scale, float(np.finfo("f4").max))
    np.testing.assert_allclose(hits["t"].astype(float), wanted, rtol=1e-6, atol=1e-45)


@pytest.mark.parametrize("trace", ["intersect", "reference_intersect"])
def test_a_hit_has_t_min_below_t_and_t_at_most_t_max(trace):
    below, above = np.nextafter(1, 0), np.nextafter(1, 2)
    scene = built(TRIANGLE, ONE)
    limits = [(0, 1, True), (0, below, False), (1, inf, False), (below, 1, True)]
    limits += [(below, below, False), (0, above, True), (above, inf, False), (-inf, 1, True)]
    limits += [(nan, inf, False), (0, nan, False), (2, 1, False)]
    for t_min, t_max, hit in limits:
        found = getattr(scene, trace)(*DOWN, t_min, t_max)["t"] == 1
        assert found == hit, (t_min, t_max)
        assert scene.occluded(*DOWN, t_min=t_min, t_max=t_max) == hit, (t_min, t_max)
    lows, highs, wanted = (np.array(column) for column in zip(*limits, strict=True))
    many = [np.repeat(values, len(limits), axis=0) for values in DOWN]
    for kind in (np.float64, list):
        found = getattr(scene, trace)(*many, kind(lows), kind(highs))["t"] == 1
        np.testing.assert_array_equal(found, wanted)
    lower = scene.intersect(*many, t_min=np.float32(0.5), t_max=highs.astype(np.float32))
    np.testing.assert_array_equal(lower["t"] == 1, highs.astype(np.float32) >= 1)


def test_zero_and_non_finite_rays_miss():
    good = np.repeat(DOWN[0], 8, axis=0), np.repeat(DOWN[1], 8, axis=0)
    bad_origins, bad_directions = good[0].copy(), good[1].copy()
    bad_origins[np.arange(6), np.arange(6) % 3] = [nan, inf, -inf, nan, inf, -inf]
    bad_directions[np.arange(6), np.arange(6) % 3] = [nan, inf, -inf, inf, nan, nan]
    bad_directions[6:] = [[0, 0, 0], [-0.0, 0, -0.0]]
    scene = built(TRIANGLE, ONE)
    for trace in (scene.intersect, scene.reference_intersect):
        np.testing.assert_array_equal(trace(bad_origins, good[1])["instance"], [-1] * 6 + [0] * 2)
        np.testing.assert_array_equal(trace(good[0], bad_directions)["instance"], [-1] * 8)
    assert not scene.occluded(good[0], bad_directions).any()


def test_visibility_is_by_bits():
    scene = Scene()
    mesh = scene.add_mesh(TRIANGLE, ONE)
    scene.add_instance(mesh, np.eye(4), 0, whittle_core.SHADOW | whittle_core.REFRACTION)
    scene.add_instance(mesh, changed(2, 3, -1), visibility=whittle_core.CAMERA)
    scene.add_instance(mesh, changed(2, 3, 0.5), visibility=0)
    scene.build()
    seen = {
        bit: scene.intersect(*DOWN, visibility=bit)["instance"].item()
        for bit in (whittle_core.CAMERA, whittle_core.SHADOW, whittle_core.REFLECTION)
    }
    assert list(seen.values()) == [1, 0, -1]
    for bit, instance in seen.items():
        assert scene.occluded(*DOWN, visibility=bit) == (instance >= 0)
        assert scene.reference_intersect(*DOWN, visibility=bit)["instance"] == instance
    assert scene.intersect(*DOWN)["instance"] == 0


BAD_RAYS = {
    "origins": [DOWN[0][0], DOWN[0][:, :2], "o", None, DOWN[0] * 1j, DOWN[0][None]],
    "directions": [np.repeat(DOWN[1], 2, axis=0), DOWN[1][0], object(), DOWN[1].astype(object)],
    "t_min": [[0, 0], [[0]], "0", None, 1j],
    "t_max": [np.zeros(5), True, {}],
    "threads": [-1, 1.5, None, 2**32],
    "packet": [-1, 257, 2.0],
    "visibility": [0, 16, -1, "all"],
}


@pytest.mark.parametrize(
    ("name", "value"), [(name, value) for name, values in BAD_RAYS.items() for value in values]
)
def test_bad_rays_name_the_argument(soup, name, value):
    arguments = {"origins": DOWN[0], "directions": DOWN[1], name: value}
    for trace in (soup.intersect, soup.occluded, soup.reference_intersect):
        if name != "packet" or trace != soup.reference_intersect:
            with pytest.raises(ValueError, match=rf"\b{name}\b"):
                trace(**arguments)


def test_no_rays_are_no_hits(soup):
    none = np.empty((0, 3))
    assert all(column.shape == (0,) for column in soup.intersect(none, none).values())
    assert soup.occluded(none, none.astype(np.float32), t_max=[]).shape == (0,)


# ---- Drops, ties, empty scenes and the tree ------------------------------------------------------


def test_dropped_triangles_keep_the_others_indices():
    positions = np.float32([*TRIANGLE, [nan, 0, 0], [inf, 0, 0], [2, 0, 0]])
    triangles = np.uint32([[3, 1, 2], [0, 1, 5], [1, 1, 2], [0, 4, 1], [0, 1, 2], [0, 0, 0]])
    scene = Scene()
    scene.add_mesh(TRIANGLE, ONE)
    mesh = scene.add_mesh(positions, triangles)
    for _ in range(2):
        scene.add_instance(mesh, np.eye(4))
    scene.add_instance(0, np.eye(4))
    stats = scene.build()
    assert stats["dropped"] == [{"mesh": 1, "non_finite": 4, "zero_area": 6}]
    assert (stats["dropped_non_finite"], stats["dropped_zero_area"], stats["triangles"]) == (
        4,
        6,
        3,
    )
    hits = scene.intersect(*DOWN)
    assert (hits["instance"], hits["triangle"]) == (0, 4)


def test_overflow_in_placing_drops_and_does_not_raise():
    stats = None
    scene = Scene()
    scene.add_mesh(TRIANGLE.astype(np.float64) * 1e300, ONE)
    scene.add_instance(0, np.eye(4))
    stats = scene.build()
    assert stats["dropped"] == [{"mesh": 0, "non_finite": 1, "zero_area": 0}]


def test_equal_t_goes_to_the_lowest_instance_and_triangle():
    scene = built(TRIANGLE, np.repeat(ONE, 5, axis=0), [np.eye(4)] * 3)
    for packet in (1, 0, 64):
        hits = scene.intersect(*(np.repeat(v, 64, axis=0) for v in DOWN), packet=packet)
        assert (hits["instance"] == 0).all() and (hits["triangle"] == 0).all()


def test_empty_scenes_are_valid():
    nothing = np.zeros((0, 3))
    for scene in (Scene(), built(nothing, nothing), built(nothing, nothing.astype(int))):
        scene.build()
        assert (scene.intersect(*rays(10))["instance"] == -1).all()
        assert not scene.occluded(*rays(10)).any()
        assert (scene.reference_intersect(*rays(10))["triangle"] == -1).all()
        assert len(scene.nodes()) == 0
        assert scene.triangles()["vertices"].shape == (0, 3, 3)
        assert scene.render(camera())["combined"].shape == (24, 32, 4)


def test_nodes_are_a_copy_of_the_tree(soup):
    nodes = soup.nodes()
    assert nodes.dtype.itemsize == 32
    assert nodes.dtype.names == ("bounds_min", "left_first", "bounds_max", "count")
    stats = soup.build()
    assert len(nodes) == stats["nodes"] <= 2 * stats["triangles"] - 1
    assert nodes["count"].sum() == stats["triangles"] == 2000
    inner = nodes[nodes["count"] == 0]
    children = np.sort(np.r_[inner["left_first"], inner["left_first"] + 1])
    np.testing.assert_array_equal(np.unique(children), children)
    nodes["count"] = 7
    assert (soup.nodes()["count"] != 7).any()


def test_triangles_come_in_leaf_order(soup):
    nodes, triangles = soup.nodes(), soup.triangles()
    leaf = nodes[nodes["count"] > 0]
    order = np.concatenate([np.arange(a, a + n) for a, n in leaf[["left_first", "count"]].tolist()])
    np.testing.assert_array_equal(np.sort(order), np.arange(2000))
    low = np.repeat(leaf["bounds_min"], leaf["count"], axis=0)
    high = np.repeat(leaf["bounds_max"], leaf["count"], axis=0)
    vertices = triangles["vertices"][order]
    assert (vertices >= low[:, None]).all() and (vertices <= high[:, None]).all()
    np.testing.assert_array_equal(np.sort(triangles["triangle"]), np.arange(2000))
    assert not triangles["instance"].any()


@pytest.mark.parametrize(
    ("name", "value"),
    [("threads", -1), ("threads", 0.5), ("bins", 1), ("bins", 65), ("bins", "many")]
    + [("max_leaf", 65), ("max_leaf", -1), ("traversal_cost", -1), ("traversal_cost", nan)]
    + [("traversal_cost", inf), ("traversal_cost", "high"), ("on_progress", 3)],
)
def test_bad_build_options_name_the_argument(name, value):
    with pytest.raises(ValueError, match=name.replace("_", "[_ ]")):
        Scene().build(**{name: value})
