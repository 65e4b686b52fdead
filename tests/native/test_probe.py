# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The probe of a pixel against the heatmap, the picture and an independent walk of the tree."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import counting
import identity
import meshes
import numpy as np
import pytest
import whittle_core
from cameras import orthographic, perspective

KINDS = ("primary", "shadow", "reflection", "refraction")
COUNTERS = [f"{what}_{kind}" for what in ("nodes", "triangles") for kind in KINDS]
SIZE = (160, 100)


def counts(rays: list[dict[str, Any]]) -> dict[str, int]:
    """The counters' values by name."""
    found = dict.fromkeys(COUNTERS, 0)
    for ray in rays:
        for what in ("nodes", "triangles"):
            found[f"{what}_{ray['kind']}"] += len(ray[what])
    return found


@pytest.fixture(scope="module")
def glass() -> tuple[whittle_core.Scene, dict[str, Any], dict[str, Any]]:
    """Mirrors and glass: the scene, its build's statistics and a camera."""
    scene, view = identity.spheres()
    stats = scene.build()
    assert stats["center"] == (0, 0, 0), "probed origins come back to the very floats"
    return scene, stats, perspective(*SIZE, **view)


@pytest.mark.parametrize(
    "more",
    [{}, {"pattern": "stratified", "seed": 3}, {"mode": "lecture", "threads": 3}, {"max_depth": 2}],
)
def test_sums_equal_the_heatmap(glass, more: dict) -> None:
    scene, _, camera = glass
    settings = {"passes": COUNTERS, "samples": 4, **more}
    image = scene.render(camera, settings)
    random = np.random.default_rng(9)
    kinds = set()
    for x, y in random.integers(0, SIZE, (20, 2)):
        rays = scene.probe({**camera, "region": (1, 2, 9, 9)}, settings, int(x), int(y))
        kinds |= {ray["kind"] for ray in rays}
        assert counts(rays) == {name: image[name][y, x, 0] for name in COUNTERS}, (x, y)
    assert kinds == set(KINDS)


def test_visits_agree_with_python(glass) -> None:
    """Node by node and triangle by triangle, in their order, from the ray alone."""
    scene, stats, camera = glass
    nodes, order = scene.nodes(), scene.triangles()
    corners, scale = order["vertices"], 2.0 ** stats["exponent"]
    rows = {key: i for i, key in enumerate(zip(order["instance"], order["triangle"], strict=True))}
    rays = [ray for pixel in ((100, 57), (40, 47)) for ray in scene.probe(camera, {}, *pixel)]
    rays += scene.probe(camera, {"samples": 4}, 77, 30)
    assert {ray["kind"] for ray in rays} == set(KINDS) and len(rays) > 40
    first = 0
    for i, ray in enumerate(rays):
        first = i if ray["parent"] < 0 and ray["sample"] == 0 else first
        parent = rays[first + ray["parent"]] if ray["parent"] >= 0 else None
        skip = rows[parent["instance"], parent["triangle"]] if parent else -1
        walked = counting.walk(
            nodes,
            corners,
            counting.make_ray(
                np.float32(ray["origin"] / scale),
                np.float32(ray["direction"] / scale),
                ray["t_min"],
                ray["t_max"],
            ),
            skip,
            ray["kind"] == "shadow",
        )
        assert walked.nodes == ray["nodes"].tolist(), i
        assert walked.triangles == ray["triangles"].tolist(), i
        assert walked.t == np.float32(ray["t"]), i
        hit = (ray["instance"], ray["triangle"])
        assert rows.get(hit, -1) == walked.row


def test_the_tree_of_rays_hangs_together(glass) -> None:
    scene, _, camera = glass
    for x, y in ((100, 57), (40, 47), (77, 30)):
        rays = scene.probe(camera, {"samples": 4}, x, y)
        assert [ray["sample"] for ray in rays if ray["kind"] == "primary"] == [0, 1, 2, 3]
        for i, ray in enumerate(rays):
            assert (ray["parent"] == -1) == (ray["kind"] == "primary") == (ray["t_min"] > 0)
            assert (ray["light"] >= 0) == (ray["kind"] == "shadow")
            if ray["parent"] < 0:
                assert ray["depth"] == 0
                continue
            parent = rays[ray["parent"]]
            assert ray["parent"] < i and parent["sample"] == ray["sample"]
            assert parent["kind"] != "shadow" and np.isfinite(parent["t"])
            assert ray["depth"] == parent["depth"] + (ray["kind"] != "shadow")
            start = parent["origin"] + parent["t"] * parent["direction"]
            assert np.allclose(start, ray["origin"], atol=1e-5)
        assert max(ray["depth"] for ray in rays) > 1


def test_rays_are_those_of_the_picture(glass) -> None:
    """Depth, object and position of the picture; shadow rays end at their lights."""
    scene, _, camera = glass
    passes = ("depth", "position", "object_index")
    image = scene.render(camera, {"passes": passes})
    lights = identity.LIGHTS
    materials = set()
    for x, y in np.random.default_rng(2).integers(0, SIZE, (30, 2)):
        rays = scene.probe(camera, None, int(x), int(y))
        primary = rays[0]
        if image["depth"][y, x, 0] == 1e10:
            assert np.isinf(primary["t"]) and np.isinf(primary["distance"]) and len(rays) == 1
            assert (primary["instance"], primary["triangle"], primary["material"]) == (-1, -1, -1)
            continue
        hit = primary["origin"] + primary["t"] * primary["direction"]
        assert np.allclose(hit, image["position"][y, x], atol=1e-5)
        reach = np.linalg.norm(hit - primary["origin"])
        assert primary["distance"] == pytest.approx(reach, rel=1e-9)
        assert image["object_index"][y, x, 0] == primary["material"] + 1
        materials.add(primary["material"])
        for ray in rays:
            if ray["kind"] != "shadow":
                continue
            light = lights[ray["light"]]
            if light["kind"] == "point":
                end = ray["origin"] + ray["direction"]
                assert np.allclose(end, light["position"], atol=1e-5)
                assert 0.99 < ray["t_max"] < 1
            else:
                assert np.cross(ray["direction"], light["direction"]) == pytest.approx(0, abs=1e-5)
                assert np.isinf(ray["t_max"])
    assert len(materials) >= 3


def test_far_from_the_origin_in_other_units() -> None:
    """Rays come back in world space, whatever scene space is."""
    place = np.eye(4) * 1000.0
    place[:, 3] = (1e6, -2e6, 500, 1)
    scene = whittle_core.Scene()
    mesh = scene.add_mesh(*meshes.box((-1, -1, -1), (1, 1, 1)))
    scene.add_instance(mesh, place)
    stats = scene.build()
    assert stats["exponent"] > 9 and any(stats["center"])
    camera = orthographic(8, 8, (1e6, -2e6, 4500), 500.0, far=1e4)
    (ray,) = scene.probe(camera, {}, 5, 2)
    assert ray["origin"] == pytest.approx((1e6 + 187.5, -2e6 - 187.5, 4500), abs=1e-3)
    assert ray["distance"] == pytest.approx(3000, rel=1e-6)
    assert ray["direction"][2] < 0 and abs(ray["direction"][:2]).max() == 0


def test_an_empty_scene_has_rays_that_visit_nothing() -> None:
    scene = whittle_core.Scene()
    scene.build()
    rays = scene.probe(perspective(8, 8, (0, -4, 0), (0, 0, 0)), {"samples": 4}, 0, 7)
    assert len(rays) == 4
    assert all(len(ray["nodes"]) == len(ray["triangles"]) == 0 for ray in rays)


def test_long_chains_fit(glass) -> None:
    """Thousands of rays, so that every list of the log grows and moves many times."""
    scene, _, camera = glass
    settings = {"samples": 1024, "cutoff": 0, "max_depth": 12, "passes": COUNTERS}
    rays = scene.probe(camera, settings, 100, 57)
    image = scene.render({**camera, "region": (100, 57, 101, 58)}, settings)
    assert len(rays) > 20_000
    assert counts(rays) == {name: image[name][0, 0, 0] for name in COUNTERS}


STARVED = """
import resource, sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
import identity
from cameras import perspective

scene, view = identity.spheres()
scene.build()
camera = perspective(160, 100, **view)
settings = {"samples": 4096, "cutoff": 0, "max_depth": 12}
scene.probe(camera, {}, 100, 57)
used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + 24_000_000, resource.RLIM_INFINITY))
try:
    scene.probe(camera, settings, 100, 57)
except MemoryError as error:
    print(error)
else:
    raise SystemExit("it went through")
resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY,) * 2)
assert len(scene.probe(camera, settings, 100, 57)) > 80_000
"""


def test_a_log_that_does_not_fit_is_a_memory_error() -> None:
    settings = {**os.environ, "MALLOC_ARENA_MAX": "1", "MALLOC_MMAP_THRESHOLD_": "65536"}
    command = [sys.executable, "-c", STARVED, str(Path(__file__).parent)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, env=settings)
    assert done.returncode == 0, done.stderr
    assert "max_depth" in done.stdout and "memory" in done.stdout


@pytest.mark.parametrize(
    ("x", "y", "name"), [(160, 0, "x"), (0, 100, "y"), (-1, 0, "x"), (0, 1.5, "y"), ("3", 0, "x")]
)
def test_pixels_outside_are_refused(glass, x: Any, y: Any, name: str) -> None:
    scene, _, camera = glass
    with pytest.raises(ValueError, match=rf"\b{name}\b"):
        scene.probe(camera, {}, x, y)


def test_bad_requests_say_what_is_wrong(glass) -> None:
    scene, _, camera = glass
    with pytest.raises(ValueError, match="samples"):
        scene.probe(camera, {"samples": 3}, 0, 0)
    with pytest.raises(ValueError, match="to_world"):
        scene.probe({**camera, "to_world": np.zeros((4, 4))}, {}, 0, 0)
    changed = whittle_core.Scene()
    with pytest.raises(RuntimeError, match="build"):
        changed.probe(camera, {}, 0, 0)
