# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a counted render knows about cost, as plain data that outlives the native scene."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Names:
    """Of what stands behind the core's numbers."""

    objects: list[str]  # the object of each instance; several instances may show the same
    materials: list[str]  # of each material; "": what a slot without one shows


@dataclass(frozen=True)
class Measured:
    """Counts and qualities of one render."""

    cost: dict[str, Any]  # as Scene.render gives it under "cost"
    quality: dict[str, Any]  # as Scene.quality gives it
    names: Names
    pixels: NDArray[np.float64]  # (instances,) of the picture: see pixels.covered
    samples: int  # per pixel
