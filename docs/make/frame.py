# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole frames, and the reading of a large mesh, with Whittle and Cycles in turns: a JSON file."""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import bpy
import cycles_setup
import numpy as np
import studio

BOUNCES = 8
SIZE = (1280, 800)
LARGE = (1000, 500)  # cells of the mesh that is read: a million triangles
ENGINES = ("whittle", "cycles")
RUNS = (*ENGINES, "alone")  # the last: Whittle on one thread
SHARES = ("primary", "shadow", "secondary", "shade")

#: What the engines' status lines say when a phase begins.
MARKS = {
    "build": ("Building the BVH", "Building BVH"),
    "trace": ("Tracing rays", "Sample 0/"),
    "done": ("Finished",),
}


class Watch:
    """Notes when the status line of a render first says that a phase begins (s, perf_counter)."""

    def __init__(self) -> None:
        self.seen: dict[str, float] = {}
        self.saving = 0.0

    def __call__(self, text: str, *_: Any) -> None:
        for name, marks in MARKS.items():
            if name not in self.seen and any(mark in text for mark in marks):
                self.seen[name] = time.perf_counter()
        saving = re.search(r"Saving: (\d+):(\d+\.\d+)", text)
        if saving:
            self.saving = 60 * int(saving[1]) + float(saving[2])

    def __enter__(self) -> Watch:
        bpy.app.handlers.render_stats.append(self)
        return self

    def __exit__(self, *_: Any) -> None:
        bpy.app.handlers.render_stats.remove(self)


def choose(scene: bpy.types.Scene, engine: str, samples: int) -> None:
    """Both engines with the same samples and bounces; "alone" is Whittle on one thread."""
    scene.render.threads_mode = "FIXED" if engine == "alone" else "AUTO"
    scene.render.threads = 1
    if engine == "cycles":
        cycles_setup.use(scene, samples, BOUNCES)
        return
    scene.render.engine = "WHITTLE"
    scene.whittle.samples, scene.whittle.max_depth = samples, BOUNCES
    scene.whittle.use_counters = False


def render(scene: bpy.types.Scene, engine: str, samples: int, write: bool = True) -> dict[str, Any]:
    """One render: seconds from its start by phase, and what Whittle counted."""
    from addon import results

    choose(scene, engine, samples)
    with Watch() as watch:
        began = time.perf_counter()
        bpy.ops.render.render(write_still=write, scene=scene.name)
        ended = time.perf_counter()
    seen = watch.seen
    row = {
        "read": seen["build"] - began,
        "build": seen["trace"] - seen["build"],
        "write": watch.saving,
        "total": ended - began,
    }
    if engine == "cycles":
        return row | {"trace": seen["done"] - seen["trace"]}
    last = results.last[-1]
    own = {key: last.seconds[key] for key in ("export", "build", "trace")}
    return row | own | {"stats": last.render, "triangles": last.build["triangles"]}


def progress(text: str) -> None:
    print(f"frame: {text}", file=sys.stderr, flush=True)


def clock(program: Path | None) -> float | None:
    """The clock of a core right now, in GHz, by the benchmark's program; None without one."""
    if program is None:
        return None
    found = subprocess.run([program, "--clock"], capture_output=True, text=True, check=True)
    return json.loads(found.stdout)["gigahertz"]


def frames(
    path: Path | None, size: list[int], samples: int, rounds: int, program: Path | None
) -> dict[str, Any]:
    """The scene's frame, with so many samples a pixel, by both engines and by Whittle on one
    thread, in turns.

    A render of one sample each warms up before; many samples take long and run a round less.
    """
    rounds = max(1, rounds - (samples > 1))
    scene = studio.open_scene(path)
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    seconds: dict[str, dict[str, list[float]]] = {name: {} for name in RUNS}
    clocks, last = [], {}
    with tempfile.TemporaryDirectory() as folder:
        studio.png(scene, Path(folder) / "frame")
        for round_ in range(rounds + 1):
            progress(f"{samples} samples, round {round_} of {rounds}")
            clocks.append(clock(program))
            for name in RUNS if round_ % 2 else reversed(RUNS):
                row = render(scene, name, samples if round_ else 1)
                counts = {key: row.pop(key) for key in ("stats", "triangles") if key in row}
                last |= counts if name == "whittle" else {}
                for phase, value in row.items() if round_ else ():  # the first warms up
                    seconds[name].setdefault(phase, []).append(value)
    stats = last["stats"]
    return {
        "samples": samples,
        "rounds": rounds,
        "triangles": last["triangles"],
        "threads": stats["threads"],
        "rays": stats["rays"],
        "share": {key: stats[f"seconds_{key}"] for key in SHARES},
        "gigahertz": None if program is None else float(np.median(clocks)),
        "seconds": seconds,
    }


def grid(columns: int, rows: int, corners: int) -> bpy.types.Mesh:
    """Smooth waves of columns x rows cells: quads, or two triangles each."""
    x, y = np.meshgrid(np.linspace(-2, 2, columns + 1), np.linspace(-1, 1, rows + 1))
    points = np.stack([x, y, 0.1 * np.sin(9 * x) * np.cos(7 * y)], axis=-1).astype(np.float32)
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).reshape(-1, 1)
    right, up = 1, columns + 1
    cell = (0, right, up + right, up) if corners == 4 else (0, right, up + right, 0, up + right, up)
    vertices = (first + np.array(cell)).astype(np.int32).reshape(-1)
    mesh = bpy.data.meshes.new("Waves")
    mesh.vertices.add(points.size // 3)
    mesh.vertices.foreach_set("co", points.reshape(-1))
    mesh.loops.add(len(vertices))
    mesh.loops.foreach_set("vertex_index", vertices)
    mesh.polygons.add(len(vertices) // corners)
    starts = np.arange(0, len(vertices), corners, dtype=np.int32)
    mesh.polygons.foreach_set("loop_start", starts)
    mesh.update(calc_edges=True)
    mesh.shade_smooth()
    return mesh


def large_scene(corners: int) -> bpy.types.Scene:
    """One mesh of a million triangles and a camera over it."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    for name, data in (
        ("Waves", grid(*LARGE, corners)),
        ("Camera", bpy.data.cameras.new("Camera")),
    ):
        item = bpy.data.objects.new(name, data)
        scene.collection.objects.link(item)
    scene.camera = item
    item.location = (0.0, 0.0, 4.0)
    scene.render.resolution_x, scene.render.resolution_y = 64, 40
    return scene


def reading(corners: int, rounds: int) -> dict[str, Any]:
    """Seconds until the build begins, from the render's start; Whittle's export by itself too."""
    scene = large_scene(corners)
    seconds: dict[str, list[float]] = {"whittle": [], "cycles": [], "export": []}
    for round_ in range(rounds + 1):
        progress(f"a million triangles, {corners} corners a face, round {round_} of {rounds}")
        for name in ENGINES if round_ % 2 else reversed(ENGINES):
            row = render(scene, name, 1, write=False)
            if round_:
                seconds[name].append(row["read"])
                seconds["export"] += [row["export"]] if name == "whittle" else []
    return {"corners": corners, "triangles": 2 * LARGE[0] * LARGE[1], "seconds": seconds}


def main() -> int:
    """Exit codes: 0 written, 1 something went wrong and stderr says what."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("json", type=Path, help="where the figures go")
    parser.add_argument("--scene", type=Path, help="a .blend file; default: the demo scene")
    parser.add_argument("--rounds", type=int, default=3, help="of each measurement")
    parser.add_argument("--samples", type=int, nargs="+", default=[1, 16], help="a pixel")
    parser.add_argument("--size", type=int, nargs=2, default=SIZE, help="width and height")
    parser.add_argument("--program", type=Path, help="the benchmark's, to ask for the clock")
    arguments = parser.parse_args()
    try:
        studio.register()
        path, size, rounds = arguments.scene, arguments.size, arguments.rounds
        program = arguments.program
        found = {
            "scene": studio.name_of(arguments.scene),
            "blender": bpy.app.version_string,
            "bounces": BOUNCES,
            "size": size,
            "frames": [frames(path, size, n, rounds, program) for n in arguments.samples],
            "reading": [reading(corners, rounds) for corners in (4, 3)],
        }
        arguments.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    except (RuntimeError, ValueError, OSError, KeyError) as error:
        print(f"whittle: {str(error).strip()}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
