# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluated meshes and the places where they stand; arrays are copied with foreach_get only."""

from dataclasses import dataclass
from math import inf
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from .. import native
from ..notes import Notes
from .materials import Table

OPEN = 0xFFFFFFFF
"""What the core writes for corners of triangles that it leaves open."""

MANY = 4
"""To be asked for a triangle by its number takes about as many times as long as one of a list."""

Key = tuple[int, tuple[int, ...], bytes]
"""Of a mesh for the core: Blender's mesh, its materials, and where it was squashed flat."""


@dataclass(frozen=True)
class Place:
    """Whose mesh an instance of the core shows: names that are in ``bpy.data.objects``."""

    object: str
    instancer: str  # the object that placed it; "": it stands there itself


@dataclass(frozen=True)
class Placed:
    """What the depsgraph shows in one place, without the mesh's arrays."""

    mesh: Key
    matrix: NDArray[np.float64]  # (4, 4)
    visibility: int
    object_id: int
    place: Place


class Reader:
    """Reads the instances of a depsgraph, one after the other."""

    def __init__(self, materials: Table, notes: Notes) -> None:
        self._materials = materials
        self._notes = notes

    def placed(self, instance: bpy.types.DepsgraphObjectInstance, visibility: int) -> Placed | None:
        """What an instance shows to the rays of a mask; None: no mesh, or none that can be seen."""
        ob = instance.object
        if not len(ob.data.polygons) and not ob.data.is_editmode:
            return None
        matrix = np.array(instance.matrix_world, dtype=np.float64)
        flat = b""
        # Single precision tells quickly that all is well; numpy is asked where it does not.
        if not (0.0 < abs(instance.matrix_world.determinant()) < inf):
            if not np.isfinite(matrix).all():
                self._notes.add(f"Object '{ob.name}' left out: its place is not a finite number")
                return None
            if np.linalg.det(matrix[:3, :3]) == 0.0:
                if np.linalg.matrix_rank(matrix[:3, :3]) < 2:
                    self._notes.add(f"Object '{ob.name}' left out: its scale is zero")
                    return None
                flat, matrix = matrix.tobytes(), np.eye(4)
        slots = tuple(self._materials.index(slot.material) for slot in ob.material_slots)
        return Placed(
            mesh=(ob.data.as_pointer(), slots, flat),
            matrix=matrix,
            visibility=visibility,
            object_id=ob.pass_index,
            place=_place(instance),
        )

    def arrays(
        self, instance: bpy.types.DepsgraphObjectInstance, placed: Placed
    ) -> dict[str, Any] | None:
        """The arguments of Scene.add_mesh for what an instance shows; None: there is no face."""
        ob = instance.object
        _, slots, flat = placed.mesh
        # An object without slots shows the default material.
        rows = np.array(slots or (self._materials.index(None),), dtype=np.uint32)
        if not ob.data.is_editmode:
            data = arrays(ob.data, rows)
        else:
            # The mesh under edit has its arrays elsewhere: Blender makes one that has them here.
            data = arrays(ob.to_mesh(), rows)
            ob.to_mesh_clear()
        if data is not None and flat:
            _squash(data, np.frombuffer(flat).reshape(4, 4))
        return data


def _place(instance: bpy.types.DepsgraphObjectInstance) -> Place:
    ob, parent = instance.object, instance.parent
    # Curves and the like come as an instance that is placed by themselves.
    placed = instance.is_instance and parent is not None and parent.name != ob.name
    return Place(ob.name, parent.name if placed else "")


def _squash(data: dict[str, Any], matrix: NDArray[np.float64]) -> None:
    """An object squashed flat: no inverse, so its vertices are placed here, not by the core."""
    positions = data["positions"] @ matrix[:3, :3].T + matrix[:3, 3]
    positions = positions.astype(np.float32)
    positions.flags.writeable = False
    data |= {"positions": positions, "normals": None}


class Meshes:
    """Adds each mesh once for each set of materials, and an instance for each of its places."""

    def __init__(self, scene: Any, materials: Table, notes: Notes) -> None:
        self._scene = scene
        self._reader = Reader(materials, notes)
        self._index: dict[Key, int] = {}
        self.users: dict[int, list[str]] = {}
        """Names of the objects that use each native mesh."""
        self.places: list[Place] = []
        """Of each native instance."""

    def add(self, instance: bpy.types.DepsgraphObjectInstance, visibility: int) -> None:
        """Places the mesh of an instance; visibility is a mask of the core's constants."""
        placed = self._reader.placed(instance, visibility)
        if placed is None:
            return
        if placed.mesh not in self._index:
            data = self._reader.arrays(instance, placed)
            if data is None:
                return
            self._index[placed.mesh] = self._scene.add_mesh(**data, keep=True)
        mesh = self._index[placed.mesh]
        self._scene.add_instance(
            mesh, placed.matrix, object_id=placed.object_id, visibility=placed.visibility
        )
        users = self.users.setdefault(mesh, [])
        if not users or users[-1] != placed.place.object:
            users.append(placed.place.object)
        self.places.append(placed.place)


def arrays(mesh: bpy.types.Mesh, slots: NDArray[np.uint32]) -> dict[str, Any] | None:
    """The arguments of Scene.add_mesh for a mesh whose material slots are the given materials, of
    arrays that it may keep; None if it has no face."""
    if not len(mesh.polygons):
        return None
    positions = _column(mesh.attributes["position"].data, "vector", np.float32, 3)
    corners = _column(mesh.attributes[".corner_vert"].data, "value", np.int32).view(np.uint32)
    faces = _faces(mesh)
    by_corner = mesh.normals_domain == "CORNER"
    if faces is None:
        triangles, normals = corners.reshape(-1, 3), _normals(mesh)
        data = {"corners": None, "normals": normals.reshape(-1, 3, 3) if by_corner else normals}
    else:
        triangles = _triangles(mesh, positions, corners, faces, by_corner)
        data = {"corners": corners if by_corner else None, "normals": _normals(mesh)}
    data |= {"positions": positions, "triangles": triangles}
    data["materials"] = _materials(mesh, faces, slots)
    for values in data.values():
        if values is not None:
            values.flags.writeable = False
    return data


def _column(data: Any, name: str, kind: type, width: int = 1) -> NDArray[Any]:
    """One property of all elements, as (n,) or (n, width)."""
    values = np.empty(len(data) * width, dtype=kind)
    data.foreach_get(name, values)
    return values if width == 1 else values.reshape(-1, width)


def _faces(mesh: bpy.types.Mesh) -> NDArray[np.uint32] | None:
    """The face of each triangle; None where faces are the triangles, in order."""
    if len(mesh.loops) == 3 * len(mesh.polygons):
        return None
    return _column(mesh.loop_triangle_polygons, "value", np.int32).view(np.uint32)


def _triangles(
    mesh: bpy.types.Mesh,
    positions: NDArray[np.float32],
    corners: NDArray[np.uint32],
    faces: NDArray[np.uint32],
    by_corner: bool,
) -> NDArray[np.uint32]:
    """Vertices (m, 3), or corners, of the triangles that Blender divides its faces into.

    By foreach_get they come one at a time, which takes longer than all else here. The core divides
    quads the same way, and Blender is asked for what the core leaves open."""
    triangles, open_ones = native.load().triangulate(positions, corners, faces, by_corner=by_corner)
    if not open_ones:
        return triangles
    mesh.calc_loop_triangles()
    rows, name = mesh.loop_triangles, "loops" if by_corner else "vertices"
    if MANY * open_ones > len(triangles):
        return _column(rows, name, np.int32, 3).view(np.uint32)
    which = np.flatnonzero(triangles[:, 0] == OPEN)
    triangles[which] = [getattr(rows[i], name)[:] for i in which.tolist()]
    return triangles


def _normals(mesh: bpy.types.Mesh) -> NDArray[np.float32] | None:
    """Shading normals: none where flat, by vertex where that says it all, else by corner."""
    if mesh.normals_domain == "FACE":
        return None
    vectors = mesh.vertex_normals if mesh.normals_domain == "POINT" else mesh.corner_normals
    return _column(vectors, "vector", np.float32, 3)


def _materials(
    mesh: bpy.types.Mesh, faces: NDArray[np.uint32] | None, slots: NDArray[np.uint32]
) -> NDArray[np.uint32] | None:
    """Material of each triangle, None if all have the first; a face whose slot does not exist takes
    the last one."""
    attribute = mesh.attributes.get("material_index")
    if attribute is None or len(slots) == 1:
        if slots[0] == 0:
            return None
        count = len(mesh.polygons) if faces is None else len(faces)
        return np.full(count, slots[0], dtype=np.uint32)
    index = _column(attribute.data, "value", np.int32)
    by_face = slots[np.clip(index, 0, len(slots) - 1)]
    return by_face if faces is None else by_face[faces]
