# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The cost table's presets: those of the folder beside this file, and the user's own."""

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from .. import presets

FOLDER = "whittle_cost"
NAMES = ("columns", "sort", "descending")


class WHITTLE_COST_PT_presets(PresetPanel, bpy.types.Panel):
    bl_label = "Cost Table Presets"
    preset_subdir = FOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = "whittle.cost_preset_add"


class WHITTLE_OT_cost_preset_add(AddPresetBase, bpy.types.Operator):
    """Keep the columns of the cost table and their order as a preset, or remove one"""

    bl_idname = "whittle.cost_preset_add"
    bl_label = "Add Cost Table Preset"
    preset_menu = "WHITTLE_COST_PT_presets"
    preset_subdir = FOLDER
    preset_defines = ["cost = bpy.context.window_manager.whittle_cost"]
    preset_values = [f"cost.{name}" for name in NAMES]


CLASSES = (WHITTLE_COST_PT_presets, WHITTLE_OT_cost_preset_add)

register, unregister = presets.menu(CLASSES, __file__)
