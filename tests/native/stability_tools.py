# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a case of the stability table is, and the tools that the cases share."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import whittle_core
from aim import Rays
from meshes import Mesh
from numpy.typing import NDArray


@dataclass(frozen=True)
class Result:
    """How many of `tried` failed. Of a case without a rate `tried` is 1."""

    failures: int
    tried: int
    note: str = ""  #: what was seen, for the table

    @property
    def per_million(self) -> float:
        return 1e6 * self.failures / max(self.tried, 1)


@dataclass(frozen=True)
class Case:
    """One row of the table. The functions take the number of rays to try."""

    number: str
    builds: str
    holds: str
    whittle: Callable[[int], Result]
    naive: Callable[[int], Result]
    culprit: str  #: name of the naive variant
    embree: Callable[[int, bool], Result] | None = None  #: rays, robust
    rate: bool = True  #: the naive variant fails so many times a million; else it just fails

    def sharp(self, result: Result) -> bool:
        """Whether the naive variant fails as often as a sharp test needs."""
        return result.per_million >= 1000 if self.rate else result.failures > 0


def scene_of(
    *meshes: Mesh, matrices: list[NDArray] | None = None, **options
) -> tuple[whittle_core.Scene, dict]:
    """A built scene with one instance of each mesh, and the build's stats."""
    scene = whittle_core.Scene()
    for i, (positions, triangles) in enumerate(meshes):
        mesh = scene.add_mesh(positions, triangles)
        scene.add_instance(mesh, matrices[i] if matrices else np.eye(4))
    return scene, scene.build(**options)


def misses(mesh: Mesh, rays: Rays, matrix: NDArray | None = None) -> Result:
    """Rays that hit nothing, by each packet size in turn."""
    scene, _ = scene_of(mesh, matrices=None if matrix is None else [matrix])
    lost = [int((scene.intersect(*rays, packet=p)["triangle"] < 0).sum()) for p in (0, 1, 256)]
    return Result(max(lost), len(rays[0]))


def embree_scene(mesh: Mesh, robust: bool):
    """The mesh in Embree, through embreex."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    scene = EmbreeScene(robust=robust)
    TriangleMesh(scene, mesh[0], mesh[1].astype(np.int32))
    return scene


def embree_misses(mesh: Mesh, rays: Rays, robust: bool) -> Result:
    """Rays that Embree lets through."""
    hit = embree_scene(mesh, robust).run(*rays)
    return Result(int((hit < 0).sum()), len(rays[0]))


def differing(a: dict[str, NDArray], b: dict[str, NDArray]) -> int:
    """Rays for which any number of two answers differs by a bit."""
    bad = np.zeros(len(a["t"]), bool)
    for name in ("t", "u", "v"):
        bad |= a[name].view(np.uint32) != b[name].view(np.uint32)
    return int((bad | (a["instance"] != b["instance"]) | (a["triangle"] != b["triangle"])).sum())
