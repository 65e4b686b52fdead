# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Preset: camera rays on a fixed range, to compare scenes by eye."""

import bpy

overlay = bpy.context.scene.whittle_overlay

overlay.metric = "NODES"
overlay.kinds = {"primary"}
overlay.range = "FIXED"
overlay.low = 0.0
overlay.high = 200.0
