# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Counts per pixel as coloured pictures with a legend."""

from .differences import draw_difference
from .pictures import HeatError, draw, show, write

__all__ = ["HeatError", "draw", "draw_difference", "show", "write"]
