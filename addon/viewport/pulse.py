# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A timer that lets each viewport look after its work between redraws."""

from typing import Protocol

import bpy

INTERVAL = 0.01  # seconds


class Ticking(Protocol):
    """What has work in the background."""

    def tick(self) -> bool:
        """Looks after it; False: it need not be asked again."""

    def close(self) -> None:
        """Ends it."""


_all: list[Ticking] = []


def add(one: Ticking) -> None:
    """Calls its tick() on Blender's main thread from now on."""
    _all.append(one)
    if not bpy.app.timers.is_registered(_beat):
        bpy.app.timers.register(_beat, persistent=True)


def remove(one: Ticking) -> None:
    """Does nothing if it is not there."""
    if one in _all:
        _all.remove(one)


def _beat() -> float | None:
    for one in list(_all):
        if not one.tick():
            remove(one)
    return INTERVAL if _all else None


def unregister() -> None:
    for one in list(_all):
        one.close()
    _all.clear()
    if bpy.app.timers.is_registered(_beat):
        bpy.app.timers.unregister(_beat)
