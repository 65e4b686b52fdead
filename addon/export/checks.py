# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of values by the names that their owners have in Blender."""

from typing import Any

import numpy as np


def finite(owner: str, row: dict[str, Any]) -> dict[str, Any]:
    """The row itself; ValueError naming the owner if a number in it is infinite or none at all."""
    for name, value in row.items():
        if not isinstance(value, str) and not np.isfinite(value).all():
            raise ValueError(f"{owner}: its {name} is {value}: give it finite numbers")
    return row
