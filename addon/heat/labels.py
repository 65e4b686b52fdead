# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A piece of text in a picture."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Label:
    """A line of text at pixel (x, y) of its baseline's left end, middle or right end."""

    text: str
    x: float
    y: float
    align: str  # LEFT, CENTER or RIGHT
