# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shading against closed forms: Lambert, mirrors, Snell, Fresnel, total reflection, shadows."""

from typing import Any

import meshes
import numpy as np
import pytest
import whittle_core
from cameras import orthographic, perspective
from numpy.typing import NDArray

SIZE = (96, 64)


def plane(height: float = 0.0, half: float = 50.0, up: bool = True) -> meshes.Mesh:
    """A square of two triangles, its normal along z or against it."""
    corner = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
    positions = np.column_stack([corner, np.full(4, height)])
    order = [[0, 1, 2], [0, 2, 3]] if up else [[0, 2, 1], [0, 3, 2]]
    return meshes.pack(positions, np.array(order))


def scene_with(*parts: tuple[meshes.Mesh, dict], **more: Any) -> whittle_core.Scene:
    """One instance of each mesh with a material of its own."""
    scene = whittle_core.Scene()
    scene.set_materials([material for _, material in parts])
    for index, (mesh, _) in enumerate(parts):
        materials = np.full(len(mesh[1]), index, np.uint32)
        scene.add_instance(
            scene.add_mesh(*mesh, materials=materials), np.eye(4), object_id=index + 1
        )
    scene.set_lights(more.get("lights", []))
    scene.set_world(more.get("color", (0, 0, 0)), more.get("ambient", (0, 0, 0)))
    scene.build()
    return scene


def directions(camera: dict) -> NDArray[np.float64]:
    """Unit directions through the pixels' centres of a perspective camera, (h, w, 3)."""
    width, height = camera["width"], camera["height"]
    x = ((np.arange(width) + 0.5) / width * 2 - 1) / camera["projection"][0, 0]
    y = ((np.arange(height) + 0.5) / height * 2 - 1) / camera["projection"][1, 1]
    grid_x, grid_y = np.meshgrid(x, y)
    local = np.stack([grid_x, grid_y, -np.ones_like(grid_x)], axis=-1)
    world = local @ camera["to_world"][:3, :3].T
    return world / np.linalg.norm(world, axis=-1, keepdims=True)


def fresnel(cosine: NDArray, ior: float) -> NDArray:
    """Unpolarised reflectance of a dielectric for light that enters at index ratio `ior`."""
    sine2 = (1 - cosine**2) / ior**2
    inner = np.sqrt(np.maximum(1 - sine2, 0))
    across = (cosine - ior * inner) / (cosine + ior * inner)
    along = (ior * cosine - inner) / (ior * cosine + inner)
    return np.where(sine2 >= 1, 1.0, (across**2 + along**2) / 2)


def test_lambert_under_a_point_light() -> None:
    place, intensity = np.array([0.7, -0.4, 2.0]), np.array([10.0, 20.0, 5.0])
    light = {"kind": "point", "position": place, "intensity": intensity}
    albedo = np.array([0.8, 0.5, 0.2])
    scene = scene_with((plane(), {"diffuse": albedo}), lights=[light], ambient=(0.1, 0.2, 0.3))
    camera = perspective(*SIZE, (3, -4, 3), (0, 0, 0))
    image = scene.render(camera, {"passes": ("combined", "position", "normal", "depth")})
    way = directions(camera)
    t = -3 / way[..., 2]
    point = np.array([3, -4, 3]) + t[..., None] * way
    to_light = place - point
    distance2 = (to_light**2).sum(axis=-1)
    cosine = to_light[..., 2] / np.sqrt(distance2)
    want = albedo / np.pi * intensity * (cosine / distance2)[..., None]
    want = want + albedo * np.array([0.1, 0.2, 0.3])
    assert np.allclose(image["combined"][..., :3], want, rtol=1e-5)
    assert np.allclose(image["position"], point, atol=5e-5)
    assert np.array_equal(image["normal"], np.broadcast_to([0, 0, 1], image["normal"].shape))
    depth = t * (way @ -camera["to_world"][:3, 2])
    assert np.allclose(image["depth"][..., 0], depth, rtol=1e-5)
    assert (image["combined"][..., 3] == 1).all()


def test_sun_and_the_edge_of_a_shadow() -> None:
    """A square above the floor throws its shadow exactly where the sun's rays are cut off."""
    sun = np.array([0.5, 0.25, -1.0])
    light = {"kind": "sun", "direction": 7 * sun, "intensity": (2, 2, 2)}
    roof = plane(1.0, 0.5)
    scene = scene_with(
        (plane(), {"diffuse": (1, 1, 1)}), (roof, {"diffuse": (1, 1, 1)}), lights=[light]
    )
    camera = orthographic(200, 200, (0.5, 0.25, 0.5), 0.83, far=1.0)
    image = scene.render(camera)["combined"]
    at = ((np.arange(200) + 0.5) / 100 - 1) * 0.83
    x, y = np.meshgrid(at + 0.5, at + 0.25)
    dark = (np.abs(x - 0.5) < 0.5) & (np.abs(y - 0.25) < 0.5)
    cosine = 1 / np.linalg.norm(sun)
    assert np.allclose(image[..., 0], np.where(dark, 0, 2 * cosine / np.pi), rtol=1e-5)
    assert dark.any() and not dark.all()


@pytest.mark.parametrize("depth", [0, 1, 2, 5, 16, 64])
@pytest.mark.parametrize("reflectance", [0.5, 0.9, 0.99])
def test_parallel_mirrors_are_a_series(reflectance: float, depth: int) -> None:
    glow = {"mirror": (reflectance,) * 3, "emission": (1.0, 0.5, 0.25)}
    scene = scene_with((plane(0.0), glow), (plane(1.0, up=False), glow))
    camera = orthographic(8, 8, (0.1, 0.2, 0.5), 0.3, far=2.0)
    image = scene.render(camera, {"max_depth": depth, "cutoff": 0})
    want = sum(reflectance**k for k in range(depth + 1))
    assert np.allclose(image["combined"][..., 0], want, rtol=1e-5)
    assert np.allclose(image["combined"][..., 2], want / 4, rtol=1e-5)


@pytest.mark.parametrize("cutoff", [0.5, 0.01])
def test_cutoff_is_bounded_by_what_it_says(cutoff: float) -> None:
    """What dropped rays would have added stays below the weight that the statistics sum up."""
    glow = {"mirror": (0.9,) * 3, "emission": (1.0, 1.0, 1.0)}
    scene = scene_with((plane(0.0), glow), (plane(1.0, up=False), glow))
    camera = orthographic(8, 8, (0.1, 0.2, 0.5), 0.3, far=2.0)
    image = scene.render(camera, {"max_depth": 64, "cutoff": cutoff})
    exact = scene.render(camera, {"max_depth": 64, "cutoff": 0})
    lost = float((exact["combined"] - image["combined"])[..., 0].max())
    brightest = 1 / (1 - 0.9)
    assert 0 < lost <= image["stats"]["dropped_weight"] * brightest * 1.001
    assert image["stats"]["secondary_rays_left_out"] > 0


@pytest.mark.parametrize("ior", [1.1, 1.5, 2.4])
@pytest.mark.parametrize("below", [False, True])
def test_fresnel_at_one_surface(ior: float, below: bool) -> None:
    """Against a bright sky a glass plane shows 1 - F through it and F in it; from inside, beyond
    the critical angle, everything is reflected."""
    eye = (0.0, -2.0, -0.7) if below else (0.0, -2.0, 0.7)
    camera = perspective(*SIZE, eye, (0, 0, 0), half_width=1.5)
    cosine = np.abs(directions(camera)[..., 2])
    hit = (directions(camera)[..., 2] > 0) == below
    want = fresnel(cosine, 1 / ior if below else ior)
    clear = np.abs(want - 1) > 1e-3 if below else np.full(want.shape, True)
    glass = {"specular": (1, 0, 0), "transmission": (0, 1, 0), "ior": ior}
    scene = scene_with((plane(half=1e4), glass), color=(1, 1, 1))
    seen = scene.render(camera, {"max_depth": 1, "cutoff": 0})["combined"]
    hit &= cosine > 0.01
    total = hit & (want == 1)
    assert total.any() == below
    assert np.allclose(seen[hit & clear, 0], want[hit & clear], atol=2e-5)
    assert np.allclose(seen[hit & clear, 1], 1 - want[hit & clear], atol=2e-5)
    assert np.allclose(seen[total, 0], 1, atol=2e-2) and np.allclose(seen[total, 1], 0, atol=2e-2)
    assert np.count_nonzero(seen[total, 1]) <= 0.01 * np.count_nonzero(total)


def test_snell_through_a_slab() -> None:
    """A slab shifts what lies behind it by d sin a (1 - cos a / (n cos b)), and dims it by two
    passages; the backdrop tells by its colour where it was seen."""
    ior, thick = 1.5, 1.0
    cells = 400
    at = np.linspace(-8, 8, cells + 1)
    i = np.arange(cells)
    low, high = (
        np.stack([at[:-1], 0 * i - 20, 0 * i - 3], 1),
        np.stack([at[1:], 0 * i - 20, 0 * i - 3], 1),
    )
    tall = np.array([0.0, 40.0, 0.0])
    strips = np.stack([low, high, high + tall, low, high + tall, low + tall], axis=1).reshape(-1, 3)
    scene = whittle_core.Scene()
    glass = {"transmission": (1, 1, 1), "specular": (1, 1, 1), "ior": ior}
    backdrop = [{"emission": (1.0, (k + 0.5) / cells, 0.0)} for k in range(cells)]
    scene.set_materials([glass, *backdrop])
    for height, up in ((0.0, True), (-thick, False)):
        scene.add_instance(scene.add_mesh(*plane(height, up=up)), np.eye(4))
    mesh = scene.add_mesh(
        *meshes.pack(strips, np.arange(6 * cells)), materials=np.repeat(i + 1, 2).astype(np.uint32)
    )
    scene.add_instance(mesh, np.eye(4))
    scene.set_lights([])
    scene.set_world((0, 0, 0))
    scene.build()
    camera = perspective(*SIZE, (2.0, 0.0, 1.0), (0.0, 0.0, -1.0), half_width=0.5)
    image = scene.render(camera, {"max_depth": 2, "cutoff": 0})["combined"]
    way = directions(camera)
    cosine = -way[..., 2]
    inner = np.sqrt(1 - (1 - cosine**2) / ior**2)
    sideways = way[..., 0] / np.sqrt(1 - cosine**2)
    straight = 2.0 + (1.0 + 3.0 - thick) * way[..., 0] / cosine
    bent = thick * sideways * np.sqrt(1 - cosine**2) / ior / inner
    x = straight + bent
    seen = image[..., 1] / image[..., 0]
    assert np.abs(seen - (x + 8) / 16).max() < 0.51 / cells + 1e-4
    assert np.allclose(image[..., 0], (1 - fresnel(cosine, ior)) ** 2, atol=2e-5)
    assert np.abs((straight + thick * way[..., 0] / cosine) - x).max() > 20 * 16 / cells


def test_metal_follows_schlick() -> None:
    camera = perspective(*SIZE, (0.0, -2.0, 0.7), (0, 0, 0), half_width=1.5)
    way = directions(camera)
    cosine, hit = -way[..., 2], way[..., 2] < -0.01
    metal = np.array([0.9, 0.6, 0.3])
    material = {"metal": metal, "metal_weight": 0.5}
    scene = scene_with((plane(half=1e4), material), color=(1, 1, 1))
    seen = scene.render(camera, {"max_depth": 1, "cutoff": 0})["combined"][..., :3]
    want = 0.5 * (metal + (1 - metal) * ((1 - cosine) ** 5)[..., None])
    assert np.allclose(seen[hit], want[hit], atol=2e-5)


@pytest.mark.parametrize("samples", [4, 16, 64])
def test_coverage_of_an_edge(samples: int) -> None:
    """Alpha of pixels cut by a slanted edge is the covered share, as well as a grid can tell."""
    corner = np.array([[-5, -5, 0], [5, -5, 0], [5, 5.3, 0]])
    scene = scene_with((meshes.soup(corner[None]), {"emission": (1, 1, 1)}))
    camera = orthographic(40, 40, (0, 0, 1), 1.0, far=2.0)
    fine = scene.render(camera, {"samples": 4096, "transparent": True})["combined"][..., 3]
    alpha = scene.render(camera, {"samples": samples, "transparent": True})["combined"][..., 3]
    assert set(np.unique(fine)) > {0.0, 1.0}
    assert np.abs(alpha - fine).max() <= 1 / np.sqrt(samples)
    assert np.allclose(alpha * samples, np.round(alpha * samples), atol=1e-3)
    assert abs(alpha.mean() - fine.mean()) < 0.02
