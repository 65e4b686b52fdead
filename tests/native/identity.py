# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes whose images must not depend on how they are made, and the ways of making them."""

import hashlib
from collections.abc import Callable, Iterator
from typing import Any

import meshes
import numpy as np
import whittle_core
from cameras import perspective

PASSES = ("combined", "depth", "position", "normal", "object_index")
DIFFUSE = {"diffuse": (0.7, 0.5, 0.3)}
MIRROR = {"mirror": (0.8, 0.8, 0.8), "diffuse": (0.1, 0.1, 0.1)}
GLASS = {"specular": (1, 1, 1), "transmission": (1, 1, 1), "ior": 1.5}
BLUE = {"diffuse": (0.1, 0.2, 0.8), "mirror": (0.2, 0.2, 0.2)}
LIGHTS = [
    {"kind": "point", "position": (2.0, -2.5, 3.0), "intensity": (30, 30, 30)},
    {"kind": "sun", "direction": (-0.4, 0.3, -1.0), "intensity": (1, 1, 0.8)},
]
Placed = tuple[whittle_core.Scene, dict[str, Any]]


def lit(materials: list[dict]) -> whittle_core.Scene:
    scene = whittle_core.Scene()
    scene.set_materials(materials)
    scene.set_lights(LIGHTS)
    scene.set_world((0.3, 0.4, 0.6), (0.05, 0.05, 0.05))
    return scene


def add(scene: whittle_core.Scene, mesh: meshes.Mesh, material: int = 0, **more: Any) -> None:
    materials = np.full(len(mesh[1]), material, np.uint32)
    index = scene.add_mesh(*mesh, materials=materials, **more)
    scene.add_instance(index, np.eye(4), object_id=material + 1)


def spheres() -> Placed:
    """Mirror and glass spheres with smooth normals over a checkered floor."""
    scene = lit([DIFFUSE, MIRROR, GLASS, BLUE])
    for material, center in ((1, (-0.8, 0.3, 0.0)), (2, (0.5, -0.7, 0.1)), (3, (0.9, 1.0, -0.2))):
        ball = meshes.icosphere(3, 0.6, center)
        normals = (ball[0] - np.float32(center)) / np.float32(0.6)
        add(scene, ball, material, normals=normals)
    x, y = np.meshgrid(*[np.linspace(-4, 4, 17)] * 2, indexing="ij")
    i, j = np.meshgrid(*[np.arange(16)] * 2, indexing="ij")
    a = (i * 17 + j).ravel()
    floor = np.stack([x, y, np.full_like(x, -0.6)], axis=-1)
    for colour in (0, 1):
        own = a[((i + j) % 2 == colour).ravel()]
        quads = np.stack([own, own + 17, own + 18, own, own + 18, own + 1], axis=1)
        add(scene, meshes.pack(floor, quads), 3 * colour)
    return scene, {"eye": (2.6, -3.2, 1.6), "target": (0, 0, -0.1)}


def boxes() -> Placed:
    """Boxes whose faces lie in each other, seen so that edges fall on pixels."""
    scene = lit([DIFFUSE, MIRROR])
    add(scene, meshes.boxes(60), 0)
    add(scene, meshes.box((-1.5, -1.5, -1.2), (1.5, 1.5, -1.0)), 1)
    return scene, {"eye": (2.5, -3.0, 1.8), "target": (0, 0, 0)}


def needle_fan() -> Placed:
    """Needles of 1 : 1e6 and wider ones, whose boxes overlap all over, at grazing angles."""
    scene = lit([DIFFUSE, BLUE])
    add(scene, meshes.needle_fan(300, 1e-6), 0)
    add(scene, meshes.needle_fan(300, 2e-3), 1)
    return scene, {"eye": (0.6, -0.8, 0.02), "target": (0, 0, 0)}


def grazed_sheets(seed: int = 7) -> Placed:
    """Rows of small triangles, one behind the other along a pixel's ray and all but parallel to it:
    the distance to a plane is off by more than the triangles' size and their steps."""
    view = {"eye": (0.3, -3.0, 0.7), "target": (0, 0, 0)}
    camera = perspective(160, 100, **view)
    random = np.random.default_rng(seed)
    rows, each, size, cosine = 4000, 10, 3e-3, 1e-5
    pixel = random.permutation(160 * 100)[:rows]
    plane = np.stack([(pixel % 160 + 0.5) / 80 - 1, (pixel // 160 + 0.5) / 50 - 1], axis=1)
    local = np.column_stack([plane / np.diag(camera["projection"])[:2], -np.ones(rows)])
    ray = local @ camera["to_world"][:3, :3].T
    ray /= np.linalg.norm(ray, axis=1, keepdims=True)
    across = np.cross(ray, random.normal(size=ray.shape))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    along = ray + cosine * np.cross(ray, across)
    depth = random.uniform(2.4, 3.6, (rows, 1)) + 0.3 * size * np.arange(each)
    centre = np.float64(view["eye"]) + depth[..., None] * ray[:, None]
    turn = random.uniform(0, 2 * np.pi, (rows, each, 1, 1)) + np.radians([[0], [120], [240]])
    flat = np.cos(turn) * along[:, None, None] + np.sin(turn) * across[:, None, None]
    corners = centre[:, :, None] + size * flat
    scene = lit([DIFFUSE, BLUE])
    for material in (0, 1):
        add(scene, meshes.soup(corners[:, material::2]), material)
    return scene, view


def duplicates() -> Placed:
    """Coplanar copies of one grid, and coplanar grids of other cells, in two materials and more."""
    scene = lit([DIFFUSE, BLUE, MIRROR])
    for material in (0, 1, 2):
        grid = meshes.coplanar_duplicates(1 + material)
        random = np.random.default_rng(material)
        add(scene, (grid[0], random.permutation(grid[1])), material)
    for material, cells in ((2, 5), (1, 8), (0, 13)):
        positions, triangles = meshes.coplanar_duplicates(1, cells)
        flat = positions * np.float32([0.7, 0.7, 0]) + np.float32([0, 0, 0.9])
        add(scene, (flat, triangles), material)
    return scene, {"eye": (0.5, -2.5, 2.0), "target": (0, 0, 0)}


def pixel_net() -> Placed:
    """A net whose vertices lie on the rays through every third pixel's centre, at random depths."""
    view = {"eye": (0.3, -3.0, 0.7), "target": (0, 0, 0)}
    camera = perspective(160, 100, **view)
    x = (np.arange(0, 160, 3) + 0.5) / 80 - 1
    y = (np.arange(0, 100, 3) + 0.5) / 50 - 1
    j, i = np.meshgrid(np.arange(len(y)), np.arange(len(x)), indexing="ij")
    scale = np.diag(camera["projection"])[:2]
    depth = np.random.default_rng(21).uniform(2, 4, i.shape)
    local = np.stack([x[i] / scale[0], y[j] / scale[1], -np.ones_like(depth)], axis=-1)
    world = (depth[..., None] * local) @ camera["to_world"][:3, :3].T + camera["to_world"][:3, 3]
    a = (j * len(x) + i)[:-1, :-1].ravel()
    quads = np.stack([a, a + 1, a + len(x) + 1, a, a + len(x) + 1, a + len(x)], axis=1)
    scene = lit([DIFFUSE, MIRROR])
    add(scene, meshes.pack(world, quads), 0)
    return scene, view


SCENES: dict[str, Callable[[], Placed]] = {
    "spheres": spheres,
    "boxes": boxes,
    "needle_fan": needle_fan,
    "grazed_sheets": grazed_sheets,
    "duplicates": duplicates,
    "pixel_net": pixel_net,
}


def digest(image: dict[str, Any]) -> str:
    """All bits of the passes."""
    bits = b"".join(np.ascontiguousarray(image[name]).tobytes() for name in PASSES)
    return hashlib.sha256(bits).hexdigest()[:16]


def ways() -> Iterator[dict[str, Any]]:
    """Settings that must not change a bit: modes and packet sizes, with numbers of threads."""
    threads = (1, 2, 3, 7)
    for packet in (0, 16, 64, 256, 1024):
        for count in threads:
            yield {"mode": "fast", "packet": packet, "threads": count}
        yield {"mode": "lecture", "packet": packet, "threads": threads[packet % 3]}
    yield {"mode": "single", "threads": 1}
    yield {"mode": "fast", "generic": True}
    yield {"mode": "fast"}


def digests(name: str, size: tuple[int, int] = (160, 100), brief: bool = False) -> dict[str, str]:
    """Digest of the image by each way and builder setting; the ways that make it, by words."""
    scene, view = SCENES[name]()
    camera = perspective(*size, **view)
    found = {}
    for bins, leaf in ((8, 8), (16, 4), (32, 1)):
        scene.build(bins=bins, max_leaf=leaf)
        for number, way in enumerate(ways()):
            if brief and number % 4:
                continue
            image = scene.render(camera, {"passes": PASSES, "samples": 1, **way})
            misses = image["stats"]["own_box_misses"]
            found[f"bins {bins}, {way}"] = digest(image) + (f", {misses} outside" if misses else "")
    return found


def full_size(name: str) -> dict[str, str]:
    """A frame of 1280x800 by a few ways."""
    scene, view = SCENES[name]()
    camera = perspective(1280, 800, **view)
    found = {}
    for bins, way in ((8, {"threads": 1}), (32, {"packet": 16, "threads": 3})):
        scene.build(bins=bins)
        image = scene.render(camera, {"passes": PASSES, "samples": 1, **way})
        found[f"bins {bins}, {way}"] = digest(image)
    return found
