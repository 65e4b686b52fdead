# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The heatmap's presets: those of the folder beside this file, and the user's own."""

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from .. import presets

FOLDER = "whittle_overlay"
NAMES = ("metric", "kinds", "node_weight", "triangle_weight", "colormap", "range", "low", "high")


class WHITTLE_VIEW_PT_presets(PresetPanel, bpy.types.Panel):
    bl_label = "Heatmap Presets"
    preset_subdir = FOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = "whittle.overlay_preset_add"


class WHITTLE_OT_overlay_preset_add(AddPresetBase, bpy.types.Operator):
    """Keep what the heatmap shows as a preset, or remove one"""

    bl_idname = "whittle.overlay_preset_add"
    bl_label = "Add Heatmap Preset"
    preset_menu = "WHITTLE_VIEW_PT_presets"
    preset_subdir = FOLDER
    preset_defines = ["overlay = bpy.context.scene.whittle_overlay"]
    preset_values = [f"overlay.{name}" for name in NAMES]


CLASSES = (WHITTLE_VIEW_PT_presets, WHITTLE_OT_overlay_preset_add)

register, unregister = presets.menu(CLASSES, __file__)
