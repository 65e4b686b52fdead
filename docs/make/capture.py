# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene as the add-on hands it to the core, kept so that it can be changed and traced again."""

from __future__ import annotations

import atexit
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import bpy
import studio  # noqa: F401  (makes the add-on importable)

Material = dict[str, Any]


@dataclass
class Recording:
    """The calls that fill a core scene, in their order, with their arguments."""

    meshes: list[tuple[tuple, dict[str, Any]]] = field(default_factory=list)
    instances: list[tuple[tuple, dict[str, Any]]] = field(default_factory=list)
    materials: list[Material] = field(default_factory=list)
    lights: list[dict[str, Any]] = field(default_factory=list)
    world: dict[str, Any] = field(default_factory=dict)

    def add_mesh(self, *arguments: Any, **named: Any) -> int:
        self.meshes.append((arguments, named))
        return len(self.meshes) - 1

    def add_instance(self, *arguments: Any, **named: Any) -> int:
        self.instances.append((arguments, named))
        return len(self.instances) - 1

    def set_materials(self, materials: list[Material]) -> None:
        self.materials = [dict(row) for row in materials]

    def set_lights(self, lights: list[dict[str, Any]]) -> None:
        self.lights = [dict(row) for row in lights]

    def set_world(self, color: Any, ambient: Any = (0.0, 0.0, 0.0)) -> None:
        self.world = {"color": color, "ambient": ambient}

    def fill(self, scene: Any) -> Any:
        """Make the calls on a core scene; gives that scene."""
        for arguments, named in self.meshes:
            scene.add_mesh(*arguments, **named)
        for arguments, named in self.instances:
            scene.add_instance(*arguments, **named)
        scene.set_materials(self.materials)
        scene.set_lights(self.lights)
        scene.set_world(**self.world)
        return scene


class RecordingCore:
    """The core's module, but that its scenes only record."""

    def __init__(self, core: Any) -> None:
        self._core = core

    def __getattr__(self, name: str) -> Any:
        return Recording if name == "Scene" else getattr(self._core, name)


@dataclass
class Shot:
    """One frame: what the core is given, what was not understood, and the seconds it took."""

    core: Any
    recording: Recording
    camera: dict[str, Any]
    settings: dict[str, Any]
    seconds: float
    notes: list[str]

    def scene(self, change: Callable[[Recording], Recording] | None = None) -> Any:
        """A new core scene, not yet built, of the recording or of a changed copy."""
        recording = self.recording if change is None else change(self.recording)
        return recording.fill(self.core.Scene())


class Capture(bpy.types.RenderEngine):
    """An engine that makes no picture: it keeps what the add-on would have rendered."""

    bl_idname = "WHITTLE_CAPTURE"
    bl_label = "Whittle Capture"

    outcome: Shot | BaseException | None = None

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        try:
            Capture.outcome = _shot(depsgraph, (self.resolution_x, self.resolution_y))
        except BaseException as error:  # Blender would print it and go on; shot() raises it
            Capture.outcome = error


def _shot(depsgraph: bpy.types.Depsgraph, size: tuple[int, int]) -> Shot:
    from addon import native, properties
    from addon.export import camera, scene
    from addon.notes import Notes

    core = native.load()
    frame = depsgraph.scene_eval
    notes = Notes()
    began = time.perf_counter()
    export = scene.Export(RecordingCore(core), depsgraph, notes, lambda _done: True)
    view = camera.export(depsgraph, frame.camera, size, camera.region(frame.render, size), notes)
    seconds = time.perf_counter() - began
    settings = properties.core_settings(frame, ["combined"])
    return Shot(core, export.scene, view, settings, seconds, notes.lines())


def shot(scene: bpy.types.Scene) -> Shot:
    """Gather a scene as for a final render. Raises what the exporter raises."""
    if not Capture.is_registered:
        bpy.utils.register_class(Capture)
        atexit.register(bpy.utils.unregister_class, Capture)
    engine = scene.render.engine
    Capture.outcome = None
    scene.render.engine = Capture.bl_idname
    try:
        bpy.ops.render.render(scene=scene.name)
    finally:
        scene.render.engine = engine
    if isinstance(Capture.outcome, Shot):
        return Capture.outcome
    raise Capture.outcome or RuntimeError("Blender did not ask the engine for a picture")
