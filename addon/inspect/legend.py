# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The legend that stands in a viewport: what is shown, the colours, their numbers, how many."""

from dataclasses import dataclass
from math import ceil, floor, log10

import numpy as np
from numpy.typing import NDArray

from . import draw

PAPER: draw.Color = (0.09, 0.09, 0.09, 0.82)
INK: draw.Color = (0.93, 0.93, 0.93, 1.0)
FAINT: draw.Color = (0.72, 0.72, 0.72, 1.0)
BARS: draw.Color = (0.62, 0.62, 0.62, 1.0)
WARN: draw.Color = (1.0, 0.72, 0.3, 1.0)


@dataclass(frozen=True)
class Legend:
    """Its texts, colours and numbers; `bars` are pixels by equal parts of the span, if shown."""

    title: str
    lines: tuple[str, ...]
    warning: str = ""
    colormap: str = "VIRIDIS"
    span: tuple[float, float] | None = None  # None: no colours to explain
    logarithmic: bool = False
    over: bool = False  # values lie above the span
    bars: NDArray[np.integer] | None = None
    keys: tuple[tuple[str, draw.Color], ...] = ()  # words in the colours that they explain


def paint(legend: Legend, x: float, y: float, scale: float) -> float:
    """Draws it with its lower left corner at (x, y), for a user interface of the given scale;
    its height."""
    font, width = 12.0 * scale, 330.0 * scale
    rows = [(line, FAINT) for line in legend.lines]
    if legend.warning:
        rows.append((legend.warning, WARN))
    pad, step = 10.0 * scale, 17.0 * scale
    if legend.keys:
        rows.append(("", FAINT))
    bar = 0.0 if legend.span is None else 34.0 * scale
    bars = 0.0 if legend.bars is None or legend.span is None else 34.0 * scale
    height = 2 * pad + step * (1 + len(rows)) + bar + bars
    draw.rectangles(np.array([(x, y, x + width, y + height)]), PAPER)
    left, right, top = x + pad, x + width - pad, y + height - pad
    draw.text(legend.title, left, top - font, font, INK)
    for index, (line, color) in enumerate(rows, start=1):
        draw.text(line, left, top - font - index * step, 11.0 * scale, color)
    for word, color in legend.keys:
        left += draw.text(word, left, top - font - len(rows) * step, 11.0 * scale, color)[0]
        left += pad
    left = x + pad
    if legend.span is not None:
        box = (left, y + pad + 16.0 * scale, right, y + pad + 30.0 * scale)
        if bars:
            _histogram(legend.bars, (left, box[3] + 2 * scale, right, box[3] + bars - 4 * scale))
        draw.ramp(legend.colormap, box)
        _numbers(legend, box, scale)
    return height


def _histogram(bars: NDArray[np.integer], box: tuple[float, float, float, float]) -> None:
    """Heights follow the square root of the counts, so that rare values can be seen."""
    x0, y0, x1, y1 = box
    share = np.sqrt(bars / max(1, bars.max()))
    edge = x0 + (x1 - x0) * np.arange(len(bars) + 1) / len(bars)
    boxes = np.stack(
        (edge[:-1], np.full(len(bars), y0), edge[1:] - 0.5, y0 + (y1 - y0) * share), axis=-1
    )
    draw.rectangles(boxes[bars > 0], BARS)


def _numbers(legend: Legend, box: tuple[float, float, float, float], scale: float) -> None:
    low, high = legend.span
    x0, y0, x1, _ = box
    marks = decades(low, high) if legend.logarithmic else ticks(low, high)
    for mark in marks:
        share = log10(mark / low) / log10(high / low) if legend.logarithmic else None
        x = x0 + (x1 - x0) * ((mark - low) / (high - low) if share is None else share)
        draw.rectangles(np.array([(x - 0.5 * scale, y0 - 3 * scale, x + 0.5 * scale, y0)]), INK)
        last = mark == marks[-1]
        align = "LEFT" if mark == low else "RIGHT" if x > x1 - 20 * scale else "CENTER"
        plus = "+" if last and legend.over and mark == high else ""
        draw.text(number(mark) + plus, x, y0 - 15 * scale, 11.0 * scale, INK, align)


def ticks(low: float, high: float) -> list[float]:
    """Round numbers within [low, high], about four of them; the ends too, where there is room."""
    span = high - low
    if not span > 0.0:
        return [low]
    magnitude = 10.0 ** floor(log10(span))
    step = next(m * magnitude for m in (0.2, 0.5, 1.0, 2.0, 5.0) if span / (m * magnitude) <= 5)
    first = ceil(low / step - 1e-9)
    marks = [float(f"{index * step:.6g}") for index in range(first, floor(high / step + 1e-9) + 1)]
    inner = [mark for mark in marks if low + 0.12 * span < mark < high - 0.16 * span]
    return [low, *inner, high]


def decades(low: float, high: float) -> list[float]:
    """The powers of ten within [low, high], both above 0; the ends if there are none."""
    powers = range(ceil(log10(low) - 1e-9), floor(log10(high) + 1e-9) + 1)
    return [10.0**power for power in powers] or [low, high]


def number(value: float) -> str:
    """Three or four digits that can be read at a glance: 0.012, 3.25, 48, 1,204, 1.2M."""
    size = abs(value)
    if size >= 1e6:
        return f"{value / 1e6:.3g}M"
    if size >= 100 or value == int(value):
        return f"{value:,.0f}"
    return f"{value:.3g}" if size >= 1e-4 or not size else f"{value:.0e}"
