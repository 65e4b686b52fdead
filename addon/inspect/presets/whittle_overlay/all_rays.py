# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Preset: all the work of a pixel."""

import bpy

overlay = bpy.context.scene.whittle_overlay

overlay.metric = "BOTH"
overlay.kinds = {"primary", "shadow", "reflection", "refraction"}
overlay.range = "AUTO"
overlay.low = 0.0
overlay.high = 100.0
