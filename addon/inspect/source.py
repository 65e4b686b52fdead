# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene as the core knows it, kept between draws until Blender's scene changes."""

import threading
import time
from dataclasses import dataclass, field
from typing import Any

import bpy

from .. import native, properties
from ..export import meshes
from ..export.scene import Export
from ..notes import Notes

QUICK = 0.5  # seconds: reading that takes longer than this waits for the Update button
SETTLE = 0.3  # seconds without a change before the scene is read anew


@dataclass
class Source:
    """A native scene that is read on the main thread, built on another, and traced when ready.

    What was read before stays in use until the next one is ready.
    """

    scene: Any = None  # the core's; None: nothing is ready
    error: str = ""  # why the last reading or building failed
    stale: bool = False  # Blender's scene has changed since it was read
    changed: float = 0.0  # when, by time.monotonic()
    generation: int = 0  # counts the scenes that became ready
    subject: tuple[str, str] = ("", "")  # names of scene and view layer, as last read
    build: dict[str, Any] = field(default_factory=dict)
    places: list[meshes.Place] = field(default_factory=list)
    materials: list[str] = field(default_factory=list)
    seconds_read: float = 0.0  # while which the window waited
    _work: "_Build | None" = None

    def read(self, depsgraph: bpy.types.Depsgraph) -> None:
        """Reads what the viewport shows and starts to build it; poll() tells when it is ready."""
        self.stop()
        began = time.perf_counter()
        self.stale, self.error = False, ""
        subject = (depsgraph.scene.name, depsgraph.view_layer.name)
        if subject != self.subject:
            self.scene = None
        self.subject = subject
        try:
            export = Export(native.load(), depsgraph, Notes(), lambda done: True)
        except (native.NativeError, ValueError, RuntimeError, MemoryError) as error:
            self._fail(error)
            return
        self.seconds_read = time.perf_counter() - began
        frame = depsgraph.scene
        self._work = _Build(export, properties.threads(frame), frame.whittle.bins)

    def poll(self) -> bool:
        """Takes over a scene whose build has ended; whether one has."""
        work = self._work
        if work is None or work.is_alive():
            return False
        self._work = None
        if work.error is not None:
            self._fail(work.error)
            return True
        self.scene, self.build = work.export.scene, work.stats
        self.places, self.materials = work.export.meshes.places, work.export.materials.names
        self.generation += 1
        return True

    @property
    def building(self) -> bool:
        return self._work is not None

    @property
    def progress(self) -> float:
        """Of the build, in [0, 1]."""
        return self._work.done if self._work is not None else 1.0

    def mark_stale(self) -> None:
        """Notes that Blender's scene is no longer what was read."""
        if self.subject != ("", ""):
            self.stale = True
            self.changed = time.monotonic()

    def wants_reading(self, subject: tuple[str, str], automatic: bool) -> bool:
        """Whether it is time to read the scene and view layer of these names."""
        if self.subject != subject:
            return True
        settled = self.stale and time.monotonic() - self.changed >= SETTLE
        return settled and automatic and self.seconds_read <= QUICK and not self.building

    def stop(self) -> None:
        """Tells a build that still runs to stop, and leaves it to end alone."""
        if self._work is not None:
            self._work.stop = True
        self._work = None

    def close(self) -> None:
        """Lets go of everything."""
        self.stop()
        self.__init__(generation=self.generation)

    def _fail(self, error: BaseException) -> None:
        self.scene = None
        self.error = str(error) or type(error).__name__


class _Build(threading.Thread):
    """Builds the hierarchy of a scene that was read; the window stays usable meanwhile."""

    def __init__(self, export: Export, threads: int, bins: int) -> None:
        super().__init__(name="Whittle build", daemon=True)
        self.export = export
        self.stats: dict[str, Any] = {}
        self.error: BaseException | None = None
        self.done = 0.0
        self.stop = False
        self._options = {"threads": threads, "bins": bins}
        self.start()

    def run(self) -> None:
        try:
            self.stats = self.export.scene.build(on_progress=self._report, **self._options)
        except BaseException as error:  # told by Source.poll, on the main thread
            self.error = error

    def _report(self, done: float) -> bool:
        self.done = done
        return not self.stop


shared = Source()
"""The one that all viewports of the session look at."""


def update(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """Handler: marks the source stale if a depsgraph update changes what rays would meet."""
    if scene.name == shared.subject[0] and any(map(_matters, depsgraph.updates)):
        shared.mark_stale()


def _matters(change: bpy.types.DepsgraphUpdate) -> bool:
    data = change.id
    if isinstance(data, bpy.types.Object):
        return data.type not in ("CAMERA", "SPEAKER")
    if isinstance(data, bpy.types.Scene | bpy.types.Camera | bpy.types.WindowManager):
        return False
    return change.is_updated_geometry or change.is_updated_transform or change.is_updated_shading


def mark_stale(*_: Any) -> None:
    """Handler: of undo, redo and another frame."""
    shared.mark_stale()


def forget(*_: Any) -> None:
    """Handler: another file is about to take the place of this one."""
    shared.close()


HANDLERS = (
    ("depsgraph_update_post", bpy.app.handlers.persistent(update)),
    ("frame_change_post", bpy.app.handlers.persistent(mark_stale)),
    ("undo_post", bpy.app.handlers.persistent(mark_stale)),
    ("redo_post", bpy.app.handlers.persistent(mark_stale)),
    ("load_pre", bpy.app.handlers.persistent(forget)),
)


def register() -> None:
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).remove(handler)
    shared.close()
