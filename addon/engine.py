# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine that Blender calls."""

import time
from typing import Any

import bpy

from . import cost, faults, native, passes, properties, results
from .export import camera
from .export.scene import Export
from .faults import RenderError
from .notes import Notes
from .progress import Progress
from .viewport import picture, pulse, source
from .viewport.session import Session

LONGEST_WAIT = 0.05  # between two looks at a running job, in seconds


class WhittleEngine(bpy.types.RenderEngine):
    """Whitted ray tracing by the native core."""

    bl_idname = "WHITTLE"
    bl_label = "Whittle"
    bl_use_preview = False
    bl_use_postprocess = True
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False

    _session: Session | None = None  # of a viewport's engine

    def update_render_passes(
        self, scene: bpy.types.Scene = None, renderlayer: bpy.types.ViewLayer = None
    ) -> None:
        for row in passes.wanted(scene, renderlayer):
            self.register_pass(
                scene, renderlayer, row.name, len(row.channels), row.channels, row.kind
            )

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        # Only an error report keeps Blender from saving a black picture: nothing may get past it.
        try:
            render_layer(self, depsgraph)
        except BaseException as error:
            fail(self, error)

    def view_update(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        if self._session is None:
            self._session = Session(self)
        self._session.update(depsgraph)

    def view_draw(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        if self._session is None:
            self._session = Session(self)
        self._session.draw(context, depsgraph)

    def __del__(self) -> None:
        # Blender calls nothing else when a viewport goes back to another shading.
        if self._session is not None:
            self._session.close()


def fail(engine: bpy.types.RenderEngine, error: BaseException) -> None:
    """Ends a render without a result, by an error report that says why."""
    engine.report({"ERROR"}, f"Whittle: {faults.explained(error)}")


def render_layer(engine: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph) -> None:
    """Exports, builds, traces and hands over one view layer of one frame."""
    core, scene = native.load(), depsgraph.scene_eval
    size = (engine.resolution_x, engine.resolution_y)
    region = camera.region(scene.render, size)
    view = _camera_object(engine, scene)
    _check_supported(scene, region)
    notes, progress, clock = Notes(), Progress(engine), Clock()
    table = passes.wanted(scene, depsgraph.view_layer_eval)
    try:
        export = Export(core, depsgraph, notes, lambda done: progress.report("export", done))
        shot = camera.export(depsgraph, view, size, region, notes)
        clock.lap("export")
        build = _build(export, scene, progress)
        clock.lap("build")
        settings = _settings(scene, table)
        image = _trace(export.scene, shot, settings, progress)
        clock.lap("trace")
        measured = _judge(export, scene, shot, settings, image, progress)
        if measured is not None:
            clock.lap("judge")
    except core.Cancelled:
        return  # Esc: Blender knows, and keeps no picture
    _hand_over(engine, depsgraph.view_layer_eval.name, region, table, image)
    clock.lap("hand_over")
    result = results.Result(
        scene=scene.name,
        layer=depsgraph.view_layer_eval.name,
        frame=scene.frame_current,
        size=(region[2] - region[0], region[3] - region[1]),
        seconds=clock.seconds,
        build=build,
        render=image["stats"],
        notes=notes.lines(),
        counters={row.source: image[row.source][..., 0] for row in table if row.counter},
        cost=measured,
        settings=properties.kept(scene),
    )
    _keep(engine, result)


class Clock:
    """Wall time of the phases of a render, in seconds."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._start = time.perf_counter()

    def lap(self, phase: str) -> None:
        """Ends a phase; the next one starts here."""
        now = time.perf_counter()
        self.seconds[phase] = now - self._start
        self._start = now


def _build(export: Export, scene: bpy.types.Scene, progress: Progress) -> dict[str, Any]:
    stats = export.scene.build(
        threads=properties.threads(scene),
        bins=scene.whittle.bins,
        lean=properties.lean(scene),
        on_progress=lambda done: progress.report("build", done),
    )
    export.note_dropped(stats["dropped"])
    return stats


def _settings(scene: bpy.types.Scene, table: list[passes.Pass]) -> dict[str, Any]:
    asked = properties.core_settings(scene, [row.source for row in table])
    return asked | {"cost": scene.whittle.use_counters}


def _judge(
    export: Export,
    scene: bpy.types.Scene,
    shot: dict[str, Any],
    settings: dict[str, Any],
    image: dict[str, Any],
    progress: Progress,
) -> cost.Measured | None:
    """What the table of cost needs of the native scene, which ends with the render; None: nobody
    asked for it."""
    if not settings["cost"]:
        return None
    names = cost.Names([place.object for place in export.meshes.places], export.materials.names)
    return cost.collect(
        export.scene,
        names,
        shot,
        settings,
        image["cost"],
        scene.whittle.use_own_trees,
        lambda done: progress.report("judge", done),
    )


def _camera_object(engine: bpy.types.RenderEngine, scene: bpy.types.Scene) -> bpy.types.Object:
    found = engine.camera_override or scene.camera
    if found is None:
        raise RenderError("The scene has no camera: add one, or choose it in the Scene properties")
    return found


def _check_supported(scene: bpy.types.Scene, region: camera.Region) -> None:
    if scene.render.use_multiview:
        raise RenderError("Stereoscopy is not supported: turn it off in the Output properties")
    if region[2] <= region[0] or region[3] <= region[1]:
        raise RenderError("The render region holds no pixel: draw a larger one, or turn it off")


def _trace(
    native_scene: Any, shot: dict[str, Any], settings: dict[str, Any], progress: Progress
) -> dict[str, Any]:
    """Renders in the background, while this thread shows progress and hears Esc."""
    job = native_scene.start(shot, settings)
    wait = 0.001
    fraction, done = 0.0, False  # a quick job too has its phase shown
    while not done:
        if not progress.report("trace", fraction):
            job.cancel()
        time.sleep(wait)
        wait = min(2 * wait, LONGEST_WAIT)
        fraction, done = job.poll()
    return job.result()


def _hand_over(
    engine: bpy.types.RenderEngine,
    layer: str,
    region: camera.Region,
    table: list[passes.Pass],
    image: dict[str, Any],
) -> None:
    """Gives the passes to Blender; row 0 is at the bottom on both sides."""
    width, height = region[2] - region[0], region[3] - region[1]
    result = engine.begin_result(0, 0, width, height, layer=layer)
    complete = False
    try:
        if (result.resolution_x, result.resolution_y) != (width, height):
            raise RenderError(
                f"Blender asks for {result.resolution_x} x {result.resolution_y} pixels "
                f"where its border holds {width} x {height}: move the border a little"
            )
        for row in table:
            result.layers[0].passes[row.name].rect.foreach_set(image[row.source].reshape(-1))
        complete = True
    finally:
        engine.end_result(result, cancel=not complete)


def _keep(engine: bpy.types.RenderEngine, result: results.Result) -> None:
    """Stores the numbers for the panel, and says what was done otherwise than asked."""
    results.store(result)
    for line in result.notes:
        engine.report({"INFO"}, f"Whittle: {line}")
    stamp = engine.get_result().stamp_data_add_field
    stamp("Whittle.triangles", str(result.build["triangles"]))
    stamp("Whittle.nodes", str(result.build["nodes"]))
    stamp("Whittle.rays", str(result.rays()))


def register() -> None:
    source.register()
    bpy.utils.register_class(WhittleEngine)


def unregister() -> None:
    pulse.unregister()
    picture.forget()
    bpy.utils.unregister_class(WhittleEngine)
    source.unregister()
