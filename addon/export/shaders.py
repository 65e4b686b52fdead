# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes as sums of the core's lobes."""

from collections.abc import Callable, Sequence
from math import sqrt
from typing import Any

import bpy

from .nodes import Groups, Reader, feeding

Row = dict[str, Any]
Color = tuple[float, float, float]

SHARP_BELOW = 0.1
"""Reflections up to this roughness are traced, as perfectly sharp ones."""

# Inputs that change nothing at these values, and are left out at others.
NEUTRAL = {
    "Alpha": 1.0,
    "Anisotropic": 0.0,
    "Anisotropy": 0.0,
    "Coat Weight": 0.0,
    "Diffuse Roughness": 0.0,
    "Sheen Weight": 0.0,
    "Subsurface Weight": 0.0,
    "Thin Film Thickness": 0.0,
    "Thin Wall": 0.0,
}


class Surface:
    """Turns the node that feeds a material's surface into a row of lobes."""

    def __init__(self, note: Callable[[str], None]) -> None:
        self._note = note

    def row(self, output: bpy.types.NodeSocket, groups: Groups) -> Row:
        """The lobes of the node with this output; something visible if it is not understood."""
        node = output.node
        shader = SHADERS.get(node.type)
        reader = Reader(node, groups, self._note)
        if shader is not None:
            _note_left_out(reader)
            return shader(reader)
        branches = [socket for socket in node.inputs if socket.type == "SHADER"]
        if branches:
            return self._branch(node, branches, groups)
        return self._fallback(reader)

    def _branch(
        self, node: bpy.types.Node, branches: Sequence[bpy.types.NodeSocket], groups: Groups
    ) -> Row:
        """A mixture: the first of its shaders that is understood stands for all of it."""
        sources = [source for socket in branches if (source := feeding(socket, groups)[0])]
        if not sources:
            self._note(f"nothing feeds node '{node.name}' ({node.bl_label}), it is black")
            return {}
        known = [source for source in sources if source[0].node.type in SHADERS]
        chosen = (known or sources)[0]
        self._note(
            f"node '{node.name}' ({node.bl_label}) is not understood, "
            f"'{chosen[0].node.name}' stands for it"
        )
        return self.row(*chosen)

    def _fallback(self, reader: Reader) -> Row:
        """A shader that is not understood: diffuse, in its own colour where it has one."""
        node = reader.node
        self._note(
            f"node '{node.name}' ({node.bl_label}) is not understood, it is drawn as diffuse"
        )
        name = "Base Color" if "Base Color" in node.inputs else "Color"
        return {"diffuse": reader.color(name, 0.8)}


def flat(color: Sequence[float], metallic: float, roughness: float) -> Row:
    """A material without nodes, by the colours that the viewport shows."""
    return _metal_and_plastic(
        color=tuple(color[:3]), metallic=metallic, roughness=roughness, transmission=0.0, ior=1.5
    )


def _diffuse(read: Reader) -> Row:
    if read.value("Roughness", 0.0) > 0.0:
        read.note(f"{read.node.bl_label}: Roughness is left out")
    return {"diffuse": read.color("Color", 0.8)}


def _glossy(read: Reader) -> Row:
    return {
        "mirror": read.color("Color", 0.8),
        "roughness": _roughness(read.value("Roughness", 0.0)),
    }


def _glass(read: Reader) -> Row:
    color = read.color("Color", 1.0)
    roughness = _roughness(read.value("Roughness", 0.0))
    if roughness > 0.0:
        read.note(f"{read.node.bl_label}: refraction is drawn sharp")
    return {
        "specular": color,
        "transmission": color,
        "ior": _index(read),
        "roughness": roughness,
    }


def _emission(read: Reader) -> Row:
    strength = read.value("Strength", 1.0)
    return {"emission": _scaled(strength, read.color("Color", 1.0))}


def _principled(read: Reader) -> Row:
    transmission = _share(read.value("Transmission Weight", 0.0))
    roughness = read.value("Roughness", 0.5)
    if transmission > 0.0 and roughness > SHARP_BELOW:
        read.note(f"{read.node.bl_label}: refraction is drawn sharp")
    level = max(0.0, read.value("Specular IOR Level", 0.5))
    tint = read.color("Specular Tint", 1.0)
    if transmission > 0.0 and level not in (0.0, 0.5):
        read.note(f"{read.node.bl_label}: Specular IOR Level is left out where it transmits")
    if tint != (1.0, 1.0, 1.0):
        read.note(f"{read.node.bl_label}: Specular Tint also tints at grazing angles")
    row = _metal_and_plastic(
        color=read.color("Base Color", 0.8),
        metallic=_share(read.value("Metallic", 0.0)),
        roughness=roughness,
        transmission=transmission,
        ior=_index(read),
        level=level,
        tint=tint,
    )
    strength = read.value("Emission Strength", 0.0)
    return row | {"emission": _scaled(strength, read.color("Emission Color", 1.0))}


SHADERS: dict[str, Callable[[Reader], Row]] = {
    "BSDF_DIFFUSE": _diffuse,
    "BSDF_GLOSSY": _glossy,
    "BSDF_GLASS": _glass,
    "BSDF_PRINCIPLED": _principled,
    "EMISSION": _emission,
}


def _metal_and_plastic(
    *,
    color: Color,
    metallic: float,
    roughness: float,
    transmission: float,
    ior: float,
    level: float = 0.5,
    tint: Color = (1.0, 1.0, 1.0),
) -> Row:
    """Metal, glass and plastic side by side, by their shares."""
    rest = 1.0 - metallic
    if level == 0.0:
        # The opaque share reflects nothing, the glass share as ever.
        tint = _scaled(transmission, tint)
    elif transmission == 0.0 and level != 0.5:
        ior = _leveled(ior, level)
    return {
        "metal": color if metallic > 0.0 else (0.0, 0.0, 0.0),
        "metal_weight": metallic,
        "specular": _scaled(rest, tint),
        "transmission": tuple(rest * transmission * sqrt(max(0.0, c)) for c in color),
        "diffuse": _scaled(rest * (1.0 - transmission), color),
        "ior": ior,
        "roughness": _roughness(roughness),
    }


def _leveled(ior: float, level: float) -> float:
    """The index whose reflectance at normal incidence is 2 level times that of `ior`."""
    reflectance = min(0.99, 2.0 * level * ((ior - 1.0) / (ior + 1.0)) ** 2)
    return (1.0 + sqrt(reflectance)) / (1.0 - sqrt(reflectance))


def _roughness(value: float) -> float:
    return 0.0 if value <= SHARP_BELOW else min(value, 1.0)


def _index(read: Reader) -> float:
    """The index of refraction; Cycles takes none below this either."""
    return max(1e-5, read.value("IOR", 1.5))


def _share(value: float) -> float:
    return min(1.0, max(0.0, value))


def _scaled(factor: float, color: Color) -> Color:
    return tuple(factor * channel for channel in color)


def _note_left_out(read: Reader) -> None:
    label = read.node.bl_label
    for name, neutral in NEUTRAL.items():
        if read.linked(name) or read.value(name, neutral) != neutral:
            read.note(f"{label}: {name} is left out")
    if read.linked("Normal"):
        read.note(f"{label}: Normal is left out")
