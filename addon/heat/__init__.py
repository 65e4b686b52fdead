# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Counts per pixel as coloured pictures with a legend."""

from .differences import draw_difference
from .pictures import UNAVAILABLE, HeatError, draw, show, write
from .text import available

__all__ = ["UNAVAILABLE", "HeatError", "available", "draw", "draw_difference", "show", "write"]
