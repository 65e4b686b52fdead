# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Menus of presets: those of the folder `presets` beside a module, and the user's own."""

from collections.abc import Callable, Sequence
from pathlib import Path

import bpy


def menu(classes: Sequence[type], beside: str) -> tuple[Callable[[], None], Callable[[], None]]:
    """Functions that register and unregister a menu's classes, and make its presets known;
    `beside`: the file of the module that they belong to."""
    path = str(Path(beside).parent)

    def register() -> None:
        for cls in classes:
            bpy.utils.register_class(cls)
        # Blender 4.2 shows only the user's own.
        if hasattr(bpy.utils, "register_preset_path"):
            bpy.utils.register_preset_path(path)

    def unregister() -> None:
        if hasattr(bpy.utils, "unregister_preset_path"):
            bpy.utils.unregister_preset_path(path)
        for cls in reversed(classes):
            bpy.utils.unregister_class(cls)

    return register, unregister
