# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From Blender's depsgraph to the core's scene, a file for each kind of data."""
