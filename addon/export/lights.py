# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's lights in the core's words: radiant intensity of points, irradiance of suns."""

from math import pi
from typing import Any

import bpy
import mathutils

from ..notes import Notes
from .nodes import Reader, feeding, in_use, surface_input


def export(ob: bpy.types.Object, matrix: mathutils.Matrix, notes: Notes) -> dict[str, Any]:
    """A row of Scene.set_lights for a light that stands where the matrix says."""
    light = ob.data
    row = {"shadow": light.use_shadow}
    if light.type == "SUN":
        row |= {"kind": "sun", "direction": tuple(-matrix.col[2].xyz)}
        share = 1.0
    else:
        row |= {"kind": "point", "position": tuple(matrix.translation)}
        # A lamp of power P shines P / (4 pi) into each steradian; a flat one P / pi straight ahead.
        share = 1 / pi if light.type == "AREA" else 1 / (4 * pi)
    row["intensity"] = tuple(share * channel for channel in _power(ob, notes))
    _note_what_is_missing(ob, notes)
    return row


def _power(ob: bpy.types.Object, notes: Notes) -> list[float]:
    """Energy by channel, with the exposure and temperature of newer Blenders."""
    light = ob.data
    scale = light.energy * 2.0 ** getattr(light, "exposure", 0.0)
    color = light.color
    if getattr(light, "use_temperature", False):
        color = [a * b for a, b in zip(color, light.temperature_color, strict=True)]
    factor = _node_strength(ob, notes)
    return [scale * a * b for a, b in zip(color, factor, strict=True)]


def _node_strength(ob: bpy.types.Object, notes: Notes) -> tuple[float, float, float]:
    """What the light's own nodes multiply its power with."""
    light = ob.data
    if not in_use(light):
        return (1.0, 1.0, 1.0)
    socket = surface_input(light.node_tree)
    source = None if socket is None else feeding(socket, ())[0]
    if source is None:
        return (0.0, 0.0, 0.0)

    def note(line: str) -> None:
        notes.add(f"Light '{ob.name}': {line}")

    node = source[0].node
    if node.type != "EMISSION":
        note(f"node '{node.name}' ({node.bl_label}) is not understood")
        return (1.0, 1.0, 1.0)
    reader = Reader(node, source[1], note)
    strength = reader.value("Strength", 1.0)
    return tuple(strength * channel for channel in reader.color("Color", 1.0))


def _note_what_is_missing(ob: bpy.types.Object, notes: Notes) -> None:
    light = ob.data
    if light.type in ("SPOT", "AREA"):
        notes.add(f"Light '{ob.name}': {light.type.lower()} lights are drawn as point lights")
    if light.type == "SUN":
        soft = light.angle > 0
    else:
        soft = light.type == "AREA" or light.shadow_soft_size > 0
    if soft:
        notes.add("Lights have no size here: their shadows are sharp")
    if not getattr(light, "normalize", True):
        notes.add(f"Light '{ob.name}': 'Normalize' counts as on")
