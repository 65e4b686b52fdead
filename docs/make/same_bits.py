# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings that may change how long a picture takes, but not one of its bits."""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import capture
import studio
from error import progress

PASSES = ("combined", "depth", "position", "normal", "object_index")
SAMPLES = 4

#: What changes, and how: (setting, value, arguments of build, settings of render).
VARIANTS: tuple[tuple[str, str, dict[str, Any], dict[str, Any]], ...] = (
    *(("threads", str(n), {"threads": n}, {"threads": n}) for n in (1, 2, 3, 7)),
    *(("packet", str(n), {}, {"packet": n}) for n in (1, 16, 64, 256, 1024)),
    *(("mode", name, {}, {"mode": name}) for name in ("fast", "lecture", "single")),
    *(("bins", str(n), {"bins": n}, {}) for n in (8, 16, 32)),
    *(("largest leaf", str(n), {"max_leaf": n}, {}) for n in (1, 4, 16)),
    ("traversal cost", "2", {"traversal_cost": 2.0}, {}),
    ("kernel", "generic", {}, {"generic": True}),
    ("heatmaps", "on", {}, {"passes": (*PASSES, "nodes", "triangles")}),
    ("again", "", {}, {}),
)


@dataclass
class Row:
    """A picture's digest under one setting, and what it took (s)."""

    setting: str
    value: str
    digest: str
    build: float
    render: float


def digest(scene: Any, shot: capture.Shot, changes: dict[str, Any]) -> tuple[str, float]:
    """A hash of every bit of the passes, and the seconds that the render took."""
    settings = shot.settings | {"passes": PASSES, "samples": SAMPLES} | changes
    result = scene.render(shot.camera, settings)
    sha = hashlib.sha256()
    for name in PASSES:
        sha.update(result[name].tobytes())
    return sha.hexdigest(), result["stats"]["seconds"]


def run(shot: capture.Shot) -> Iterator[Row]:
    """Every variant in this process."""
    scene = shot.scene()
    built: dict[str, Any] | None = None
    seconds = 0.0
    for setting, value, build, settings in VARIANTS:
        progress(f"same bits: {setting} {value}")
        if build != built:
            seconds, built = scene.build(**build)["seconds"], build
        found, took = digest(scene, shot, settings)
        yield Row(setting, value, found, seconds, took)


def run_isas(core: Any, path: Path | None, percent: int) -> Iterator[Row]:
    """Every instruction set that this machine has, each in a process of its own."""
    for isa in core.isas():
        progress(f"same bits: instruction set {isa}")
        command = [sys.executable, __file__, "--percent", str(percent)]
        command += ["--scene", str(path)] if path else []
        done = subprocess.run(
            command, env=os.environ | {"WHITTLE_ISA": isa}, capture_output=True, text=True
        )
        if done.returncode != 0:
            raise RuntimeError(f"WHITTLE_ISA={isa} failed: {done.stderr.strip()[-500:]}")
        found = json.loads(done.stdout.strip().splitlines()[-1])
        if found["isa"] != isa:
            raise RuntimeError(f"WHITTLE_ISA={isa} was asked for and {found['isa']} ran")
        yield Row("instruction set", isa, found["digest"], found["build"], found["render"])


def main() -> None:
    """Print the digest under this process's instruction set as one line of JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", type=Path)
    parser.add_argument("--percent", type=int, default=100)
    arguments = parser.parse_args()
    studio.register()
    scene = studio.open_scene(arguments.scene)
    scene.render.resolution_percentage = arguments.percent
    shot = capture.shot(scene)
    core_scene = shot.scene()
    began = time.perf_counter()
    core_scene.build()
    build = time.perf_counter() - began
    found, took = digest(core_scene, shot, {})
    print()
    print(json.dumps({"isa": shot.core.isa(), "digest": found, "build": build, "render": took}))


if __name__ == "__main__":
    main()
