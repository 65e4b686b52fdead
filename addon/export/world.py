# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The world's colour."""

from typing import Any

import bpy

from ..notes import Notes
from .nodes import Reader, feeding, in_use, surface_input

Color = tuple[float, float, float]
BLACK: Color = (0.0, 0.0, 0.0)


def export(scene: bpy.types.Scene, notes: Notes) -> dict[str, Any]:
    """The arguments of Scene.set_world: what rays see that leave the scene, and ambient light."""
    world = scene.world
    if world is None:
        return {"color": BLACK, "ambient": BLACK}
    color = _color(world, notes)
    # Cycles' own switches, which exist while it is enabled, say what the world lights.
    seen_by = getattr(world, "cycles_visibility", None)
    if seen_by is not None:
        hidden = [
            kind for kind in ("camera", "glossy", "transmission") if not getattr(seen_by, kind)
        ]
        for kind in hidden:
            notes.add(f"World '{world.name}': hiding it from {kind} rays is not understood")
    lights = scene.whittle.use_ambient and (seen_by is None or seen_by.diffuse)
    if lights and any(color):
        notes.add("The world lights diffuse surfaces evenly, without shadows")
    return {"color": color, "ambient": color if lights else BLACK}


def _color(world: bpy.types.World, notes: Notes) -> Color:
    if not in_use(world):
        return tuple(world.color)
    socket = surface_input(world.node_tree)
    source = None if socket is None else feeding(socket, ())[0]
    if source is None:
        return BLACK

    def note(line: str) -> None:
        notes.add(f"World '{world.name}': {line}")

    node = source[0].node
    if node.type not in ("BACKGROUND", "EMISSION"):
        note(f"node '{node.name}' ({node.bl_label}) is not understood, its plain colour is used")
        return tuple(world.color)
    reader = Reader(node, source[1], note)
    strength = reader.value("Strength", 1.0)
    return tuple(strength * channel for channel in reader.color("Color", 0.8))
