# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A native scene that follows a depsgraph: what changed is exported again, and nothing else."""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from types import ModuleType
from typing import Any

import bpy

from ..notes import Notes
from . import materials, world
from .meshes import Key, Place, Placed, Reader
from .scene import Instance, Walk

Identity = tuple[Any, ...]

# A change of these may change a row of materials; what other changes bring is always compared.
SHADING = (bpy.types.Material, bpy.types.NodeTree, bpy.types.Texture, bpy.types.Image)


class Change(IntEnum):
    """What a sync has done to the native scene, from nothing to everything."""

    NONE = 0
    LOOK = 1  # materials, lights or world: it may be traced at once
    GEOMETRY = 2  # it must be built again


@dataclass
class Held:
    """An instance that the native scene has."""

    placed: Placed
    mesh: int
    instance: int


class Live:
    """Follows the viewport's depsgraph of one view layer.

    Call mark() for each update of the depsgraph, and sync() before the scene is next needed, when
    nothing traces or builds it. Both belong on Blender's main thread."""

    def __init__(self, core: ModuleType) -> None:
        self.core = core
        self.restart()

    def restart(self) -> None:
        """Forgets everything: the next sync reads the whole depsgraph into a new scene."""
        self.scene = self.core.Scene()
        self._new = True
        self.notes = Notes()
        self.places: dict[int, Place] = {}
        """Of each native instance that is there."""
        self.materials: materials.Table | None = None
        self._held: dict[Identity, Held] = {}
        self._meshes: dict[Key, int] = {}
        self._digests: dict[int, bytes] = {}  # of all meshes that the native scene has
        self._spare: set[int] = set()
        self._moved: set[int] = set()
        self._shading = True
        self._look: tuple[Any, ...] = ()
        self._layer: tuple[Any, ...] = ()

    def mark(self, depsgraph: bpy.types.Depsgraph) -> None:
        """Notes what depsgraph.updates says: it is true only while Blender tells of an update."""
        for update in depsgraph.updates:
            if update.is_updated_geometry:
                self._moved.add(update.id.original.session_uid)
            if isinstance(update.id, SHADING):
                self._shading = True

    def sync(
        self,
        depsgraph: bpy.types.Depsgraph,
        report: Callable[[float], bool] = lambda done: True,
        shown: Callable[[Instance], bool] = lambda instance: instance.show_self,
        release: Callable[[], None] = lambda: None,
    ) -> Change:
        """Brings the native scene up to the depsgraph; `report` and `shown` as for Walk. Calls
        `release` before each change of the native scene: it must end what traces it. After an
        error, or when report stopped it, the next sync reads everything."""
        self._release = release
        try:
            return self._sync(depsgraph, report, shown)
        except BaseException:
            self.restart()
            raise

    def _sync(
        self,
        depsgraph: bpy.types.Depsgraph,
        report: Callable[[float], bool],
        shown: Callable[[Instance], bool],
    ) -> Change:
        override = depsgraph.view_layer.material_override
        layer = (
            depsgraph.scene.session_uid,
            depsgraph.view_layer.name,
            override and override.session_uid,
        )
        if layer != self._layer:
            self.restart()
            self._layer = layer
            self.materials = materials.Table(self.notes, override)
        elif self._shading:
            self.materials.forget()
        census = Census(self.materials, self.notes, self._meshes, self._moved)
        walk = Walk(self.core, depsgraph, self.notes, census.meet, report, shown)
        change = self._apply(census)
        look = (self.materials.rows, walk.lights, world.export(depsgraph.scene_eval, self.notes))
        if look != self._look:
            self._set_look(*look)
            change = max(change, Change.LOOK)
        self._moved.clear()
        self._shading = False
        change, self._new = Change.GEOMETRY if self._new else change, False
        return change

    def _edited(self) -> Any:
        """The native scene, which nothing is at work on."""
        self._release()
        return self.scene

    def _set_look(self, rows: list[Any], lights: list[Any], sky: dict[str, Any]) -> None:
        self._edited().set_materials(rows)
        self._edited().set_lights(lights)
        self._edited().set_world(**sky)
        self._look = (list(rows), lights, sky)

    # ---- Geometry ----

    def _apply(self, census: "Census") -> Change:
        changed = [self._take_meshes(census)]
        for identity in self._held.keys() - census.found.keys():
            self._remove(self._held.pop(identity))
            changed.append(True)
        for identity, placed in census.found.items():
            changed.append(self._put(identity, placed))
        return Change.GEOMETRY if any(changed) else Change.NONE

    def _take_meshes(self, census: "Census") -> bool:
        """Gives the core the arrays that it does not have, in the place of meshes that nothing
        shows now where there are such. Whether there were any."""
        used = {placed.mesh for placed in census.found.values()}
        for key in self._meshes.keys() - used:
            del self._meshes[key]
        fresh = self._unknown(census)
        self._spare = self._digests.keys() - set(self._meshes.values())
        changed = bool(fresh)
        for identity, placed in census.found.items():
            if placed.mesh in fresh:
                data, digest = fresh.pop(placed.mesh)
                mesh = self._store(data, self._target(identity, placed.mesh))
                self._meshes[placed.mesh], self._digests[mesh] = mesh, digest
        return changed

    def _unknown(self, census: "Census") -> dict[Key, tuple[dict[str, Any], bytes]]:
        """What was read and the core does not have, with digests. Blender also tells of changes
        where there are none, such as in the mesh that a new object shares with others."""
        have = {digest: mesh for mesh, digest in self._digests.items()}
        fresh = {}
        for key, data in census.arrays.items():
            digest = _digest(data)
            if digest in have:
                self._meshes[key] = have[digest]
            else:
                fresh[key] = (data, digest)
        return fresh

    def _target(self, identity: Identity, key: Key) -> int | None:
        """The native mesh to replace: this one's own unless others show it, else a spare one, best
        that which the object had before."""
        own, held = self._meshes.get(key), self._held.get(identity)
        if own is not None and list(self._meshes.values()).count(own) == 1:
            return own
        if held is not None and held.mesh in self._spare:
            self._spare.remove(held.mesh)
            return held.mesh
        return self._spare.pop() if self._spare else None

    def _store(self, data: dict[str, Any], target: int | None) -> int:
        if target is None:
            return self._edited().add_mesh(**data, keep=True)
        self._edited().replace_mesh(target, **data, keep=True)
        return target

    def _put(self, identity: Identity, placed: Placed) -> bool:
        """Adds, moves or exchanges an instance; whether there was anything to do."""
        mesh, held = self._meshes[placed.mesh], self._held.get(identity)
        if held is None:
            self._add(identity, placed, mesh)
            return True
        before, held.placed = held.placed, placed
        same = (held.mesh, before.visibility, before.object_id)
        if same != (mesh, placed.visibility, placed.object_id):
            self._remove(held)
            self._add(identity, placed, mesh)
            return True
        self.places[held.instance] = placed.place
        if (before.matrix == placed.matrix).all():
            return False
        self._edited().set_transform(held.instance, placed.matrix)
        return True

    def _add(self, identity: Identity, placed: Placed, mesh: int) -> None:
        instance = self._edited().add_instance(
            mesh, placed.matrix, object_id=placed.object_id, visibility=placed.visibility
        )
        self._held[identity] = Held(placed, mesh, instance)
        self.places[instance] = placed.place

    def _remove(self, held: Held) -> None:
        self._edited().remove_instance(held.instance)
        del self.places[held.instance]


class Census:
    """The meshes that a walk meets, with the arrays of those that are new or have changed."""

    def __init__(
        self, table: materials.Table, notes: Notes, known: dict[Key, int], moved: set[int]
    ) -> None:
        """`moved`: the session_uid of what changed its geometry."""
        self._reader = Reader(table, notes)
        self._known = known
        self._moved = moved
        self._fresh: set[Key] = set()
        self.found: dict[Identity, Placed] = {}
        self.arrays: dict[Key, dict[str, Any]] = {}

    def meet(self, instance: Instance, visibility: int) -> None:
        placed = self._reader.placed(instance, visibility)
        if placed is None or not self._has_faces(instance, placed):
            return
        identity = _identity(instance)
        while identity in self.found:
            identity = (*identity, "again")
        self.found[identity] = placed

    def _has_faces(self, instance: Instance, placed: Placed) -> bool:
        """Reads the arrays if need be; False: there are none."""
        key = placed.mesh
        if key in self._fresh or (key in self._known and not self._has_moved(instance)):
            return True
        data = self._reader.arrays(instance, placed)
        if data is None:
            return False
        self._fresh.add(key)
        self.arrays[key] = data
        return True

    def _has_moved(self, instance: Instance) -> bool:
        owners = [instance.object, instance.object.original.data]
        if instance.parent is not None:
            owners.append(instance.parent)
        return any(o is not None and o.original.session_uid in self._moved for o in owners)


def _identity(instance: Instance) -> Identity:
    """What names a place from one evaluation to the next."""
    own = instance.object.original.session_uid
    if not instance.is_instance:
        return (own,)
    parent = instance.parent.original.session_uid if instance.parent is not None else 0
    return (own, parent, *instance.persistent_id)


def _digest(data: dict[str, Any]) -> bytes:
    """Tells arrays apart, by their shapes too."""
    total = hashlib.blake2b(digest_size=16)
    for name, values in data.items():
        if values is not None:
            total.update(f"{name} {values.shape}".encode())
            total.update(values.data if values.flags.c_contiguous else values.tobytes())
    return total.digest()
