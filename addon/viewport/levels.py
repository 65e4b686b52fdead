# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The images that a view goes through: small ones at once, then all pixels, then more samples."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import count, takewhile
from math import isqrt
from typing import Any

COARSEST = 4
"""The first image has at least one pixel for so many of the region's, each way."""

QUICK = 0.02
"""Seconds that a first image should take: it is as fine as is expected to fit."""

SOON = 0.6
"""Seconds after which an image of all pixels need not be bridged by one of a quarter of them."""


COARSE_CUTOFF = 1 / 64
"""Rays that add less to a pixel are left out of images with larger pixels, at least: a fifth of the
time for a difference that cannot be seen (a ten-thousandth on average in the demo)."""


@dataclass(frozen=True)
class Level:
    """How fine an image is."""

    reduction: int  # width and height of a pixel in pixels of the region
    samples: int

    def settings(self, asked: dict[str, Any]) -> dict[str, Any]:
        """The settings of Scene.start for an image of a view that asks for these."""
        own = {"passes": ["combined"], "samples": self.samples}
        if self.reduction > 1 and 0.0 <= asked.get("cutoff", 0.0) < COARSE_CUTOFF:
            own["cutoff"] = COARSE_CUTOFF
        return asked | own


def size(region: tuple[int, int], level: Level) -> tuple[int, int]:
    """Width and height of a region's image."""
    return tuple(-(-pixels // level.reduction) for pixels in region)


def levels(pixels: int, speeds: Mapping[int, float], samples: int) -> list[Level]:
    """All images of a region in their order. `speeds`: pixels a second by reduction, as far as they
    were measured (a small image takes longer for each pixel: its rays have less in common)."""
    if samples < 1 or isqrt(samples) ** 2 != samples:
        raise ValueError(f"viewport_samples must be a square number (1, 4, 9, ...), not {samples}")
    first = _first_reduction(pixels, speeds)
    coarse = [reduction for reduction in (4, 2, 1) if reduction <= first]
    if first == 4 and pixels <= SOON * speeds.get(1, 0.0):
        coarse.remove(2)
    # Each four times the one before, so that what comes before the last costs a third of it.
    between = takewhile(lambda n: n < samples, (4**k for k in count(1)))
    fine = [*between, *(() if samples == 1 else (samples,))]
    return [Level(reduction, 1) for reduction in coarse] + [Level(1, n) for n in fine]


def _first_reduction(pixels: int, speeds: Mapping[int, float]) -> int:
    """Of the finest first image that is quick."""
    slowest = min(speeds.values(), default=0.0)
    for reduction in (1, 2):
        if pixels / reduction**2 <= QUICK * speeds.get(reduction, slowest):
            return reduction
    return COARSEST
