# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a picture is from the truth, and what each step towards it costs."""

from __future__ import annotations

import math
import statistics
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from capture import Shot
from numpy.typing import NDArray

Image = NDArray[np.float32]

SAMPLES = (1, 4, 16, 64)
DEPTHS = (1, 2, 4, 8)
STEP = 1 / 255  # of an 8-bit picture

#: The reference is the mean of two halves, so that their difference tells its own error.
HALVES = ({"seed": 101}, {"seed": 202})
REFERENCE = {
    "pattern": "stratified",
    "samples": 576,
    "max_depth": 16,
    "cutoff": 2.0**-16,
    "mode": "single",  # the same bits, and quickest where neighbouring rays have little in common
}


@dataclass
class Reference:
    """The picture that others are measured against (RGB), and what is known of it."""

    picture: Image
    samples: int
    own_error: float  # RMSE in linear light, from the difference of its halves
    seconds: float


@dataclass
class Row:
    """One setting: its distance from the reference, and the wall time of each phase (s)."""

    pattern: str
    samples: int
    depth: int
    rmse: float  # linear light
    rmse_shown: float  # the same after clipping to [0, 1], as a display does
    p99: float  # what 99 % of the pixels' largest channel errors stay below
    wrong: float  # share of the pixels that are off by more than 1/255 in a channel
    export: float
    build: float
    trace: float
    shade: float
    rays: int

    @property
    def seconds(self) -> float:
        return self.export + self.build + self.trace + self.shade


def progress(text: str) -> None:
    print(f"whittle: {text}", file=sys.stderr, flush=True)


def make_reference(scene: Any, shot: Shot) -> Reference:
    """The mean of two independent stratified pictures of a built scene."""
    began = time.perf_counter()
    halves = []
    for half in HALVES:
        progress(f"reference, half {len(halves) + 1} of {len(HALVES)}")
        halves.append(scene.render(shot.camera, shot.settings | REFERENCE | half)["combined"])
    a, b = (half[..., :3].astype(np.float64) for half in halves)
    return Reference(
        picture=((a + b) / 2).astype(np.float32),
        samples=REFERENCE["samples"] * len(HALVES),
        own_error=rmse(a, b) / 2,
        seconds=time.perf_counter() - began,
    )


def rmse(a: Image, b: Image) -> float:
    """Root of the mean squared difference, all channels alike."""
    return math.sqrt(np.square(np.subtract(a, b, dtype=np.float64)).mean())


def sweep(
    scene: Any, shot: Shot, reference: Reference, fixed: tuple[float, float], rounds: int
) -> Iterator[Row]:
    """Every setting against the reference; ``fixed`` is what export and build took (s)."""
    settings = [("regular", samples, depth) for depth in DEPTHS for samples in SAMPLES]
    settings += [("stratified", samples, DEPTHS[-1]) for samples in SAMPLES]
    for pattern, samples, depth in settings:
        progress(f"{pattern}, {samples} samples, depth {depth}")
        chosen = {"pattern": pattern, "samples": samples, "max_depth": depth, "seed": 7}
        results = [scene.render(shot.camera, shot.settings | chosen) for _ in range(rounds)]
        picture = results[0]["combined"][..., :3]
        phases = [split(result["stats"]) for result in results]
        away = np.abs(picture - reference.picture).max(axis=-1)
        yield Row(
            pattern=pattern,
            samples=samples,
            depth=depth,
            rmse=rmse(picture, reference.picture),
            rmse_shown=rmse(np.clip(picture, 0, 1), np.clip(reference.picture, 0, 1)),
            p99=float(np.percentile(away, 99)),
            wrong=float((away > STEP).mean()),
            export=fixed[0],
            build=fixed[1],
            trace=statistics.median(trace for trace, _ in phases),
            shade=statistics.median(shade for _, shade in phases),
            rays=sum(results[0]["stats"]["rays"].values()),
        )


def split(stats: dict[str, Any]) -> tuple[float, float]:
    """A render's wall time as (trace, shade), in the ratio of its threads' summed times."""
    shade = stats["seconds_shade"]
    trace = stats["seconds_primary"] + stats["seconds_shadow"] + stats["seconds_secondary"]
    share = shade / (shade + trace) if shade + trace > 0 else 0.0
    return stats["seconds"] * (1 - share), stats["seconds"] * share
