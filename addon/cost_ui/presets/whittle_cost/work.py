# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Preset: who makes the rays work."""

import bpy

cost = bpy.context.window_manager.whittle_cost

cost.columns = {"WORK", "NODES", "TESTS"}
cost.sort = "WORK"
cost.descending = True
