# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The last render's numbers, counts and notes, kept for panels, heatmaps and batch runs."""

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .cost.measured import Measured

TRACING = ("primary", "shadow", "secondary", "shade")
"""What the threads of a render do: trace rays of each kind, and the rest."""


@dataclass
class Result:
    """One view layer of one frame. Times are wall time in seconds; "judge" is there if the render
    counted, "write" in batch runs."""

    scene: str
    layer: str
    frame: int
    size: tuple[int, int]  # of the pixels rendered
    seconds: dict[str, float]  # by phase: export, build, trace, judge, hand_over, write
    build: dict[str, Any]  # as Scene.build gives it
    render: dict[str, Any]  # as Scene.render gives it under "stats"
    notes: list[str]
    counters: dict[str, np.ndarray] = field(default_factory=dict)  # source -> (h, w) float32
    cost: Measured | None = None  # of a render that counted
    settings: dict[str, Any] = field(default_factory=dict)  # by their names in the scene

    def rays(self) -> int:
        """How many rays were traced, of all kinds."""
        return sum(self.render["rays"].values())

    def tracing(self) -> dict[str, float]:
        """The seconds of "trace" by what its threads did meanwhile; shade is all but the rays."""
        spent = {name: self.render[f"seconds_{name}"] for name in TRACING}
        total = sum(spent.values())
        if total <= 0:
            return dict.fromkeys(TRACING, 0.0)
        return {name: self.seconds["trace"] * own / total for name, own in spent.items()}

    def rays_per_second(self) -> float:
        return self.rays() / self.seconds["trace"] if self.seconds["trace"] > 0 else 0.0

    def to_dict(self) -> dict[str, Any]:
        """Everything but the counts, fit for JSON."""
        names = ("scene", "layer", "frame", "size", "seconds", "build", "render", "notes")
        return {name: getattr(self, name) for name in names} | {
            "rays": self.rays(),
            "rays_per_second": self.rays_per_second(),
            "tracing": self.tracing(),
        }


last: list[Result] = []
"""The view layers of the last frame rendered; empty before the first one."""

listeners: list[Callable[[Result], None]] = []
"""Called with each view layer that was rendered, on the thread that renders."""


def store(result: Result) -> None:
    """Adds a view layer to the frame at hand, or starts the next frame with it."""
    same = last and (last[0].scene, last[0].frame) == (result.scene, result.frame)
    if not same or any(other.layer == result.layer for other in last):
        last.clear()
    last.append(result)
    for listener in listeners:
        listener(result)


def to_json(results: list[Result]) -> str:
    """Results as JSON text, a view layer each."""
    return json.dumps([result.to_dict() for result in results], indent=2, default=_plain) + "\n"


def _plain(value: Any) -> Any:
    """Numbers and arrays of numpy as Python's own."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no place in the statistics")
