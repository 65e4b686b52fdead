# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The usual causes of dear rays, each with the number that shows it and the mend."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .rows import Row

# From here on a number is worth a sentence.
SLIVERS = 0.25  # of the triangles
FEWEST_SLIVERS = 100
STRAY = 0.5  # of the surface of an object's own box
STRETCH = 0.33  # of the surface of shared boxes
OVERLAP = 0.25  # of the object's surface
DENSE = 2.0  # triangles to a pixel: half of them face away


@dataclass(frozen=True)
class Hint:
    """A cause of cost that an artist can do something about."""

    kind: str  # slivers, stray, stretch, overlap or dense
    value: float  # the number that shows it
    text: str  # one sentence with the number
    mend: str  # what to do about it


def percent(share: float) -> str:
    """A share as text that never says all where something is missing."""
    return "> 99 %" if 0.995 <= share < 1.0 else f"{100 * share:.0f} %"


def hints_of(row: Row) -> tuple[Hint, ...]:
    """What is worth saying about a row that costs anything, the plainest cause first."""
    if row.shared or not row.share:
        return ()
    found = (_slivers(row), _stray(row), _stretch(row), _overlap(row), _dense(row))
    return tuple(hint for hint in found if hint is not None)


def _slivers(row: Row) -> Hint | None:
    share = row.slivers / row.triangles if row.triangles else 0.0
    if share < SLIVERS or row.slivers < FEWEST_SLIVERS:
        return None
    text = (
        f"{percent(share)} of its {row.triangles:,} triangles are slivers: "
        f"they fill {row.box_fill:.2g} of their boxes on average"
    )
    return Hint("slivers", share, text, "remesh it, or cut long diagonal faces across")


def _stray(row: Row) -> Hint | None:
    if row.stray_share is None or row.stray_share < STRAY:
        return None
    text = (
        f"{percent(row.stray_share)} of its box's surface is there for {row.stray_triangles:,} "
        f"of its {row.triangles:,} triangles"
    )
    return Hint("stray", row.stray_share, text, "delete those far parts, or separate them")


def _stretch(row: Row) -> Hint | None:
    if row.stretch < STRETCH:
        return None
    text = f"{percent(row.stretch)} of the surface of shared boxes is there for it alone"
    return Hint("stretch", row.stretch, text, "split it, or bring it nearer to the rest")


def _overlap(row: Row) -> Hint | None:
    if row.overlap is None or row.overlap < OVERLAP:
        return None
    text = f"{percent(row.overlap)} of its surface stands in leaf boxes of others"
    mend = "move it apart from what it stands in, or join both and delete hidden parts"
    return Hint("overlap", row.overlap, text, mend)


def _dense(row: Row) -> Hint | None:
    if row.triangles_per_pixel is None or row.triangles_per_pixel < DENSE:
        return None
    text = f"{row.triangles_per_pixel:,.1f} triangles for each pixel around it"
    return Hint("dense", row.triangles_per_pixel, text, "decimate it, or use a coarser copy")
