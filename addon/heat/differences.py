# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where one count is larger than another: a picture in two colours, grey where nothing changed."""

import numpy as np
from numpy.typing import NDArray

from . import colormaps, legend
from .pictures import NARROWEST, PERCENTILE


def draw_difference(
    before: NDArray[np.floating], after: NDArray[np.floating], title: str
) -> NDArray[np.float32]:
    """after - before, counts (h, w) of one size, as a picture (h, w, 3), sRGB in [0, 1], row 0 at
    the bottom: blue where it is less, red where it is more. The ends of the colours are what 99.5 %
    of the pixels that differ stay below."""
    if before.shape != after.shape:
        raise ValueError(f"before is {before.shape} and after {after.shape}: give one size")
    change = after.astype(np.float64) - before
    moved = np.abs(change[change != 0])
    top = max(1.0, float(np.percentile(moved, PERCENTILE))) if moved.size else 1.0
    scale = -(-NARROWEST // change.shape[1])
    picture = colormaps.apply("DIFFERENCE", (change / top + 1) / 2)
    picture = picture.repeat(scale, axis=0).repeat(scale, axis=1)
    less, more = (change < 0).mean(), (change > 0).mean()
    band = legend.Legend(
        title=title,
        summary=f"less {less:.0%}  more {more:.0%}  mean {change.mean():+,.3g}",
        colormap="DIFFERENCE",
        top=top,
        low=-top,
    )
    return np.concatenate((legend.draw(band, picture.shape[1]), picture))
