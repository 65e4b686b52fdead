# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Preset: what the view's own rays cost, without light and mirrors."""

import bpy

overlay = bpy.context.scene.whittle_overlay

overlay.metric = "NODES"
overlay.kinds = {"primary"}
overlay.range = "AUTO"
overlay.low = 0.0
overlay.high = 100.0
