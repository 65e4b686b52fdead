# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own panels that apply to this engine: it is added to those that they show for."""

from collections.abc import Iterator

import bpy

ENGINE = "WHITTLE"

# Panels that Blender shows for any engine, but that have no part here.
NOT_HERE = {
    "DATA_PT_light",  # the fuller panel below takes its place
    "DATA_PT_preview",
    "DATA_PT_spot",
    "MATERIAL_PT_preview",
    "NODE_DATA_PT_light",
    "RENDER_PT_stereoscopy",
}
NOT_HERE_MODULES = {"bl_ui.properties_freestyle"}

# Panels that Blender shows for its own engines only, and that fit here as they are.
ALSO_HERE = {
    "DATA_PT_EEVEE_light",
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_surface",
    "NODE_DATA_PT_EEVEE_light",
}


def applying() -> Iterator[type[bpy.types.Panel]]:
    """The panels in which the engine takes part."""
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", ())
        general = "BLENDER_RENDER" in engines and panel.__name__ not in NOT_HERE
        if panel.__name__ in ALSO_HERE or (general and panel.__module__ not in NOT_HERE_MODULES):
            yield panel


def register() -> None:
    for panel in applying():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister() -> None:
    for panel in applying():
        panel.COMPAT_ENGINES.discard(ENGINE)
