# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Preset: who stands in others."""

import bpy

cost = bpy.context.window_manager.whittle_cost

cost.columns = {"WORK", "OVERLAP", "SAH"}
cost.sort = "OVERLAP"
cost.descending = True
