# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds a native scene beside Blender's main thread."""

import threading
from typing import Any


class Build:
    """One build, begun at once; the native code works without Python's lock."""

    def __init__(self, scene: Any, **options: Any) -> None:
        """`options` are those of Scene.build."""
        self.fraction = 0.0
        self._scene, self._options = scene, options
        self._cancelled = False
        self._stats: dict[str, Any] | None = None
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="Whittle build")
        self._thread.start()

    def ended(self, wait: float = 0.0) -> bool:
        """Whether it has ended; waits so many seconds at most."""
        self._thread.join(wait)
        return not self._thread.is_alive()

    def result(self) -> dict[str, Any]:
        """Waits; what Scene.build returned, or raises what it raised."""
        self._thread.join()
        if self._error is not None:
            raise self._error
        return self._stats

    def cancel(self) -> None:
        """Asks it to stop and waits until it has; result() then raises core.Cancelled, unless it
        was done just before."""
        self._cancelled = True
        self._thread.join()

    def _run(self) -> None:
        try:
            self._stats = self._scene.build(on_progress=self._report, **self._options)
        except BaseException as error:  # result() raises it where it can be handled
            self._error = error

    def _report(self, fraction: float) -> bool:
        self.fraction = fraction
        return not self._cancelled
