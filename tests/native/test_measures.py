# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The passes leaf_depth, coherence and seconds, against the probe, a packet in Python, a clock."""

from typing import Any

import counting
import identity
import isa
import meshes
import numpy as np
import pytest
import whittle_core
from cameras import perspective
from packets import SQUARE, Packet, from_probe

SIZE = (120, 75)
LECTURE = {"mode": "lecture", "passes": ("coherence",)}


def placed(name: str) -> tuple[whittle_core.Scene, dict[str, Any]]:
    scene, view = identity.SCENES[name]()
    scene.build()
    return scene, perspective(*SIZE, **view)


# ---- Depth of leaves -----------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["spheres", "boxes"])
def test_leaf_depth_is_that_of_the_deepest_leaf_probed(name: str) -> None:
    scene, camera = placed(name)
    nodes = scene.nodes()
    depths = np.where(nodes["count"] > 0, counting.node_depths(nodes), 0)
    image = scene.render(camera, {"passes": ("leaf_depth",), "samples": 4})["leaf_depth"]
    assert image.max() <= depths.max()
    for x, y in np.random.default_rng(5).integers(0, SIZE, (40, 2)):
        rays = scene.probe(camera, {"samples": 4}, int(x), int(y))
        deepest = max(depths[ray["nodes"]].max(initial=0) for ray in rays)
        assert image[y, x, 0] == deepest, (x, y)
    assert len(np.unique(image)) > 5


def test_no_leaf_is_depth_0() -> None:
    scene = whittle_core.Scene()
    scene.add_instance(scene.add_mesh(*meshes.icosphere(1)), np.eye(4))
    scene.build()
    image = scene.render(perspective(8, 8, (0, -4, 0), (9, -4, 0)), {"passes": ("leaf_depth",)})
    assert not image["leaf_depth"].any()
    assert "counters" in image["stats"]["needs"]


# ---- Coherence -----------------------------------------------------------------------------------


@pytest.mark.parametrize(("x", "y"), [(33, 21), (50, 30), (70, 44)])
def test_coherence_agrees_with_a_packet_in_python(x: int, y: int) -> None:
    """Sixteen rays of a square of pixels, in Z order."""
    scene, view = identity.SCENES["boxes"]()
    scene.set_lights([])
    stats = scene.build()
    camera = perspective(*SIZE, **view)
    settings = {**LECTURE, "packet": 16, "max_depth": 0}
    image = scene.render({**camera, "region": (x, y, x + 4, y + 4)}, settings)
    assert image["stats"]["packets"] == 1
    assert len(np.unique(image["coherence"])) == 1
    rays = [scene.probe(camera, settings, x + dx, y + dy)[0] for dx, dy in SQUARE]
    corners = scene.triangles()["vertices"]
    packet = Packet(scene.nodes(), corners, [from_probe(ray, stats) for ray in rays])
    share = packet.walk()
    assert 0.3 < share < 1
    assert image["coherence"][0, 0, 0] == np.float32(share)


def test_one_packet_has_the_share_of_the_statistics() -> None:
    scene, camera = placed("spheres")
    scene.set_lights([])
    region = {**camera, "region": (48, 32, 64, 48)}
    image = scene.render(region, {**LECTURE, "packet": 256, "max_depth": 0})
    stats = image["stats"]
    assert stats["packets"] == 1 and stats["visited_rays"] > 0
    share = np.float32(stats["active_rays"] / stats["visited_rays"])
    assert (image["coherence"] == share).all()


def test_scattered_rays_lower_the_coherence() -> None:
    scene, camera = placed("spheres")
    straight = scene.render(camera, {**LECTURE, "max_depth": 0})["coherence"]
    scattered = scene.render(camera, LECTURE)["coherence"]
    assert (straight >= 0).all() and (straight <= 1).all()
    assert scattered.mean() < straight.mean()


def coherence_bytes(threads: int, passes: tuple[str, ...]) -> bytes:
    scene, camera = placed("spheres")
    settings = {"mode": "lecture", "passes": passes, "samples": 4, "threads": threads}
    return scene.render(camera, settings)["coherence"].tobytes()


def test_coherence_depends_on_the_scene_alone() -> None:
    """Not on instruction sets and threads, nor on whether rays are counted as well."""
    found = {coherence_bytes(1, ("coherence",))}
    for name in isa.ISAS:
        with isa.process(name) as run:
            found.add(run(coherence_bytes, 3, ("coherence",)))
            found.add(run(coherence_bytes, 2, ("coherence", "nodes", "combined")))
    assert len(found) == 1


@pytest.mark.parametrize("name", ["spheres", "duplicates", "grazed_sheets"])
def test_all_together_keep_the_bits(name: str) -> None:
    """Picture, counts and the lecture's statistics are as each render by itself has them."""
    scene, camera = placed(name)
    lecture = {"mode": "lecture", "samples": 4}
    counters = ("nodes", "triangles_shadow")
    passes = (*identity.PASSES, *counters, "leaf_depth", "coherence", "seconds")
    together = scene.render(camera, {**lecture, "passes": passes, "cost": True})
    plain = scene.render(camera, {**lecture, "passes": identity.PASSES})
    counted = scene.render(camera, {"samples": 4, "passes": counters})
    assert identity.digest(together) == identity.digest(plain)
    for counter in counters:
        np.testing.assert_array_equal(together[counter], counted[counter])
    for number in ("rays", "packets", "decided_first", "active_rays", "own_box_misses"):
        assert together["stats"][number] == plain["stats"][number], number
    assert together["stats"]["packets"] > 0


def test_without_packets_nothing_is_wasted() -> None:
    scene, camera = placed("boxes")
    assert (scene.render(camera, {**LECTURE, "packet": 1})["coherence"] == 1).all()
    scene = whittle_core.Scene()
    scene.build()
    assert (scene.render(camera, LECTURE)["coherence"] == 1).all()


@pytest.mark.parametrize("mode", ["fast", "single"])
def test_coherence_is_refused_where_there_is_none(mode: str) -> None:
    scene, camera = placed("boxes")
    with pytest.raises(ValueError, match=r"passes: coherence .* lecture mode"):
        scene.render(camera, {"mode": mode, "passes": ("nodes", "coherence")})


# ---- Time ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("passes", [("seconds",), ("seconds", "nodes")])
def test_seconds_add_up_to_the_time_spent(passes: tuple[str, ...]) -> None:
    scene, camera = placed("spheres")
    image = scene.render(camera, {"passes": passes, "samples": 4, "threads": 2})
    stats, seconds = image["stats"], image["seconds"][..., 0].astype(np.float64)
    parts = ("primary", "shadow", "secondary", "shade")
    spent = sum(stats[f"seconds_{part}"] for part in parts)
    assert (seconds > 0).all()
    assert seconds.sum() == pytest.approx(spent, rel=1e-4)
    assert seconds.sum() <= 2 * stats["seconds"] * 1.001
    for y in range(0, SIZE[1], 16):
        for x in range(0, SIZE[0], 16):
            assert len(np.unique(seconds[y : y + 16, x : x + 16])) == 1, "one number a tile"
    assert len(np.unique(seconds)) > 10
    assert ("counters" in stats["needs"]) == (len(passes) > 1), "time alone counts nothing"
