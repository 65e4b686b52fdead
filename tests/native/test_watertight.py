# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed meshes seen from inside: no ray aimed at an edge or a vertex escapes, at any scale."""

import aim
import isa
import meshes
import numpy as np
import pytest
from stability_tools import scene_of
from stability_triangles import ASIDE

RAYS = 1_000_000
SCALES = (1e-3, 1.0, 1e4)
SHIFTS = (0.0, 1.0, 1e3, 1e5)  #: times the scale


def escapes(scale: float, shift: float, by: str, count: int) -> int:
    """Rays at edges and vertices that leave the sphere, from eight points inside it: all as the
    core traces them by default, and a quarter again as single rays."""
    place = scale * shift * ASIDE
    placed = meshes.icosphere(3, scale, place)
    if by == "vertices":
        scene, _ = scene_of(placed)
    else:
        scene, _ = scene_of(meshes.icosphere(3), matrices=[meshes.transform(scale, place)])
        world = meshes.icosphere(3)[0].astype(np.float64) * scale + place
        placed = (world, placed[1])
    random = np.random.default_rng(4)
    lost = 0
    for seed in range(8):
        eye = place + scale * random.uniform(-0.4, 0.4, 3)
        kind = ("edges", "vertices")[seed % 2]
        directions = aim.targets(placed, kind, count // 8, seed) - eye
        origins = np.tile(eye, (len(directions), 1))
        lost += int((scene.intersect(origins, directions)["triangle"] < 0).sum())
        quarter = scene.intersect(origins[::4], directions[::4], packet=1)
        lost += int((quarter["triangle"] < 0).sum())
    return lost


@pytest.mark.parametrize("by", ["vertices", "transform"])
@pytest.mark.parametrize("name", isa.ISAS)
def test_nothing_escapes(name: str, by: str) -> None:
    count = RAYS if name == isa.ISAS[-1] else RAYS // 8
    with isa.process(name) as run:
        found = {
            (scale, shift): run(escapes, scale, shift, by, count)
            for scale in SCALES
            for shift in SHIFTS
        }
    assert {where: lost for where, lost in found.items() if lost} == {}


def test_holes_are_seen() -> None:
    """The count is not 0 by construction: with one triangle less, rays escape."""
    positions, triangles = meshes.icosphere(3)
    whole = positions, triangles
    scene, _ = scene_of((positions, triangles[1:]))
    origins, directions = aim.from_point(whole, "edges", 100_000, (0.1, 0.0, 0.0))
    lost = int((scene.intersect(origins, directions)["triangle"] < 0).sum())
    assert 10 < lost < 1000
