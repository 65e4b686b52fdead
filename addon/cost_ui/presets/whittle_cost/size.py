# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Preset: who takes memory and build time."""

import bpy

cost = bpy.context.window_manager.whittle_cost

cost.columns = {"TRIANGLES", "MEMORY", "BUILD"}
cost.sort = "MEMORY"
cost.descending = True
