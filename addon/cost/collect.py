# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes what is known of cost from a native scene, before it goes."""

from collections.abc import Callable
from typing import Any

from .measured import Measured, Names
from .pixels import covered

# Clipping every triangle would take minutes where thousands of long boxes overlap.
OVERLAP_SAMPLES = 2048


def collect(
    scene: Any,
    names: Names,
    shot: dict[str, Any],
    settings: dict[str, Any],
    counted: dict[str, Any],
    own_trees: bool,
    report: Callable[[float], bool],
) -> Measured:
    """`scene`: the native one, built; `shot`, `settings`: as it was rendered; `counted`: its cost.

    own_trees: builds a tree for each instance too, and measures overlaps. `report` is told the
    fraction done and may stop it: then the core's Cancelled is raised."""
    quality = scene.quality(
        overlap=own_trees,
        by_instance=own_trees,
        on_progress=report,
        threads=settings["threads"],
        overlap_samples=OVERLAP_SAMPLES,
    )
    part = quality["instance"]
    pixels = covered(shot, part["box_min"], part["box_max"])
    return Measured(counted, quality, names, pixels, settings["samples"])
