# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The band below a heatmap: what is shown, the colours, their numbers."""

from dataclasses import dataclass
from math import floor, log10

import numpy as np
from numpy.typing import NDArray

from . import colormaps, text
from .labels import Label

BACKGROUND = 0.11
INK = 0.93


@dataclass(frozen=True)
class Legend:
    """What a legend says: numbers from `low`, 0 or -top, to `top`; `title` and `summary` share its
    first line."""

    title: str
    summary: str
    colormap: str
    top: float
    low: float = 0.0


def draw(legend: Legend, width: int) -> NDArray[np.float32]:
    """The band (height, width, 3), row 0 at the bottom; its height follows from the width."""
    font = max(13, width // 62)
    height = 5 * font
    margin = font
    band = np.full((height, width, 3), BACKGROUND, dtype=np.float32)
    bar = slice(2 * font, 3 * font)
    length = width - 2 * margin
    ramp = colormaps.apply(legend.colormap, (np.arange(length) + 0.5) / length)
    band[bar, margin : margin + length] = ramp
    labels = [
        Label(legend.title, margin, 3.75 * font, "LEFT"),
        Label(legend.summary, width - margin, 3.75 * font, "RIGHT"),
    ]
    for tick in _marks(legend):
        x = margin + round((length - 1) * (tick - legend.low) / (legend.top - legend.low))
        band[bar.start - font // 3 : bar.start, x] = INK
        align = "LEFT" if tick == legend.low else "CENTER"
        labels.append(Label(f"{tick:,g}", x, 0.55 * font, align))
    if legend.low < 0:
        labels.append(Label(f"< {number(legend.low)}", margin, 0.55 * font, "LEFT"))
    if legend.low < 0 or legend.top not in ticks(legend.top):
        labels.append(Label(f"{number(legend.top)}+", width - margin, 0.55 * font, "RIGHT"))
    cover = text.cover(labels, font, width, height)[..., np.newaxis]
    return band * (1.0 - cover) + INK * cover


def _marks(legend: Legend) -> list[float]:
    """Where the ticks are: on both sides of 0 if the legend has both, and then fewer."""
    if legend.low == 0:
        return ticks(legend.top)
    marks = [mark for mark in ticks(2 * legend.top) if mark < 0.62 * legend.top]
    return [-mark for mark in marks[:0:-1]] + marks


def number(value: float) -> str:
    """A measured number as a legend shows it."""
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.4g}"


def ticks(top: float) -> list[float]:
    """Round numbers from 0 up, four to nine of them; none so near the top as to touch its label."""
    magnitude = 10.0 ** floor(log10(top))
    step = next(m * magnitude for m in (0.2, 0.5, 1.0, 2.0) if top / (m * magnitude) <= 8)
    values = [float(f"{index * step:.6g}") for index in range(int(top / step + 1e-9) + 1)]
    return [value for value in values if value == top or value < 0.88 * top]
