# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Walks a depsgraph and fills a native scene with what it finds."""

from collections import Counter, defaultdict
from collections.abc import Callable
from types import ModuleType
from typing import Any

import bpy

from ..notes import Notes, listed, plural
from . import lights, materials, meshes, world
from .checks import finite

GREASE_PENCIL = "grease pencil"

# Object types that the engine cannot draw, and what their objects are called in the report.
LEFT_OUT = {
    "CURVES": "hair",
    "POINTCLOUD": "point cloud",
    "VOLUME": "volume",
    "GPENCIL": GREASE_PENCIL,
    "GREASEPENCIL": GREASE_PENCIL,
}


Instance = bpy.types.DepsgraphObjectInstance


class Walk:
    """Goes through a depsgraph's instances: meshes are handed on, lights become rows."""

    def __init__(
        self,
        core: ModuleType,
        depsgraph: bpy.types.Depsgraph,
        notes: Notes,
        meet: Callable[[Instance, int], None],
        report: Callable[[float], bool],
        shown: Callable[[Instance], bool] = lambda instance: instance.show_self,
    ) -> None:
        """`meet` is called for each mesh, with the mask of the rays that see it. `report` is told
        the fraction done and may stop the walk: then core.Cancelled is raised."""
        self.core = core
        self.notes = notes
        self.lights: list[dict[str, Any]] = []
        self._meet = meet
        self._layer = depsgraph.view_layer
        self._left_out: dict[str, Counter[str]] = defaultdict(Counter)
        total = max(1, len(depsgraph.object_instances))
        for index, instance in enumerate(depsgraph.object_instances):
            if not report(index / total):
                raise core.Cancelled("The render was cancelled while the scene was read")
            if shown(instance):
                self._add(instance)
        self._note_what_was_left_out()

    def _add(self, instance: Instance) -> None:
        ob = instance.object
        if ob.type == "MESH":
            # Curves, text, surfaces and metaballs come a second time as the mesh they make.
            self._meet(instance, self._visibility(instance))
        elif ob.type == "LIGHT":
            row = lights.export(ob, instance.matrix_world, self.notes)
            self.lights.append(finite(f"Light '{ob.name}'", row))
        elif ob.type in LEFT_OUT:
            self._left_out[LEFT_OUT[ob.type]][ob.name] += 1
        for system in ob.particle_systems:
            if system.settings.type == "HAIR" and system.settings.render_type == "PATH":
                self._left_out["hair"][f"{ob.name}: {system.name}"] += 1

    def _visibility(self, instance: Instance) -> int:
        """Which rays see an instance: what it and whatever placed it both allow."""
        mask = self._object_visibility(instance.object)
        if instance.is_instance and instance.parent is not None:
            mask &= self._object_visibility(instance.parent)
        return mask

    def _object_visibility(self, ob: bpy.types.Object) -> int:
        core = self.core
        mask = (
            core.CAMERA * ob.visible_camera
            | core.SHADOW * ob.visible_shadow
            | core.REFLECTION * ob.visible_glossy
            | core.REFRACTION * ob.visible_transmission
        )
        original = ob.original
        if original.indirect_only_get(view_layer=self._layer):
            mask &= ~core.CAMERA
        if original.holdout_get(view_layer=self._layer):
            self.notes.add(f"Object '{ob.name}': holdout is not understood, it is drawn")
        return mask

    def _note_what_was_left_out(self) -> None:
        for kind, names in self._left_out.items():
            count = plural(names.total(), "object")
            drawn = ", Blender draws it over the picture" if kind == GREASE_PENCIL else ""
            self.notes.add(f"Left out {kind}: {count} ({listed(names)}){drawn}")


class Export:
    """A native scene, ready to be built, and the names behind its meshes."""

    def __init__(
        self,
        core: ModuleType,
        depsgraph: bpy.types.Depsgraph,
        notes: Notes,
        report: Callable[[float], bool],
    ) -> None:
        """Reads everything that is rendered; report as for Walk."""
        self.scene = core.Scene()
        self.notes = notes
        self.materials = materials.Table(notes, depsgraph.view_layer.material_override)
        self.meshes = meshes.Meshes(self.scene, self.materials, notes)
        walk = Walk(core, depsgraph, notes, self.meshes.add, report)
        self.scene.set_materials(self.materials.rows)
        self.scene.set_lights(walk.lights)
        self.scene.set_world(**world.export(depsgraph.scene_eval, notes))
        self.materials.note_models()

    def note_dropped(self, dropped: list[dict[str, int]]) -> None:
        """Names the objects whose triangles the build dropped, with the counts."""
        for row in dropped:
            reasons = [
                f"{row[key]:,} {text}"
                for key, text in (("non_finite", "not finite"), ("zero_area", "without area"))
                if row[key]
            ]
            names = listed(self.meshes.users[row["mesh"]])
            self.notes.add(f"Dropped triangles of {names}: {' and '.join(reasons)}")
