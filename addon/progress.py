# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a long render stands, for Blender's progress bar and for batch runs that listen."""

import time
from collections.abc import Callable

import bpy

Listener = Callable[[str, float], None]

listeners: list[Listener] = []
"""Called with a phase ("export", "build", "trace", "judge") and its fraction done, in [0, 1]."""

SHARES = {"export": (0.0, 0.1), "build": (0.1, 0.3), "trace": (0.3, 1.0), "judge": (1.0, 1.0)}
TEXTS = {
    "export": "Reading the scene",
    "build": "Building the BVH",
    "trace": "Tracing rays",
    "judge": "Judging the BVH",
}
INTERVAL = 0.05  # seconds


class Progress:
    """Tells Blender and the listeners how far a render is, and hears Esc."""

    def __init__(self, engine: bpy.types.RenderEngine) -> None:
        self._engine = engine
        self._phase = ""
        self._next = 0.0

    def report(self, phase: str, fraction: float) -> bool:
        """Shows the fraction done of a phase, 20 times a second at most. False: stop."""
        now = time.monotonic()
        if phase == self._phase and now < self._next:
            return True
        self._next = now + INTERVAL
        if phase != self._phase:
            self._phase = phase
            self._engine.update_stats("", TEXTS[phase])
        start, end = SHARES[phase]
        self._engine.update_progress(start + (end - start) * fraction)
        for listener in listeners:
            listener(phase, fraction)
        return not self._engine.test_break()
