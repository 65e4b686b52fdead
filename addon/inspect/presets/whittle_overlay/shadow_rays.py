# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Preset: what the lights cost."""

import bpy

overlay = bpy.context.scene.whittle_overlay

overlay.metric = "NODES"
overlay.kinds = {"shadow"}
overlay.range = "AUTO"
overlay.low = 0.0
overlay.high = 100.0
