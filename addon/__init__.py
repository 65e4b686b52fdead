# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whittle: Whitted ray tracing in Blender, and what every ray costs."""

import atexit

from . import batch, builtin_panels, engine, operators, panels, properties

PARTS = (properties, engine, operators, panels, builtin_panels, batch)


def register() -> None:
    for part in PARTS:
        part.register()
    # Blender as a Python module frees what is still registered after Python has ended, and crashes.
    atexit.register(unregister)


def unregister() -> None:
    atexit.unregister(unregister)
    for part in reversed(PARTS):
        part.unregister()
