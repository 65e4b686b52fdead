# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene that the overlays look into: that of the rendered viewports, if there are any."""

import time
from collections.abc import Callable
from typing import Any

import bpy

from ..export.meshes import Place
from ..viewport import source as viewport_source
from ..viewport.source import Source

QUICK = 0.5  # seconds: reading that takes longer than this waits for the Update button
SETTLE = 0.3  # seconds without a change before the scene is read anew


class Shared:
    """What all overlays of the session look at: the source of one scene and view layer.

    Rendered viewports of that view layer use the same source and keep it up to date; where there
    are none, read() does."""

    edits, counts = False, True

    def __init__(self) -> None:
        self.subject = ("", "")
        """Names of scene and view layer, as last read."""
        self.busy: list[Callable[[], None]] = []
        """Called before the scene changes: they end what traces it."""
        self.source: Source | None = None

    def read(self, depsgraph: bpy.types.Depsgraph, whole: bool = False) -> None:
        """Reads what the viewport shows and starts to build it; poll() tells when it is ready.
        `whole`: as a render does, whose tree is not divided by objects."""
        self.subject = (depsgraph.scene.name, depsgraph.view_layer.name)
        self.source = viewport_source.of(depsgraph, self, now=self.source)
        self.source.read(depsgraph, whole=whole)

    def poll(self) -> bool:
        """Takes over a scene whose build has ended; whether one has."""
        return self.source is not None and self.source.poll()

    @property
    def scene(self) -> Any:
        """The core's; None: nothing is ready."""
        return self.source.scene if self.source is not None else None

    @property
    def error(self) -> str:
        """Why the last reading or building failed; "": it did not."""
        return self.source.error if self.source is not None else ""

    @property
    def stale(self) -> bool:
        """Whether Blender's scene has changed since it was read."""
        return self.source is not None and self.source.stale

    @property
    def building(self) -> bool:
        return self.source is not None and self.source.building

    @property
    def progress(self) -> float:
        """Of the build, in [0, 1]."""
        return self.source.progress if self.source is not None else 1.0

    @property
    def generation(self) -> int:
        """Tells the scenes apart that became ready."""
        return self.source.generation if self.source is not None else 0

    @property
    def build(self) -> dict[str, Any]:
        """Of the tree, as Scene.build gives it."""
        return self.source.build if self.source is not None else {}

    @property
    def by_instance(self) -> bool:
        """Whether it is divided by objects, as rendered viewports have it."""
        return self.source is not None and self.source.by_instance

    @property
    def places(self) -> dict[int, Place]:
        """Whose mesh each native instance shows."""
        return self.source.places if self.source is not None else {}

    @property
    def materials(self) -> list[str]:
        return self.source.materials if self.source is not None else []

    @property
    def quick(self) -> bool:
        """Whether it may be read without being asked for."""
        return self.source is None or self.source.seconds_read <= QUICK

    def wants_reading(self, subject: tuple[str, str], automatic: bool) -> bool:
        """Whether it is time to read the scene and view layer of these names."""
        if self.subject != subject or self.source is None:
            return True
        settled = self.stale and time.monotonic() - self.source.since >= SETTLE
        return settled and automatic and self.quick and not self.building

    def release(self) -> None:
        """Ends all that traces the scene."""
        for end in self.busy:
            end()

    def close(self) -> None:
        """Lets go of everything."""
        if self.source is not None:
            self.source.leave(self)
        self.source, self.subject = None, ("", "")


shared = Shared()
"""The one that all viewports of the session look at."""


@bpy.app.handlers.persistent
def forget(*_: Any) -> None:
    """Handler: another file is about to take the place of this one."""
    shared.close()


def register() -> None:
    bpy.app.handlers.load_pre.append(forget)


def unregister() -> None:
    bpy.app.handlers.load_pre.remove(forget)
    shared.close()
