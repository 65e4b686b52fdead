# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Counters against an independent count over Scene.nodes(), and what they must add up to."""

import aim
import counting
import identity
import isa
import meshes
import numpy as np
import pytest
import whittle_core
from cameras import orthographic, perspective
from differences import rebase
from stability_tools import scene_of

KINDS = ("primary", "shadow", "reflection", "refraction")
COUNTERS = [
    f"{what}{kind}" for what in ("nodes", "triangles") for kind in ("", *map("_{}".format, KINDS))
]

SCENES = {
    "spheres": lambda: meshes.join(meshes.icosphere(2), meshes.icosphere(2, 0.5, (1.2, 0.1, 0.3))),
    "boxes": meshes.boxes,
    "needles": lambda: meshes.needles(200, 1.0, 1e-3, 5),
    "triangles": lambda: meshes.random_triangles(1500, 0.15, 6),
}


@pytest.mark.parametrize("leaf", [1, 8])
@pytest.mark.parametrize("name", SCENES)
def test_counts_agree_with_python(name: str, leaf: int) -> None:
    mesh = SCENES[name]()
    scene, stats = scene_of(mesh, max_leaf=leaf)
    nodes, corners = scene.nodes(), scene.triangles()["vertices"]
    visited_most = 0
    for kind in ("random", "edges"):
        rays = aim.from_around(mesh, kind, 120)
        hits = scene.intersect(*rays, counters=True)
        origin, direction, factor = rebase(stats, *rays)
        for i in range(len(origin)):
            ray = counting.make_ray(origin[i], direction[i])
            visited, tested, t = counting.trace(nodes, corners, ray)
            assert (hits["nodes"][i], hits["triangles"][i]) == (visited, tested), (kind, i)
            assert hits["t"][i] == np.float32(t * factor[i]), (kind, i)
            visited_most = max(visited_most, visited)
    assert visited_most > 10


def test_counting_changes_no_hit() -> None:
    mesh = meshes.boxes()
    scene, _ = scene_of(mesh)
    rays = aim.from_around(mesh, "edges", 50_000)
    counted, plain = scene.intersect(*rays, counters=True), scene.intersect(*rays)
    for key, values in plain.items():
        assert np.array_equal(values, counted[key]), key


def counted(name: str, **settings) -> dict:
    scene, view = identity.SCENES[name]()
    scene.build()
    camera = perspective(160, 100, **view)
    passes = (*identity.PASSES, *COUNTERS)
    return scene.render(camera, {"passes": passes, "samples": 4, **settings})


@pytest.mark.parametrize("name", ["spheres", "boxes", "duplicates"])
def test_image_is_the_same_with_counters(name: str) -> None:
    scene, view = identity.SCENES[name]()
    scene.build()
    camera = perspective(160, 100, **view)
    plain = scene.render(camera, {"passes": identity.PASSES, "samples": 4})
    assert identity.digest(plain) == identity.digest(counted(name))


def test_counters_add_up() -> None:
    """Kinds add up to all, pixels to the statistics; kinds without rays count nothing."""
    image = counted("spheres")
    stats = image["stats"]
    for what in ("nodes", "triangles"):
        parts = [image[f"{what}_{kind}"].astype(np.float64) for kind in KINDS]
        assert np.array_equal(sum(parts), image[what])
        for kind, part in zip(KINDS, parts, strict=True):
            assert part.sum() == stats[what][kind] > 0
    assert (image["nodes_primary"] >= 4).all(), "each of four rays visits the root"
    plain = counted("needle_fan", max_depth=0)
    assert plain["nodes_reflection"].sum() == plain["stats"]["rays"]["reflection"] == 0
    assert plain["nodes_refraction"].sum() == 0


def heat(threads: int, packet: int) -> bytes:
    image = counted("spheres", threads=threads, packet=packet)
    return b"".join(image[name].tobytes() for name in COUNTERS)


def test_heatmap_depends_on_the_scene_alone() -> None:
    """Instruction set, threads and packet size do not change a count."""
    found = set()
    for name in isa.ISAS:
        with isa.process(name) as run:
            found |= {run(heat, 1, 0), run(heat, 3, 16), run(heat, 2, 1024)}
    assert len(found) == 1


def test_builder_changes_the_heatmap() -> None:
    scene, view = identity.SCENES["boxes"]()
    camera = perspective(160, 100, **view)
    found = set()
    for leaf in (1, 8):
        scene.build(max_leaf=leaf)
        found.add(scene.render(camera, {"passes": ("nodes",)})["nodes"].tobytes())
    assert len(found) == 2


def test_shadow_rays_stop_at_the_first_hit() -> None:
    """Sheets above a floor in one leaf: a shadow ray tests the triangles up to the first sheet."""
    scene = whittle_core.Scene()
    scene.set_lights([{"kind": "sun", "direction": (0, 0, -1), "intensity": (1, 1, 1)}])
    big = np.float32([[-9, -9, 0], [9, -9, 0], [0, 15, 0]])
    for height in [0.0, *np.linspace(2, 4, 12)]:
        mesh = scene.add_mesh(big + np.float32([0, 0, height]), np.uint32([[0, 1, 2]]))
        scene.add_instance(mesh, np.eye(4))
    scene.build(max_leaf=64, traversal_cost=1e6)
    assert len(scene.nodes()) == 1
    order = list(scene.triangles()["instance"])
    first_sheet = next(i for i, instance in enumerate(order) if instance > 0)
    camera = orthographic(16, 16, (0, 0, 1), 1.0, near=0.0, far=10.0)
    image = scene.render(camera, {"passes": ("triangles_shadow", "nodes_shadow", "triangles")})
    assert (image["nodes_shadow"] == 1).all()
    assert (image["triangles_shadow"] == first_sheet + 1).all()
    assert (image["triangles"] == 13 + first_sheet + 1).all()
