# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of materials: Blender's, turned into the core's lobes when first met."""

from typing import Any

import bpy

from ..notes import Notes, listed, plural
from .checks import finite
from .nodes import feeding, in_use, surface_input
from .shaders import SHARP_BELOW, Row, Surface, flat

DEFAULT: Row = {"diffuse": (0.8, 0.8, 0.8)}


class Table:
    """Rows of Scene.set_materials; each of Blender's materials has one."""

    def __init__(self, notes: Notes, override: bpy.types.Material | None) -> None:
        """`override`: the view layer's material, which takes the place of all others."""
        self.rows: list[Row] = []
        self.names: list[str] = []
        """Of each row's material; "": what a slot without one shows."""
        self._notes = notes
        self._override = override
        self._index: dict[int, int] = {}
        self._stale: set[int] = set()
        self._rough: list[str] = []
        self._glowing: list[str] = []

    def index(self, material: bpy.types.Material | None) -> int:
        """Row of a material; None is what a slot without one shows."""
        material = self._override or material
        # Not its address, which another material may have later.
        key = 0 if material is None else material.original.session_uid
        if key not in self._index:
            self._index[key] = len(self.rows)
            self.rows.append({})
            self.names.append("")
        elif key not in self._stale:
            return self._index[key]
        self._stale.discard(key)
        index = self._index[key]
        self.rows[index] = DEFAULT if material is None else self._row(material)
        self.names[index] = "" if material is None else material.name
        return index

    def forget(self) -> None:
        """Reads each material anew when it is next met; it keeps its row."""
        self._stale = set(self._index)
        self._rough.clear()
        self._glowing.clear()

    def _row(self, material: bpy.types.Material) -> Row:
        row = finite(f"Material '{material.name}'", self._read(material))
        reflects = any(any(row.get(lobe, ())) for lobe in ("mirror", "metal", "specular"))
        if reflects and row.get("roughness", 0.0) > 0.0:
            self._rough.append(material.name)
        if any(row.get("emission", ())):
            self._glowing.append(material.name)
        return row

    def _read(self, material: bpy.types.Material) -> Row:
        def note(line: str) -> None:
            self._notes.add(f"Material '{material.name}': {line}")

        if not in_use(material):
            return flat(material.diffuse_color, material.metallic, material.roughness)
        socket = surface_input(material.node_tree)
        if socket is None:
            note("it has no output node and is black")
            return {}
        source = feeding(socket, ())[0]
        if source is None:
            note("nothing feeds its surface, it is black")
            return {}
        _note_other_outputs(socket.node, note)
        return Surface(note).row(*source)

    def note_models(self) -> None:
        """Says once how rough reflections and glowing surfaces are drawn, if there are any."""
        for names, line in (
            (
                self._rough,
                f"Reflections rougher than {SHARP_BELOW} show only lights and the world's colour",
            ),
            (self._glowing, "Glowing surfaces are seen, but light nothing"),
        ):
            if names:
                self._notes.add(f"{line}: {plural(len(names), 'material')} ({listed(names)})")


def _note_other_outputs(output: bpy.types.Node, note: Any) -> None:
    for name in ("Volume", "Displacement"):
        if output.inputs[name].is_linked:
            note(f"{name} is left out")
