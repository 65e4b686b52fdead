# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Preset: whose triangles are badly shaped."""

import bpy

cost = bpy.context.window_manager.whittle_cost

cost.columns = {"WORK", "FILL"}
cost.sort = "FILL"
cost.descending = False
