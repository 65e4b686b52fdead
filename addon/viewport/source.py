# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene that the viewports of a view layer show, read and built once for all who trace it."""

import time
from collections.abc import Callable
from itertools import count
from typing import Any, Protocol

import bpy

from .. import native, properties
from ..export.live import Change, Live
from ..export.meshes import Place
from ..export.scene import Instance
from ..faults import explained
from .builder import Build

Key = tuple[int, str, int]
"""Whose scene it is: the scene's session_uid, the view layer's name, and the 3D viewport with a
local view of its own, or 0."""


class User(Protocol):
    """Who traces a source's scene."""

    edits: bool
    """Whether it follows edits as they are made: then a build redoes only what has changed."""

    counts: bool
    """Whether it looks at the binary tree, which is left out if nobody does."""

    def release(self) -> None:
        """Ends all tracing, since the scene is about to change."""


def _everything(instance: Instance) -> bool:
    return instance.show_self


class Source:
    """A native scene that follows a depsgraph. All of it is called on Blender's main thread; a
    build runs on another, and while it does there is nothing to trace."""

    _states = count(1)

    def __init__(self, key: Key) -> None:
        self.key = key
        self.error = ""
        """Why the last reading or building failed; "": it did not."""
        self.changed = True
        """Whether the depsgraph has changed since it was read."""
        self.stale = False
        """Whether it has in a way that rays may notice."""
        self.since = 0.0
        """When it last did, by time.monotonic()."""
        self.generation = 0
        """Tells states of the scene apart that were ready, those of other sources too."""
        self.build: dict[str, Any] = {}
        """Of the last build, as Scene.build gives it."""
        self.builds = 0
        """How many there were."""
        self.by_instance = False
        """Whether the last one made a tree for each object."""
        self.lean = False
        """Whether it left out the binary tree."""
        self.seconds_read = 0.0
        """Of the last reading, for which the window waited."""
        self._bins = 0
        self._live: Live | None = None
        self._built = False
        self._work: Build | None = None
        self._users: list[User] = []

    # ---- What there is ----

    @property
    def scene(self) -> Any:
        """The core's scene; None while there is none to trace."""
        return self._live.scene if self._built else None

    @property
    def places(self) -> dict[int, Place]:
        """Whose mesh each native instance shows."""
        return self._live.places if self._live is not None else {}

    @property
    def materials(self) -> list[str]:
        """Names of the native scene's materials."""
        known = self._live.materials if self._live is not None else None
        return known.names if known is not None else []

    @property
    def was_read(self) -> bool:
        return self._live is not None

    @property
    def building(self) -> bool:
        return self._work is not None

    @property
    def progress(self) -> float:
        """Of the build, in [0, 1]."""
        return self._work.fraction if self._work is not None else 1.0

    # ---- Following ----

    def mark(self, depsgraph: bpy.types.Depsgraph) -> None:
        """Notes what depsgraph.updates says: it is true only while Blender tells of an update."""
        if self._live is not None:
            self._live.mark(depsgraph)
        self.changed = True
        if any(map(_matters, depsgraph.updates)):
            self.mark_stale()

    def mark_stale(self) -> None:
        """Notes that Blender's scene is no longer what was read."""
        self.stale, self.since = True, time.monotonic()

    def read(
        self,
        depsgraph: bpy.types.Depsgraph,
        shown: Callable[[Instance], bool] = _everything,
        whole: bool = False,
    ) -> None:
        """Brings the scene up to the depsgraph, and starts a build if it needs one: poll() tells
        when that is done. `whole`: its tree must be the one tree that renders have."""
        self.error, self.changed, self.stale = "", False, False
        began = time.perf_counter()
        try:
            self._read(depsgraph, shown, whole)
        except Exception as error:  # told by all who show this scene
            self._fail(error)
        self.seconds_read = time.perf_counter() - began

    def _read(
        self, depsgraph: bpy.types.Depsgraph, shown: Callable[[Instance], bool], whole: bool
    ) -> None:
        self._stop_build()
        if self._live is None:
            self._live = Live(native.load())
        change = self._live.sync(depsgraph, shown=shown, release=self._release)
        bins = depsgraph.scene.whittle.bins
        lean = not any(user.counts for user in self._users)
        wanting = (self.lean and not lean) or (self.by_instance and whole) or bins != self._bins
        if change == Change.GEOMETRY or wanting or not self._built:
            self._bins, self.lean = bins, lean
            self.by_instance = not whole and any(user.edits for user in self._users)
            self._start_build(depsgraph.scene)
        elif change == Change.LOOK:
            self.generation = next(self._states)

    def _start_build(self, scene: bpy.types.Scene) -> None:
        self._release()
        self._built = False
        self._work = Build(
            self._live.scene,
            threads=properties.threads(scene),
            bins=self._bins,
            by_instance=self.by_instance,
            lean=self.lean,
        )

    def poll(self, wait: float = 0.0) -> bool:
        """Takes over a build that has ended, after so many seconds at most; whether one has."""
        if self._work is None or not self._work.ended(wait):
            return False
        work, self._work = self._work, None
        try:
            self.build = work.result()
        except Exception as error:  # as above
            self._fail(error)
            return True
        self._built, self.builds = True, self.builds + 1
        self.generation = next(self._states)
        return True

    def _fail(self, error: Exception) -> None:
        self._release()
        self._built, self.error = False, explained(error)

    def _stop_build(self) -> None:
        if self._work is not None:
            self._work.cancel()
            self._work = None

    def _release(self) -> None:
        for user in self._users:
            user.release()

    # ---- Coming and going ----

    def join(self, user: User) -> None:
        """Lets someone trace the scene until leave()."""
        if user not in self._users:
            self._users.append(user)

    def leave(self, user: User) -> None:
        """The last one to leave closes it."""
        if user in self._users:
            user.release()
            self._users.remove(user)
        if not self._users:
            self.close()

    def is_only_for(self, user: User) -> bool:
        return self._users == [user]

    def close(self) -> None:
        """Lets go of the scene; a new one is read if it is used again."""
        self._stop_build()
        self._release()
        self._live, self._built, self.changed = None, False, True
        if _all.get(self.key) is self:
            del _all[self.key]


_all: dict[Key, Source] = {}


def of(
    depsgraph: bpy.types.Depsgraph, user: User, local: int = 0, now: Source | None = None
) -> Source:
    """The source of a depsgraph, which `user` has joined; it leaves `now`, the one it had."""
    key = (depsgraph.scene.session_uid, depsgraph.view_layer.name, local)
    if now is not None and now.key == key and _all.get(key) is now:
        return now
    if now is not None and now.is_only_for(user) and key not in _all and now.key[:2] == key[:2]:
        # A local view shows less of the same: what was read stays.
        _all.pop(now.key, None)
        now.key, now.changed, _all[key] = key, True, now
        return now
    found = _all.setdefault(key, Source(key))
    found.join(user)
    if now is not None:
        now.leave(user)
    return found


# ---- Blender's news ------------------------------------------------------------------------------


def _matters(change: bpy.types.DepsgraphUpdate) -> bool:
    data = change.id
    if isinstance(data, bpy.types.Object):
        return data.type not in ("CAMERA", "SPEAKER")
    if isinstance(data, bpy.types.Scene | bpy.types.Camera | bpy.types.WindowManager):
        return False
    return change.is_updated_geometry or change.is_updated_transform or change.is_updated_shading


def update(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    """Handler: tells the sources of a depsgraph what has changed in it."""
    if depsgraph is None or depsgraph.mode != "VIEWPORT":
        return
    name = depsgraph.scene.session_uid, depsgraph.view_layer.name
    for source in _all.values():
        if source.key[:2] == name:
            source.mark(depsgraph)


def another_frame(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    """Handler: anything may have moved."""
    if depsgraph is None or depsgraph.mode == "VIEWPORT":
        update(scene, depsgraph)
        mark_stale()


def mark_stale(*_: Any) -> None:
    """Handler: of undo and redo."""
    for source in _all.values():
        source.mark_stale()


def close_all(*_: Any) -> None:
    """Handler: another file is about to take the place of this one."""
    for source in list(_all.values()):
        source.close()


HANDLERS = (
    ("depsgraph_update_post", bpy.app.handlers.persistent(update)),
    ("frame_change_post", bpy.app.handlers.persistent(another_frame)),
    ("undo_post", bpy.app.handlers.persistent(mark_stale)),
    ("redo_post", bpy.app.handlers.persistent(mark_stale)),
    ("load_pre", bpy.app.handlers.persistent(close_all)),
)


def register() -> None:
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).remove(handler)
    close_all()
