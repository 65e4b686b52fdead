# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays against the oracle and Embree, and the same bits by every way of tracing them."""

import hashlib

import agreement
import aim
import isa
import meshes
import numpy as np
import pytest
import whittle_core
from differences import against_oracle
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from stability_tools import differing, scene_of

RAYS = 1_000_000


@pytest.mark.parametrize("kind", aim.KINDS)
@pytest.mark.parametrize("name", agreement.SMALL)
def test_differences_are_explained(name: str, kind: str) -> None:
    counts = agreement.against_oracle(agreement.SMALL[name](), kind, RAYS)
    print(f"{name}, {kind}: {counts}")
    for tracer, classes in counts.items():
        assert sum(classes.values()) == RAYS
        assert classes["unexplained"] == 0, f"{tracer}: {classes}"
        assert classes["same"] > RAYS // 2, f"{tracer}: {classes}"


@pytest.mark.parametrize("name", agreement.LARGE)
def test_large_meshes(name: str) -> None:
    mesh = meshes.shared(name)
    if mesh is None:
        pytest.skip(f"{name}.obj is not beside the checkout")
    for kind in aim.KINDS:
        counts = agreement.between_tracers(mesh, kind, RAYS // 4, 1000)
        print(f"{name}, {kind}: {counts}")
        assert counts["unexplained"] == counts["unexplained_embree"] == 0, counts


def test_classes_catch_what_is_wrong() -> None:
    """Errors put in by hand are unexplained: another t, another triangle, a lost hit."""
    mesh = meshes.icosphere(2)
    rays = aim.from_around(mesh, "interior", 20_000)
    scene, stats = scene_of(mesh)
    right = scene.intersect(*rays)
    weight = np.min([right["u"], right["v"], 1 - right["u"] - right["v"]], axis=0)
    hit = np.flatnonzero((right["triangle"] >= 0) & (weight > 0.05))[::10]
    assert len(hit) > 100
    changes = {
        "t": {"t": right["t"][hit] * np.float32(1.001)},
        "triangle": {"triangle": (right["triangle"][hit] + 160) % 320},
        "lost": {"triangle": -1, "t": np.inf},
    }
    for name, change in changes.items():
        wrong = {key: values.copy() for key, values in right.items()}
        for key, values in change.items():
            wrong[key][hit] = values
        found = against_oracle(scene, stats, *rays, wrong)["unexplained"]
        assert found > 0.95 * len(hit), f"{name}: {found} of {len(hit)}"


WAYS = ((0, 0), (1, 1), (7, 3), (16, 2), (256, 7))  #: packet, threads


def digests(name: str, kind: str) -> set[str]:
    """All bits of the answers to some rays, by each way of tracing them."""
    mesh = SCENES[name]()
    rays = aim.from_around(mesh, kind, 20_000)
    scene, _ = scene_of(mesh)
    found = set()
    for packet, threads in WAYS:
        hits = scene.intersect(*rays, packet=packet, threads=threads)
        dark = scene.occluded(*rays, packet=packet, threads=threads)
        bits = b"".join(np.ascontiguousarray(hits[key]).tobytes() for key in sorted(hits))
        found.add(hashlib.sha256(bits + dark.tobytes()).hexdigest())
    return found


SCENES = {
    "boxes": meshes.boxes,
    "needle_fan": meshes.needle_fan,
    "duplicates": meshes.coplanar_duplicates,
    "triangles": lambda: meshes.random_triangles(4000, 0.1, 7),
}


@pytest.mark.parametrize("name", SCENES)
def test_same_bits_by_every_way(name: str) -> None:
    """Packet sizes, threads and instruction sets: one set of bits for each kind of rays."""
    seen: dict[str, set[str]] = {kind: set() for kind in aim.KINDS}
    for set_ in isa.ISAS:
        with isa.process(set_) as run:
            for kind, found in seen.items():
                found |= run(digests, name, kind)
    assert {kind: len(found) for kind, found in seen.items()} == dict.fromkeys(aim.KINDS, 1)


def test_occluded_is_whether_intersect_hits() -> None:
    mesh = meshes.random_triangles(2000, 0.1, 3)
    scene, _ = scene_of(mesh)
    origins, directions = aim.from_around(mesh, "edges", 100_000)
    limit = np.random.default_rng(1).uniform(0, 1.5, len(origins))
    hits = scene.intersect(origins, directions, t_max=limit)
    blocked = scene.occluded(origins, directions, t_max=limit)
    assert np.array_equal(blocked, hits["triangle"] >= 0)
    assert 0.1 < blocked.mean() < 0.9


def test_limits_of_t_are_half_open() -> None:
    """t_min is left out and t_max is part of the ray, to the last bit."""
    mesh = meshes.random_triangles(300, 0.3, 4)
    scene, _ = scene_of(mesh)
    rays = aim.from_around(mesh, "random", 20_000)
    first = scene.intersect(*rays)
    hit = first["triangle"] >= 0
    rays, t = (rays[0][hit], rays[1][hit]), first["t"][hit]
    again = scene.intersect(*rays, t_max=t)
    assert np.array_equal(again["t"], t)
    below = scene.intersect(*rays, t_max=np.nextafter(t, np.float32(0)))
    assert np.isinf(below["t"]).all()
    beyond = scene.intersect(*rays, t_min=t)
    assert (beyond["t"] > t).all()
    same = scene.intersect(*rays, t_min=np.nextafter(t, np.float32(0)))
    assert np.array_equal(same["t"], t)


@pytest.mark.parametrize("length", [1e-30, 1e-3, 3.0, 1e20])
def test_t_counts_in_lengths_of_the_direction(length: float) -> None:
    mesh = meshes.icosphere(2)
    scene, _ = scene_of(mesh)
    origins, directions = aim.from_around(mesh, "vertices", 5000)
    unit = directions.astype(np.float64)
    scaled = scene.intersect(origins.astype(np.float64), unit * 2.0 ** round(np.log2(length)))
    plain = scene.intersect(origins.astype(np.float64), unit)
    assert np.array_equal(scaled["triangle"], plain["triangle"])
    assert np.array_equal(scaled["t"] * np.float32(2.0 ** round(np.log2(length))), plain["t"])


def test_visibility_hides_from_the_oracle_as_well() -> None:
    scene = whittle_core.Scene()
    mesh = scene.add_mesh(*meshes.icosphere(1))
    scene.add_instance(mesh, np.eye(4), visibility=whittle_core.CAMERA)
    scene.add_instance(mesh, 3 * np.eye(4) - np.diag([0, 0, 0, 2]), visibility=whittle_core.SHADOW)
    scene.build()
    origins, directions = aim.from_around(meshes.icosphere(1, 5.0), "random", 5000)
    seen = scene.intersect(origins, directions, visibility=whittle_core.CAMERA)
    assert set(np.unique(seen["instance"])) == {-1, 0}
    other = scene.intersect(origins, directions, visibility=whittle_core.SHADOW)
    assert set(np.unique(other["instance"])) == {-1, 1}


floats = st.floats(-4, 4, width=32, allow_subnormal=True)


@given(
    arrays(np.float32, (6, 3, 3), elements=floats),
    arrays(np.float32, (8, 3), elements=floats),
    arrays(np.float32, (8, 3), elements=floats),
)
def test_any_triangles_and_rays(corners: np.ndarray, origins: np.ndarray, directions: np.ndarray):
    """Whatever comes in: packets are single rays, and what differs from the oracle is explained."""
    mesh = meshes.soup(corners)
    scene, stats = scene_of(mesh)
    single = scene.intersect(origins, directions, packet=1)
    assert differing(scene.intersect(origins, directions, packet=256), single) == 0
    aimed = np.abs(directions).max(axis=1) > 0
    assert (single["triangle"][~aimed] < 0).all()
    # Directions so short that t does not fit a float: there is nothing left of it to compare.
    told = aimed & (single["t"] != np.finfo(np.float32).max)
    parts = {key: values[told] for key, values in single.items()}
    classes = against_oracle(scene, stats, origins[told], directions[told], parts)
    assert classes["unexplained"] == 0, classes
