# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Traces a view in the background, image by image, and starts again when the view changes."""

import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .levels import Level, levels, size

Region = tuple[int, int, int, int]


@dataclass(frozen=True)
class View:
    """What is to be seen: everything that an image follows from but the scene."""

    to_world: bytes  # float64 (4, 4)
    projection: bytes  # float64 (4, 4)
    clip: tuple[float, float]
    size: tuple[int, int]  # of the region, in pixels
    part: Region  # of the region that is drawn: x0, y0, x1, y1
    samples: int
    settings: tuple[tuple[str, Any], ...]  # for Scene.start, but passes and samples
    scene: int  # counts the states of the scene

    def pixels(self) -> int:
        return (self.part[2] - self.part[0]) * (self.part[3] - self.part[1])

    def camera(self, level: Level) -> dict[str, Any]:
        """The camera of Scene.start for an image as fine as this."""
        width, height = size(self.size, level)
        x0, y0, x1, y1 = self.part
        r = level.reduction
        return {
            "to_world": np.frombuffer(self.to_world).reshape(4, 4),
            "projection": np.frombuffer(self.projection).reshape(4, 4),
            "width": width,
            "height": height,
            "clip_start": self.clip[0],
            "clip_end": self.clip[1],
            "region": (x0 // r, y0 // r, -(-x1 // r), -(-y1 // r)),
        }


@dataclass
class Image:
    """A finished image. Times are those of time.perf_counter."""

    view: View
    level: Level
    pixels: NDArray[np.float32]  # (height, width, 4), row 0 at the bottom
    asked: float  # when the view was first asked for
    done: float
    size: tuple[int, int] = field(init=False)  # of the whole region's image
    part: Region = field(init=False)  # that pixels is of it

    def __post_init__(self) -> None:
        camera = self.view.camera(self.level)
        self.size, self.part = (camera["width"], camera["height"]), camera["region"]


class Tracer:
    """Makes the images of one view at a time."""

    def __init__(self) -> None:
        self.image: Image | None = None
        """The last finished one; of an older view until the first of the new one is done."""
        self._scene: Any = None
        self._wanted: View | None = None
        self._asked = 0.0
        self._job: Any = None
        self._traced: tuple[View, Level, float] | None = None  # what the job is at; its start
        self._plan: list[Level] = []
        self._speeds: dict[int, float] = {}  # pixels a second, by reduction, of one sample each

    def show(self, scene: Any, view: View) -> bool:
        """Asks for the images of a view of a built scene; False: it is the view at hand."""
        if view == self._wanted and scene is self._scene:
            return False
        self._scene, self._wanted, self._asked = scene, view, time.perf_counter()
        self._plan = levels(view.pixels(), self._speeds, view.samples)
        # A first image is let finish: cancelled with each move, it would never be seen.
        if self._job is not None and not self._is_first():
            self._cancel()
        if self._job is None:
            self._next()
        return True

    def poll(self) -> bool:
        """Looks at the work, and starts the next image; True if there is a new one."""
        if self._job is None or not self._job.poll()[1]:
            return False
        view, level, start = self._traced
        job, self._job = self._job, None
        result, now = job.result(), time.perf_counter()
        asked = self._asked if view == self._wanted else start
        self.image = Image(view, level, result["combined"], asked, now)
        if level.samples == 1:
            height, width = self.image.pixels.shape[:2]
            self._speeds[level.reduction] = width * height / max(now - start, 1e-6)
        self._next()
        return True

    def ready(self) -> bool:
        """Whether poll would find an image."""
        return self._job is not None and self._job.poll()[1]

    def busy(self) -> bool:
        return self._job is not None

    def wait(self, seconds: float) -> bool:
        """Polls until there is a new image; False if there is none after so many seconds."""
        end = time.perf_counter() + seconds
        while self.busy() and not self.ready() and time.perf_counter() < end:
            time.sleep(0.0005)
        return self.poll()

    def progress(self) -> tuple[Level, float] | None:
        """What is traced now and its fraction done; None: everything is done."""
        return None if self._job is None else (self._traced[1], self._job.poll()[0])

    def stop(self) -> None:
        """Ends the work, so that the scene may be changed; show() starts again."""
        self._cancel()
        self._wanted, self._plan = None, []

    def _is_first(self) -> bool:
        return self.image is None or self.image.view != self._traced[0]

    def _next(self) -> None:
        if not self._plan:
            return
        view, level = self._wanted, self._plan.pop(0)
        self._job = self._scene.start(view.camera(level), level.settings(dict(view.settings)))
        self._traced = (view, level, time.perf_counter())

    def _cancel(self) -> None:
        if self._job is None:
            return
        job, self._job = self._job, None
        job.cancel()
        while not job.poll()[1]:  # soon: threads look after each tile
            time.sleep(0.0002)
