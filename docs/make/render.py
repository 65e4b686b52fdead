# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders a scene through Blender with Whittle: picture, heatmaps, passes, numbers, one table."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import bpy
import studio

from addon import batch, heat, passes, progress, results

KINDS = ("primary", "shadow", "reflection", "refraction")
ALWAYS = ("use_pass_z", "use_pass_position", "use_pass_normal", "use_pass_object_index")


def make(path: Path | None, out: Path) -> list[tuple[str, str]]:
    """Render into the folder ``out``; gives the rows of the table."""
    studio.register()
    scene = studio.open_scene(path)
    scene.render.engine = "WHITTLE"
    out.mkdir(parents=True, exist_ok=True)
    picture = studio.png(scene, out / "picture")
    fast = _render(scene, "picture", counters=False)
    for layer in scene.view_layers:
        for name in ALWAYS:
            setattr(layer, name, True)
    every_pass = studio.multilayer(scene, out / "passes")
    counted = _render(scene, "heatmaps", counters=True)
    maps = list(_heatmaps(scene, counted, out))
    statistics = out / "statistics.json"
    statistics.write_text(results.to_json(fast + counted), encoding="utf-8")
    files = [("picture", str(picture)), ("heatmaps", f"{out}/heat_*.png ({len(maps)})")]
    files += [("passes", str(every_pass)), ("statistics", str(statistics))]
    return [row for result in fast for row in _rows(result, studio.name_of(path))] + files


def _render(scene: bpy.types.Scene, title: str, counters: bool) -> list[results.Result]:
    """One frame, its file written, with a line of progress; the results of its view layers."""
    scene.whittle.use_counters = counters
    results.last.clear()
    with _progress(title):
        bpy.ops.render.render(write_still=True, scene=scene.name)
    if not results.last:
        raise RuntimeError("the render was cancelled")
    return list(results.last)


@contextmanager
def _progress(title: str) -> Iterator[Callable[[str, float], None]]:
    line = batch.ProgressLine(title)
    progress.listeners.append(line)
    try:
        yield line
    finally:
        progress.listeners.remove(line)
        line.end()


def _heatmaps(scene: bpy.types.Scene, counted: list[results.Result], out: Path) -> Iterator[Path]:
    settings = scene.whittle
    top = settings.heat_max if settings.heat_range == "FIXED" else None
    for result in counted:
        layer = f"_{bpy.path.clean_name(result.layer)}" if len(counted) > 1 else ""
        for row in passes.counted(result.counters):
            path = out / f"heat_{row.source}{layer}.png"
            heat.write(str(path), heat.draw(result, row.source, settings.heat_map, top))
            yield path


def _rows(result: results.Result, name: str) -> list[tuple[str, str]]:
    """What the table says of one view layer."""
    build, render, seconds = result.build, result.render, result.seconds
    width, height = result.size
    rows = [
        ("scene", f"{name}, {result.layer}, {width} x {height}"),
        ("triangles", f"{build['triangles']:,} in {build['instances']:,} objects"),
        ("BVH", f"{build['nodes']:,} nodes, depth {build['depth']}, cost {build['sah_cost']:.1f}"),
        ("export", f"{seconds['export']:.2f} s"),
        ("build", f"{seconds['build']:.2f} s on {build['threads']} threads"),
        ("trace", f"{seconds['trace']:.2f} s on {render['threads']} threads"),
    ]
    rows += [(f"  {name}", f"{spent:.2f} s") for name, spent in result.tracing().items()]
    rows.append(("hand over", f"{seconds['hand_over']:.2f} s"))
    rows += [(f"{kind} rays", f"{render['rays'][kind]:,}") for kind in KINDS]
    rows.append(("all rays", f"{result.rays():,}: {result.rays_per_second() / 1e6:.2f} Mrays/s"))
    rows += [("left out", text) for text in _left_out(render)]
    return rows + [("note", line) for line in result.notes]


def _left_out(render: dict[str, Any]) -> list[str]:
    return [f"{name}: {reason}" for name, reason in render["left_out"]]


def table(rows: list[tuple[str, str]]) -> str:
    """Rows as text, what they are called on the left."""
    width = max(len(name) for name, _ in rows)
    return "\n".join(f"{name:<{width}}  {text}" for name, text in rows)


def main() -> int:
    """Exit codes: 0 everything is there, 1 something went wrong and stderr says what."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", type=Path, help="a .blend file; default: the demo scene")
    parser.add_argument("--out", type=Path, default=Path("out"), help="a folder; default: out")
    arguments = parser.parse_args()
    try:
        rows = make(arguments.scene, arguments.out)
    except (RuntimeError, ValueError, OSError) as error:
        print(f"whittle: {str(error).strip()}", file=sys.stderr)
        return 1
    print(f"\n{table(rows)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
