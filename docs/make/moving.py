# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What moving one of many objects takes, by instance and as one tree: a table in Markdown."""

from __future__ import annotations

import argparse

import numpy as np
import whittle_core
from numpy.typing import NDArray

ROUNDS = 7


def torus(quads: int) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """A ring of quads x quads quads, two triangles each."""
    i, j = np.meshgrid(np.arange(quads), np.arange(quads), indexing="ij")
    a, b = 2 * np.pi * i / quads, 2 * np.pi * j / quads
    ring = 1 + 0.35 * np.cos(b)
    positions = np.stack([ring * np.cos(a), ring * np.sin(a), 0.35 * np.sin(b)], axis=-1)
    corner = [((i + p) % quads * quads + (j + q) % quads).ravel() for p, q in np.ndindex(2, 2)]
    triangles = np.stack([corner[k] for k in (0, 2, 3, 0, 3, 1)], axis=1)
    return positions.reshape(-1, 3).astype(np.float32), triangles.reshape(-1, 3).astype(np.uint32)


def place(random: np.random.Generator, reach: float) -> NDArray[np.float64]:
    matrix = np.diag([0.5, 0.5, 0.5, 1.0])
    matrix[:3, 3] = random.uniform(-reach, reach, 3)
    return matrix


def measure(objects: int, quads: int, threads: int) -> None:
    random = np.random.default_rng(7)
    scene = whittle_core.Scene()
    mesh = scene.add_mesh(*torus(quads))
    for _ in range(objects):
        scene.add_instance(mesh, place(random, 6.0))

    def least(label: str, moves: int, **build: bool) -> None:
        """The least of some rounds, which what else runs on the machine disturbs least."""
        found = []
        for round_ in range(ROUNDS):
            for _ in range(moves):
                scene.set_transform(round_ % objects, place(random, 5.0))
                stats = scene.build(threads=threads, **build)
            found.append(stats)
        best = min(found, key=lambda stats: stats["seconds"])
        own = best["seconds"] - best["seconds_join"]
        print(
            f"| {label} | {best['seconds'] * 1e3:.1f} | "
            + (f"{own * 1e3:.1f} | {best['seconds_join'] * 1e3:.1f} |" if build else "| |")
        )

    count = scene.build()["triangles"]
    print(f"{objects} objects, {count:,} triangles, threads: {threads}\n")
    print("| build after moving | ms | its own subtree, ms | the rest, ms |")
    print("| --- | ---: | ---: | ---: |")
    least("an object, one tree", 1)
    scene.build(by_instance=True)
    least("an object", 1, by_instance=True)
    least("the same object again", 3, by_instance=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--objects", type=int, default=20)
    parser.add_argument("--quads", type=int, default=158, help="along and around each ring")
    parser.add_argument("--threads", type=int, default=1)
    arguments = parser.parse_args()
    measure(arguments.objects, arguments.quads, arguments.threads)


if __name__ == "__main__":
    main()
