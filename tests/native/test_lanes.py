# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How the lecture's packets fill vector lanes, against packets in Python, at every width."""

from typing import Any

import counting
import identity
import isa
import numpy as np
import pytest
import whittle_core
from cameras import perspective
from packets import SQUARE, Packet, from_probe

SIZE = (120, 75)
SETTINGS = {"mode": "lecture", "packet": 16, "max_depth": 0}
WIDTHS = {"sse4.2": 4, "avx2": 8, "avx512": 16}
NAMES = ("node_lanes", "node_lanes_used", "triangle_lanes", "triangle_lanes_used")


def staged(sun: bool) -> tuple[whittle_core.Scene, dict[str, Any], dict[str, Any]]:
    """The boxes, with a sun that they shade each other from, or in the dark."""
    scene, view = identity.SCENES["boxes"]()
    light = {"kind": "sun", "direction": (0.3, 0.5, -1.0), "intensity": (1, 1, 1)}
    scene.set_lights([light] if sun else [])
    return scene, scene.build(threads=1), perspective(*SIZE, **view)


def rendered(x: int, y: int, width: int, height: int, sun: bool) -> dict[str, Any]:
    """Statistics of a part of the picture."""
    scene, _, camera = staged(sun)
    return scene.render({**camera, "region": (x, y, x + width, y + height)}, SETTINGS)["stats"]


def expected(x: int, y: int, sun: bool) -> tuple[list[Packet], dict[int, tuple[int, ...]]]:
    """The packets of sixteen pixels in Python, one for rays of each kind, dominant axis and octant,
    and by width what their lanes did."""
    scene, built, camera = staged(sun)
    leaves = scene.triangles()
    probes = [scene.probe(camera, SETTINGS, x + dx, y + dy) for dx, dy in SQUARE]
    pairs = zip(leaves["instance"], leaves["triangle"], strict=True)
    row_of = {pair: row for row, pair in enumerate(pairs)}
    classes: dict[Any, tuple[list[counting.Ray], list[int]]] = {}
    for kind in ("primary", "shadow"):
        for probe in probes:
            for row in (row for row in probe if row["kind"] == kind):
                ray, above = from_probe(row, built), probe[row["parent"]]
                along = int(np.argmax(np.abs(ray.direction))), *(ray.direction < 0)
                rays, skips = classes.setdefault((kind, *along), ([], []))
                rays.append(ray)
                start = above["instance"], above["triangle"]  # what a shadow ray cannot hit
                skips.append(row_of[start] if kind == "shadow" else -1)
    made = []
    for (kind, *_), (rays, skips) in classes.items():
        made.append(Packet(scene.nodes(), leaves["vertices"], rays, skips, kind == "shadow"))
        made[-1].walk()
    return made, {width: lanes(made, width) for width in WIDTHS.values()}


def lanes(packets: list[Packet], width: int) -> tuple[int, ...]:
    rows = [
        [test.lanes(width) for packet in packets for test in getattr(packet, kind)]
        for kind in ("node_tests", "triangle_tests")
    ]
    return tuple(int(n) for row in rows for n in np.sum(row, axis=0))


@pytest.mark.parametrize("sun", [False, True])
def test_lanes_agree_with_packets_in_python(sun: bool) -> None:
    places = [(20, 4), (44, 8), (68, 44)]
    found = [expected(*place, sun) for place in places]
    shadows = [packet for packets, _ in found for packet in packets if packet.any_hit]
    assert bool(shadows) == sun
    if sun:
        ended = [np.isneginf(packet.best).mean() for packet in shadows]
        assert any(0 < share < 1 for share in ended), "rays that end idle in the lanes of others"
    for name in isa.ISAS:
        with isa.process(name) as run:
            for place, (packets, wanted) in zip(places, found, strict=True):
                stats = run(rendered, *place, 4, 4, sun)
                assert stats["packets"] == len(packets) and stats["lanes"] == WIDTHS[name]
                assert tuple(stats[key] for key in NAMES) == wanted[WIDTHS[name]], (name, place)


def test_wider_vectors_are_used_less() -> None:
    uses = []
    for name in isa.ISAS:
        with isa.process(name) as run:
            stats = run(rendered, 0, 0, *SIZE, True)
        uses.append([stats[NAMES[i + 1]] / stats[NAMES[i]] for i in (0, 2)])
        assert all(0 < use < 1 for use in uses[-1])
    assert uses == sorted(uses, reverse=True)


@pytest.mark.parametrize("mode", ["fast", "single"])
def test_other_modes_count_no_lanes(mode: str) -> None:
    scene, _, camera = staged(sun=True)
    stats = scene.render(camera, {"mode": mode, "passes": ("combined", "nodes")})["stats"]
    assert not any(stats[name] for name in NAMES) and stats["lanes"] in WIDTHS.values()
