# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the bins of each preset cost and bring: seconds of builds and rays, a table in Markdown."""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np
import whittle_core
from moving import place, torus
from numpy.typing import NDArray

BINS = {"Preview": 8, "Standard": 16, "Final": 64}
CUBE = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
Mesh = tuple[NDArray[np.float32], NDArray[np.uint32]]


def cubes(count: int) -> Mesh:
    """Small and large blocks strewn about, many of them in each other's way."""
    random = np.random.default_rng(5)
    middles = random.uniform(-1, 1, (count, 1, 3))
    sizes = 0.3 * random.random((count, 1, 3)) ** 4 + 0.002
    corners = middles + sizes * (np.stack(list(np.ndindex(2, 2, 2)))[None] - 0.5)
    quads = np.array(CUBE)
    faces = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    triangles = (8 * np.arange(count)[:, None, None] + faces[None]).reshape(-1, 3)
    return corners.reshape(-1, 3).astype(np.float32), triangles.astype(np.uint32)


def rings() -> whittle_core.Scene:
    random = np.random.default_rng(7)
    scene = whittle_core.Scene()
    mesh = scene.add_mesh(*torus(158))
    for _ in range(20):
        scene.add_instance(mesh, place(random, 1.0))
    return scene


def blocks() -> whittle_core.Scene:
    scene = whittle_core.Scene()
    scene.add_instance(scene.add_mesh(*cubes(15_000)), np.eye(4))
    return scene


def camera(distance: float) -> dict[str, Any]:
    """Looks at the origin from the front, a little from above."""
    to_world = np.eye(4)
    up, back = np.array([0.0, 0.96, -0.28]), np.array([0.0, 0.28, 0.96])
    to_world[:3, 1], to_world[:3, 2], to_world[:3, 3] = up, back, distance * back
    projection = np.zeros((4, 4))
    projection[0, 0], projection[1, 1] = 2.0, 3.2
    projection[2, 2], projection[2, 3], projection[3, 2] = -1.0, -0.02, -1.0
    return {"to_world": to_world, "projection": projection, "width": 640, "height": 400}


def measure(name: str, make: Any, rounds: int, threads: int) -> None:
    scene, view = make(), camera(5.0)
    scene.set_materials([{"diffuse": (0.4, 0.4, 0.4), "mirror": (0.5, 0.5, 0.5)}])
    scene.set_lights([{"kind": "sun", "direction": (0.4, -1, -0.6), "intensity": (2, 2, 2)}])
    settings = {"threads": threads, "max_depth": 4}
    found: dict[str, list[tuple[float, float]]] = {preset: [] for preset in BINS}
    for _ in range(rounds):
        for preset, bins in BINS.items():
            built = scene.build(threads=threads, bins=bins, lean=True)
            stats = scene.render(view, settings)["stats"]
            rays = sum(stats["rays"].values())
            found[preset].append((built["seconds"], stats["seconds"] / rays))
    for preset, bins in BINS.items():
        scene.build(bins=bins)
        counted = scene.render(view, settings | {"passes": ["nodes"]})["stats"]
        visits = sum(counted["nodes"].values()) / sum(counted["rays"].values())
        # The least of the rounds, which what else runs on the machine disturbs least.
        build, ray = (min(column) for column in zip(*found[preset], strict=True))
        totals = " | ".join(f"{build + count * ray:.2f}" for count in (1e6, 1e7, 1e8))
        print(
            f"| {name}, {built['triangles']:,} | {preset}, {bins} | {build * 1e3:.0f} "
            f"| {ray * 1e9:.0f} | {visits:.2f} | {totals} |"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--threads", type=int, default=1)
    arguments = parser.parse_args()
    print(
        "| scene, triangles | bins | build, ms | ns/ray | nodes/ray | 1 M rays, s | 10 M | 100 M |"
    )
    print("| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    for name, make in (("rings", rings), ("blocks", blocks)):
        measure(name, make, arguments.rounds, arguments.threads)


if __name__ == "__main__":
    main()
