# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What leaving out saves: each need of a scene with and without it, and the generic kernel."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from capture import Material, Recording, Shot
from error import progress

BLACK = (0.0, 0.0, 0.0)
ALL = 15  # every kind of ray

Change = Callable[[Recording], Recording]
Settings = dict[str, Any]


@dataclass
class Measured:
    """One scene under one kernel: wall time (s), memory (bytes), rays, and its picture's bits."""

    seconds: float
    bytes: int
    rays: int
    needs: list[str]
    kernel: list[str]
    picture: bytes


@dataclass
class Row:
    """A need: with it, without it, and without it under the kernel that leaves nothing out."""

    need: str
    on: Measured
    off: Measured
    generic: Measured

    @property
    def same(self) -> bool:
        return self.off.picture == self.generic.picture


def _materials(change: Callable[[Material], Material]) -> Change:
    return lambda scene: replace(scene, materials=[change(dict(row)) for row in scene.materials])


def _same(scene: Recording) -> Recording:
    return scene


def _matt(row: Material) -> Material:
    """What reflected sharply is diffuse, in the same colour."""
    metal = row.get("metal_weight", 0.0) * np.array(row.get("metal", BLACK))
    shine = metal + row.get("mirror", BLACK)
    diffuse = tuple(float(x) for x in shine + row.get("diffuse", BLACK))
    return row | {"mirror": BLACK, "metal_weight": 0.0, "specular": BLACK, "diffuse": diffuse}


def _opaque(row: Material) -> Material:
    return row | {"transmission": BLACK}


def _rough(row: Material) -> Material:
    """What reflected sharply has highlights instead."""
    return row | {"roughness": 0.3}


def _flat(scene: Recording) -> Recording:
    meshes = [(arguments, named | {"normals": None}) for arguments, named in scene.meshes]
    return replace(scene, meshes=meshes)


def _one_light(scene: Recording) -> Recording:
    return replace(scene, lights=scene.lights[:1])


def _seen_by_all(scene: Recording) -> Recording:
    instances = [(arguments, named | {"visibility": ALL}) for arguments, named in scene.instances]
    return replace(scene, instances=instances)


#: Need, the scene and settings that have it, the scene and settings that do not.
NEEDS: tuple[tuple[str, Change, Settings, Change, Settings], ...] = (
    ("mirror", _same, {}, _materials(_matt), {}),
    ("glass", _same, {}, _materials(_opaque), {}),
    ("smooth normals", _same, {}, _flat, {}),
    ("several lights", _same, {}, _one_light, {}),
    ("highlights", _materials(_rough), {}, _same, {}),
    ("counters", _same, {"passes": ("combined", "nodes")}, _same, {}),
    ("samples", _same, {"samples": 4}, _same, {"samples": 1}),
    ("ray visibility", _same, {}, _seen_by_all, {}),
)


def run(shot: Shot, rounds: int) -> Iterator[Row]:
    """A row for each need that the scene can be given; the others are said and skipped."""
    for need, with_it, on_settings, without, off_settings in NEEDS:
        progress(f"leaving out: {need}")
        on = _measure(shot, with_it, on_settings, rounds)
        if need not in on.needs:
            progress(f"leaving out: this scene has no {need}, the row is skipped")
            continue
        off = _measure(shot, without, off_settings, rounds)
        if need in off.needs:
            raise RuntimeError(f"{need} was taken out of the scene, but the core still needs it")
        generic = _measure(shot, without, off_settings | {"generic": True}, rounds)
        yield Row(need, on, off, generic)


def _measure(shot: Shot, change: Change, settings: Settings, rounds: int) -> Measured:
    scene = shot.scene(change)
    build = scene.build()
    chosen = shot.settings | {"samples": 1} | settings
    results = [scene.render(shot.camera, chosen) for _ in range(rounds)]
    stats = results[0]["stats"]
    return Measured(
        seconds=statistics.median(result["stats"]["seconds"] for result in results),
        bytes=build["bytes"] + stats["bytes"],
        rays=sum(stats["rays"].values()),
        needs=list(stats["needs"]),
        kernel=list(stats["kernel_needs"]),
        picture=results[0]["combined"].tobytes(),
    )
