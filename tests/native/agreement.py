# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whittle and Embree against the oracle on the same rays, every difference counted by class."""

from collections.abc import Callable

import aim
import meshes
import numpy as np
from differences import EDGE, EDGE_EMBREE, classify, rebase, rows_of
from stability_tools import embree_scene, scene_of

#: Small enough for the oracle to take a million rays of each kind in seconds.
SMALL: dict[str, Callable[[], meshes.Mesh]] = {
    "icosphere": lambda: meshes.icosphere(2),
    "torus": lambda: meshes.torus(24, 10),
    "boxes": lambda: meshes.boxes(20),
}
#: Measuring models, where they lie beside the checkout.
LARGE = ("spot", "teapot", "stanford-bunny")


def against_oracle(mesh: meshes.Mesh, kind: str, count: int) -> dict[str, dict[str, int]]:
    """Counts by class of Whittle's and Embree's differences from the oracle."""
    rays = aim.from_around(mesh, kind, count)
    scene, stats = scene_of(mesh)
    hits, truth = scene.intersect(*rays), scene.reference_intersect(*rays)
    origin, direction, factor = rebase(stats, *rays)
    corners = scene.triangles()["vertices"]
    theirs = truth["t"] / factor, rows_of(scene, truth)
    whittle = hits["t"] / factor, rows_of(scene, hits)
    found = embree_scene(mesh, robust=False).run(*rays, output=True)
    names = {"instance": np.zeros(count, np.int32), "triangle": found["primID"].astype(np.int32)}
    embree = found["tfar"] / factor, rows_of(scene, names)
    return {
        "Whittle": classify(corners, origin, direction, whittle, theirs, EDGE),
        "Embree": classify(corners, origin, direction, embree, theirs, EDGE_EMBREE),
    }


def between_tracers(mesh: meshes.Mesh, kind: str, count: int, sample: int) -> dict[str, int]:
    """Whittle against Embree on many rays of a mesh too large for the oracle. The oracle is asked
    about the rays on which they differ, up to `sample` of them, and about as many others."""
    rays = aim.from_around(mesh, kind, count)
    scene, stats = scene_of(mesh)
    hits = scene.intersect(*rays)
    found = embree_scene(mesh, robust=False).run(*rays, output=True)
    differ = np.flatnonzero(hits["triangle"] != found["primID"])
    others = np.arange(0, count, max(count // sample, 1))
    asked = np.unique(np.concatenate([differ[:sample], others]))
    part = rays[0][asked], rays[1][asked]
    origin, direction, factor = rebase(stats, *part)
    truth = scene.reference_intersect(*part)
    theirs = truth["t"] / factor, rows_of(scene, truth)
    chosen = {name: values[asked] for name, values in hits.items()}
    whittle = chosen["t"] / factor, rows_of(scene, chosen)
    names = {
        "instance": np.zeros(len(asked), np.int32),
        "triangle": found["primID"][asked].astype(np.int32),
    }
    embree = found["tfar"][asked] / factor, rows_of(scene, names)
    corners = scene.triangles()["vertices"]
    counts = classify(corners, origin, direction, whittle, theirs, EDGE)
    other = classify(corners, origin, direction, embree, theirs, EDGE_EMBREE)
    return {
        "rays": count,
        "differ": len(differ),
        "asked": len(asked),
        "unexplained": counts["unexplained"],
        "unexplained_embree": other["unexplained"],
    }
