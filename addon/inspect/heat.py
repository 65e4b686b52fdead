# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Heatmaps of viewports: coarse while the view moves, then finer, traced in the background."""

import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .metrics import Choice
from .view import View

DIVISORS = (16, 8, 4, 2, 1)  # of the viewport's width and height, from coarse to fine
FIRST = 8  # before anything is known of the scene's speed
PATIENCE = 0.05  # seconds that a picture may take while the view moves
REST = 0.15  # seconds without a move before pictures become finer
PERCENTILE = 99.5
BINS = 64


@dataclass(frozen=True)
class Want:
    """All that a heatmap follows from, but its resolution."""

    view: View
    choice: Choice
    settings: tuple[tuple[str, Any], ...]  # of the core, sorted
    generation: int  # of the source


@dataclass(frozen=True)
class Picture:
    """A finished heatmap: values (h, w) in the metric's unit, row 0 at the bottom."""

    values: NDArray[np.float32]
    want: Want
    divisor: int
    seconds: float  # of tracing
    mean: float = 0.0
    p95: float = 0.0
    highest: float = 0.0
    top: float = 1.0  # where an automatic range ends

    def histogram(self, low: float, high: float) -> NDArray[np.int64]:
        """How many pixels lie in each of 64 equal parts of the range; those outside in the ends."""
        span = max(high - low, 1e-30)
        place = np.clip((self.values - low) * (BINS / span), 0, BINS - 1)
        return np.bincount(place.astype(np.uint8).reshape(-1), minlength=BINS)


def picture(want: Want, divisor: int, image: dict[str, Any]) -> Picture:
    """The heatmap of a render with the passes of want.choice."""
    values = want.choice.values(image)
    p95, top = np.percentile(values, (95.0, PERCENTILE))
    known = want.choice.row.top
    return Picture(
        values=values,
        want=want,
        divisor=divisor,
        seconds=image["stats"]["seconds"],
        mean=float(values.mean(dtype=np.float64)),
        p95=float(p95),
        highest=float(values.max()),
        top=known if known is not None else (float(top) or 1.0),
    )


@dataclass
class Heat:
    """The heatmap of one viewport, and the job that makes the next."""

    wanted: Want | None = None
    moved: float = -1e9  # when the view last changed, by time.monotonic()
    picture: Picture | None = None
    error: str = ""
    _job: Any = None
    _traced: tuple[Want, int] | None = None  # what the job traces
    _first: bool = False  # whether it is the first, coarse one of its view
    _failed: Want | None = None
    _pace: float = 0.0  # seconds a pixel, as last measured
    _dying: list[Any] = field(default_factory=list)

    def want(self, want: Want) -> None:
        """Says what the viewport should show; a job for anything else is cancelled at once, but
        for a coarse one: else a view that moves all the time would show nothing new."""
        if want == self.wanted:
            return
        if self.wanted is None or want.view != self.wanted.view:
            self.moved = time.monotonic()
        self.wanted = want
        if self._job is not None and not self._first:
            self.cancel()

    def cancel(self) -> None:
        """Stops the job; it is let go when it has ended, so that nobody waits for it."""
        if self._job is not None:
            self._job.cancel()
            self._dying.append(self._job)
        self._job = self._traced = None

    def stop(self) -> None:
        """Stops all jobs and waits for their end, so that the scene may be changed; step() starts
        again."""
        self.cancel()
        while any(not job.poll()[1] for job in self._dying):  # soon: threads look after each tile
            time.sleep(0.0002)
        self._dying.clear()

    def clear(self) -> None:
        """Forgets the picture and what was wanted."""
        self.cancel()
        self.wanted = self.picture = self._failed = None
        self.error = ""

    def step(self, scene: Any) -> bool:
        """Takes a finished picture, starts the next; whether there is a new one to draw."""
        self._dying = [job for job in self._dying if not job.poll()[1]]
        fresh = self._take()
        divisor = self._next()
        if self._job is None and divisor and self._failed != self.wanted:
            self._start(scene, divisor)
        return fresh

    @property
    def busy(self) -> bool:
        """Whether step() has more to do, now or after a rest."""
        waiting = self.wanted is not None and self.wanted != self._failed and not self.finished
        return self._job is not None or bool(self._dying) or waiting

    @property
    def finished(self) -> bool:
        """Whether the picture is what is wanted, at full resolution."""
        done = self.picture
        return done is not None and done.want == self.wanted and done.divisor == 1

    def _next(self) -> int:
        """The divisor to trace at now; 0: none."""
        if self.wanted is None or self.finished:
            return 0
        shown = self.picture if self.picture and self.picture.want == self.wanted else None
        if shown is None:
            return self._coarse()
        if time.monotonic() - self.moved < REST:
            return 0
        return next(divisor for divisor in DIVISORS if divisor < shown.divisor)

    def _coarse(self) -> int:
        """The finest divisor that keeps up with a moving view."""
        if not self._pace:
            return FIRST
        width, height = self.wanted.view.size
        pace = self._pace * width * height
        fitting = [divisor for divisor in DIVISORS if pace / divisor**2 <= PATIENCE]
        return fitting[-1] if fitting else DIVISORS[0]

    def _start(self, scene: Any, divisor: int) -> None:
        want = self.wanted
        settings = dict(want.settings) | {"passes": want.choice.passes()}
        if want.choice.row.mode:
            settings["mode"] = want.choice.row.mode
        try:
            self._job = scene.start(want.view.camera(divisor), settings)
        except (ValueError, RuntimeError, MemoryError, np.linalg.LinAlgError) as error:
            self._fail(want, error)
            return
        self._traced, self._first = (want, divisor), divisor == self._coarse()

    def _take(self) -> bool:
        if self._job is None or not self._job.poll()[1]:
            return False
        job, (want, divisor) = self._job, self._traced
        self._job = self._traced = None
        try:
            image = job.result()
        except (ValueError, RuntimeError, MemoryError) as error:
            self._fail(want, error)
            return True
        self.picture, self.error, self._failed = picture(want, divisor, image), "", None
        self._pace = self.picture.seconds / self.picture.values.size
        return True

    def _fail(self, want: Want, error: BaseException) -> None:
        """Keeps the reason; the same is not tried again."""
        self.error, self._failed, self.picture = str(error) or type(error).__name__, want, None
