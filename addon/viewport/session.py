# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One 3D viewport in rendered shading: it follows the scene, the view and the settings."""

import time
import weakref
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import bpy

from .. import faults, properties
from ..export.scene import Instance
from . import camera, pulse
from . import source as sources
from .levels import Level
from .picture import Picture
from .source import Source
from .tracer import Image, Tracer, View

PATIENCE = 0.09
"""Seconds that a redraw may wait for a first image or a small build, so that what is seen keeps up
with the mouse; whatever takes longer is looked for by the pulse."""

BETWEEN_TEXTS = 0.5  # seconds


@dataclass(frozen=True)
class Frame:
    """An image that was shown, with times in seconds."""

    level: Level
    asked: float  # time.perf_counter when a redraw first asked for this view
    latency: float  # from then until it was drawn


class Session:
    """What a viewport's engine keeps between redraws. All of it runs on Blender's main thread."""

    edits = True  # what an edit shows must follow soon
    counts = False

    def __init__(self, engine: bpy.types.RenderEngine) -> None:
        self._engine = weakref.ref(engine)
        self.source: Source | None = None
        """The scene, shared with what else looks at its view layer."""
        self._tracer, self._picture = Tracer(), Picture()
        self._announced = False  # that the scene is about to be read
        self._local = (False, False)
        self._seen: tuple[int, str] = (0, "")  # generation and error that were last drawn
        self._shown: Image | None = None
        self._error: str | None = None
        self._failed: View | None = None  # what the error came of
        self._text, self._next_text = "", 0.0
        self.frames: deque[Frame] = deque(maxlen=512)
        """The images shown, newest last."""
        pulse.add(self)

    @property
    def build_stats(self) -> dict[str, Any]:
        """Of the last build, as Scene.build gives them."""
        return self.source.build if self.source is not None else {}

    def update(self, depsgraph: bpy.types.Depsgraph) -> None:
        """Blender says that data changed."""
        if self.source is not None:
            self.source.mark(depsgraph)

    def draw(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """Draws the region with what there is of its picture, and sees that more comes."""
        try:
            self._advance(context, depsgraph)
        except BaseException as error:
            self._error = faults.explained(error)
            self._tracer.stop()
            self._tracer.image = None
        image = self._tracer.image
        if image is None:
            return
        self._picture.draw(image)
        if image is not self._shown:
            self._shown = image
            latency = time.perf_counter() - image.asked
            self.frames.append(Frame(image.level, image.asked, latency))

    def at_rest(self) -> bool:
        """Whether all that was asked for is shown, or an error says why it is not."""
        source = self.source
        if source is None or source.changed or source.building or self._tracer.busy():
            return False
        drawn = self._seen == (source.generation, source.error)
        return drawn and (self._error is not None or self._tracer.image is self._shown)

    def release(self) -> None:
        """Ends all tracing; the next redraw begins anew."""
        self._tracer.stop()

    def close(self) -> None:
        """Ends all work; the session is of no use afterwards."""
        pulse.remove(self)
        self._tracer.stop()
        if self.source is not None:
            self.source.leave(self)

    # ---- Following ----

    def _advance(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        source = self._follow(context.space_data, depsgraph)
        source.poll()
        if source.changed and not source.building:
            if not source.was_read and not self._announced:
                self._announced = True  # drawn before the window stands still for it
                self._tell(self._engine())
                return
            source.read(depsgraph, _shown_in(context.space_data, any(self._local)))
            source.poll(wait=PATIENCE)
        self._notice(source)
        if source.scene is not None:
            self._trace(context, depsgraph.scene_eval)

    def _follow(self, space: bpy.types.SpaceView3D, depsgraph: bpy.types.Depsgraph) -> Source:
        """The source of what the viewport shows. Blender tells nobody that the local view was
        entered or left."""
        local = (space.local_view is not None, space.use_local_collections)
        key = space.as_pointer() if any(local) else 0
        self.source = sources.of(depsgraph, self, key, self.source)
        if local != self._local:
            self._local, self.source.changed = local, True
        return self.source

    def _notice(self, source: Source) -> None:
        """Takes note of what has become of the scene since the last redraw."""
        seen = (source.generation, source.error)
        if seen == self._seen:
            return
        self._seen, self._failed = seen, None
        self._error = source.error or None
        if source.error:
            self._tracer.image = None

    def _trace(self, context: bpy.types.Context, scene: bpy.types.Scene) -> None:
        view = self._view(context, scene)
        if view is None:
            self._tracer.stop()
            self._tracer.image = None
        if view is None or view == self._failed:
            return
        self._failed = view  # until all has gone well: it is not tried again and again
        if self._tracer.show(self.source.scene, view):
            self._error = None
        self._tracer.poll()
        image = self._tracer.image
        if image is None or image.view != view:
            self._tracer.wait(PATIENCE)
        self._failed = None

    def _view(self, context: bpy.types.Context, scene: bpy.types.Scene) -> View | None:
        """What the region shows; None: not a pixel."""
        space, region, view = context.space_data, context.region, context.region_data
        part = camera.part(scene, space, region, view)
        if part[2] <= part[0] or part[3] <= part[1]:
            return None
        eye = camera.eye(space, view)
        settings = properties.core_settings(scene, [])
        del settings["passes"], settings["samples"]
        if settings["mode"] == "lecture":  # what it counts is not shown here
            settings["mode"] = "fast"
        return View(
            to_world=eye.to_world.tobytes(),
            projection=eye.projection.tobytes(),
            clip=eye.clip,
            size=(region.width, region.height),
            part=part,
            samples=scene.whittle.viewport_samples,
            settings=tuple(settings.items()),
            scene=self.source.generation,
        )

    # ---- Telling ----

    def tick(self) -> bool:
        """The pulse's look at the work: asks for a redraw where there is news. False: it is over,
        Blender has freed the engine."""
        engine = self._engine()
        try:
            if engine is None:
                raise ReferenceError
            if self._tracer.ready() or self._has_news():
                engine.tag_redraw()
            self._tell(engine)
        except ReferenceError:
            self.close()
            return False
        return True

    def _has_news(self) -> bool:
        """Whether the scene is another one than was drawn, or can be."""
        if self.source is None:
            return False
        self.source.poll()
        return self._seen != (self.source.generation, self.source.error)

    def _tell(self, engine: bpy.types.RenderEngine) -> None:
        """Keeps the line of text in the viewport up to date, a few times a second."""
        now, text = time.perf_counter(), self._status()
        if text == self._text or now < self._next_text:
            return
        self._text, self._next_text = text, now + BETWEEN_TEXTS
        engine.update_stats("Whittle", text)
        engine.tag_redraw()

    def _status(self) -> str:
        if self._error is not None:
            return self._error
        if self.source is None or not self.source.was_read:
            return "Reading the scene"
        if self.source.building:
            return f"Building the BVH: {self.source.progress:.0%}"
        return _samples(self._tracer)


def _samples(tracer: Tracer) -> str:
    """How fine the image is, and what comes."""
    image, work = tracer.image, tracer.progress()
    if image is None or image.level.reduction > 1:
        return "Tracing"
    done = f"{image.level.samples} of {image.view.samples} samples"
    return done if work is None else f"{done}, the next: {work[1]:.0%}"


def _shown_in(space: bpy.types.SpaceView3D, local: bool) -> Callable[[Instance], bool]:
    """Which instances a viewport shows. Lights shine into a local view from outside."""

    def shown(instance: Instance) -> bool:
        if not local or not instance.show_self or instance.object.type == "LIGHT":
            return instance.show_self
        owner = instance.parent if instance.is_instance and instance.parent else instance.object
        return owner.visible_in_viewport_get(space)

    return shown
