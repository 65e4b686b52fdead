# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whittle: Whitted ray tracing in Blender, and what every ray costs."""

import atexit

from . import batch, builtin_panels, cost_ui, engine, inspect, operators, panels, properties

PARTS = (properties, engine, operators, panels, builtin_panels, batch, inspect, cost_ui)

_registered = False


def register() -> None:
    global _registered
    for part in PARTS:
        part.register()
    _registered = True
    # Blender as a Python module frees what is still registered after Python has ended, and crashes.
    atexit.register(unregister)


def unregister() -> None:
    """Undoes register; does nothing a second time, since Blender asks again when it ends."""
    global _registered
    if not _registered:
        return
    _registered = False
    atexit.unregister(unregister)
    for part in reversed(PARTS):
        part.unregister()
