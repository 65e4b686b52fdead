# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws docs/benchmarks.md and its plots from the benchmark's records."""

from __future__ import annotations

import argparse
import json
import math
import textwrap
from pathlib import Path
from typing import Any

import bench_plots
from bench_summary import KINDS, cycles_a_ray, medians, summary, thread_gain

DOCS = Path(__file__).resolve().parents[1]
LECTURE = 37.5  # Mrays/s a core: J. Bikker, "Accelerate" (INFOGR, 2016) has 300 on 8 cores
RAYS = {"primary": "one ray through each pixel", "shadow": "any hit, from each primary hit to one "
        "point light", "mirror": "from each primary hit along the mirrored direction",
        "random": "from points in the mesh's box in all directions"}  # fmt: skip

Record = dict[str, Any]

INTRODUCTION = """\
# Benchmarks

Whittle and Embree {version} build the same meshes and trace exactly the same rays, in one run of

    make bench

which also redraws this page. The machine: {processor}, {threads} threads, instruction set
{isa}; its load before the run was {load}. Ratios above 1 mean that Whittle is faster.

"""

PICTURE = """
![Millions of rays a second, by kind of ray and scene](pictures/benchmarks.png)

"""

GROWTH = """\
## Growth

The same hills in ever smaller triangles, {low:,} to {high:,} of them; one thread. The dashed line
is what log N predicts from the first point, the dotted one the nodes of the binary tree that a
primary ray visits by itself, which is what grows with log N. What time grows beyond that is for
memory, as the structures outgrow the caches, and for packets whose rays part ways where triangles
become smaller than pixels.

![Time per ray and per triangle against the number of triangles](pictures/growth.png)

"""

FRAME = """\
## Whole frames

The scene {scene} ({triangles:,} triangles) at {width} x {height} in Blender {blender}, with all
threads, by Whittle and by Cycles (CPU) in turns: the same file, samples and bounces ({bounces}),
sharp lights, no light from diffuse surfaces to others. Medians in seconds, from the start of the
render to its end; reading is the time until the build of the BVH begins, writing that of the PNG
file, as Blender tells it. `docs/make/frame.py` measures this part.

"""

READING = """\
## Reading a large mesh

One mesh of {triangles:,} triangles: seconds from the start of the render until the status line
says that the BVH is being built, in turns. *Export* is Whittle's part of it: from the depsgraph to
the core's arrays.

"""

METHOD = """\
## How it is measured

- The program is `native/bench/`. It calls Whittle through `whittle.h`, and the Embree library of
  the `embreex` wheel through its C interface. Embree has one triangle mesh with shared buffers
  and its {quality} build quality, which is {default}, and runs with the instruction set that
  Whittle runs with.
- In each of {rounds} rounds Whittle and every mode of Embree run once, and who starts changes
  from round to round. Figures are medians of the rounds; ratios are ratios of medians. *Spread*
  is the distance of the quartiles of the rounds' ratios over their median. *Best* is Embree's
  fastest mode: single rays, packets of 8 or of 16, with or without its coherent flag. Without
  AVX-512 Embree splits packets of 16. *Robust* and *high* are Embree's other builds, traced in the
  same rounds with the mode that was best in a trial, by one thread.
- Shadow and mirror rays start from the primary rays' hits and are in their order, without those
  that missed; mirrored is the smooth normal. Primary rays come in blocks of 4 x 4, 16 x 16 and
  32 x 32 pixels.
- Both sides read the rays from the same arrays and write t, triangle, u and v (shadow: one byte)
  to arrays of their own. Whittle gets each stream in one call and rebases its rays from world
  space in double precision; Embree gets its packets filled from the arrays, and its threads take
  chunks of 4096 rays. Both costs are part of the figures.
- *Build* counts the building call alone: `whittle_scene_build`, which also flattens and rebases,
  and `rtcCommitScene`. Neither the copying of the caller's arrays nor the release is in it.
  Bytes are those of the finished structures beside the mesh's own arrays; *to count* adds the
  binary tree, which only counters, heatmaps and the lecture's packets need.
- A *mismatch* is a ray that hits on one side only, or whose t differs by more than 1e-4 of itself.
  Embree's default is not watertight, so a few rays at edges differ.
- *Cycles* are those of one core: the clock is timed by a chain of dependent additions right before
  and after the measurement, because virtual machines have no counters to ask.
"""


def table(head: list[str], left: int, rows: list[list[str]]) -> str:
    """A Markdown table whose first ``left`` columns are text and whose others are numbers."""
    rule = ["---"] * left + ["---:"] * (len(head) - left)
    return "".join(f"| {' | '.join(cells)} |\n" for cells in (head, rule, *rows))


def summary_table(records: list[Record]) -> str:
    """Ratios over all scenes."""
    rows = [
        [row.kind, str(row.threads), str(row.scenes), f"{row.mean:.2f}", f"{row.least:.2f}",
         row.where, f"{row.most:.2f}"]
        for row in summary(records)
    ]  # fmt: skip
    head = ["kind", "threads", "scenes", "ratio, geometric mean", "least", "least in", "most"]
    return table(head, 1, rows)


def build_table(records: list[Record]) -> str:
    """Speed of the build and size of what it leaves."""
    head = ["scene", "triangles", "threads", "Whittle, Mtri/s", "Embree", "ratio", "spread"]
    rows = []
    for r in records:
        ours = r["whittle_bytes"]
        sizes = [ours, ours + r["whittle_bytes_binary"], r["embree_bytes"]]
        cells = [r["scene"], f"{r['triangles']:,}", str(r["threads"]), f"{r['whittle']:.2f}"]
        cells += [f"{r['embree']:.2f}", f"{r['ratio']:.2f}", f"{r['spread']:.0%}"]
        rows.append(cells + [f"{size / r['triangles']:.0f}" for size in sizes])
    return table([*head, "Whittle, bytes/tri", "to count", "Embree"], 1, rows)


def trace_table(records: list[Record]) -> str:
    """Millions of rays a second by scene and threads."""
    others = list(records[0].get("embree_builds", {}))
    head = ["scene", "threads", "Whittle", "Embree best", "mode", "ratio", "spread"]
    head += ["Embree single", "ratio", *(f"Embree {name}" for name in others)]
    head += ["Whittle cycles", "Embree cycles", "rays", "mismatches"]
    rows = []
    for r in records:
        cells = [r["scene"], str(r["threads"]), f"{r['whittle']:.1f}", f"{r['embree']:.1f}"]
        cells += [r["embree_mode"], f"{r['ratio']:.2f}", f"{r['spread']:.0%}"]
        cells += [f"{r['embree_modes']['1']:.1f}", f"{r['ratio_single']:.2f}"]
        builds = r.get("embree_builds", {})
        cells += [f"{builds[name]:.1f}" if name in builds else "" for name in others]
        cells += [f"{r[k]:.0f}" if k in r else "" for k in ("whittle_cycles", "embree_cycles")]
        rows.append([*cells, str(r["rays"]), str(r["mismatches"])])
    return table(head, 1, rows)


def scenes_part(records: list[Record]) -> str:
    """Summary, plot, and a table for each kind."""
    parts = [summary_table(records), PICTURE]
    for kind in KINDS:
        own = [r for r in records if r["kind"] == kind]
        if own and kind == "build":
            parts.append(f"## Building\n\n{build_table(own)}\n")
        elif own:
            parts.append(f"## {kind.title()} rays\n\nMrays/s: {RAYS[kind]}.\n\n")
            parts.append(trace_table(own) + "\n")
    return "".join(parts)


def growth_part(records: list[Record]) -> str:
    """What the plot of growth shows, and its figures."""
    counts = [r["triangles"] for r in records]
    own = [[r for r in records if r["kind"] == kind] for kind in ("primary", "build")]
    text = GROWTH.format(low=min(counts), high=max(counts)) + trace_table(own[0]) + "\n"
    return text + build_table(own[1]) + "\n"


def seconds_table(frame: Record) -> str:
    """Phases of a frame by both engines."""
    ours, theirs = (medians(frame["seconds"][engine]) for engine in ("whittle", "cycles"))
    names = {"read": "reading", "build": "building", "trace": "tracing", "write": "writing"}
    rows = [
        [name, f"{ours[phase]:.3f}", f"{theirs[phase]:.3f}", f"{theirs[phase] / ours[phase]:.2f}"]
        for phase, name in [*names.items(), ("total", "whole job")]
        if ours[phase] > 0
    ]
    count, rounds = frame["samples"], frame["rounds"]
    title = f"{count} sample{'s'[: count > 1]} a pixel, {rounds} round{'s'[: rounds > 1]}"
    head = [title, "Whittle", "Cycles", "Cycles / Whittle"]
    return table(head, 1, rows)


def rays_table(frame: Record) -> str:
    """Whittle's rays of a frame, and what they cost."""
    count = sum(frame["rays"].values())
    rows = [[kind, f"{n:,}", f"{n / count:.0%}"] for kind, n in frame["rays"].items()]
    seconds = medians(frame["seconds"]["whittle"])["trace"]
    rate = count / seconds / frame["threads"] / 1e6
    threads = sum(frame["share"].values())
    share = ", ".join(f"{name} {s / threads:.0%}" for name, s in frame["share"].items())
    cost = cycles_a_ray(frame, "trace")
    text = f"The tracing threads' time: {share}. "
    if not math.isnan(cost):
        text += f"{cost:.0f} cycles of a core a ray, everything of the tracing included, at "
        text += f"{frame['gigahertz']:.2f} GHz. "
    text += f"{rate:.1f} Mrays/s a core; the lecture's budget is {LECTURE}. "
    text += f"{frame['threads']} threads trace {thread_gain(frame):.2f} times as fast as one."
    lines = table(["rays", "", "share"], 1, [*rows, ["all", f"{count:,}", ""]])
    return f"{lines}\n{textwrap.fill(text, 100, break_on_hyphens=False)}\n"


def frame_part(found: Record) -> str:
    """Whole frames against Cycles, and the reading of a large mesh."""
    first = found["frames"][0]
    width, height = found["size"]
    size = {"width": width, "height": height, "triangles": first["triangles"]}
    text = FRAME.format(**found | size)
    for frame in found["frames"]:
        text += seconds_table(frame) + "\n" + rays_table(frame) + "\n"
    text += READING.format(triangles=found["reading"][0]["triangles"])
    rows = []
    for row in found["reading"]:
        read = medians(row["seconds"])
        faces = {4: "quads", 3: "triangles"}[row["corners"]]
        cells = [faces, *(f"{read[key]:.3f}" for key in ("export", "whittle", "cycles"))]
        rows.append([*cells, f"{read['whittle'] / read['cycles']:.2f}"])
    return text + table(["faces", "export", "Whittle", "Cycles", "ratio"], 1, rows) + "\n"


def page(found: Record) -> str:
    """The whole page."""
    records = found.get("records", []) + found.get("growth", [])
    first, machine = records[0], found["machine"]
    quality = first["embree_quality"]
    parts = [
        INTRODUCTION.format(
            version=first["embree_version"],
            processor=machine["processor"],
            threads=max(r["threads"] for r in records),
            isa=first["isa"],
            load=machine["load"],
        )
    ]
    for name, part in (("records", scenes_part), ("growth", growth_part), ("frame", frame_part)):
        if found.get(name):
            parts.append(part(found[name]))
    default = "its default" if quality == "medium" else "not its default"
    parts.append(METHOD.format(quality=quality, default=default, rounds=first["rounds"]))
    return "".join(parts)


def main() -> None:
    """Reads the records that bench.py wrote."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("records", type=Path, help="the benchmark's JSON file")
    parser.add_argument("--out", type=Path, default=DOCS, help="the folder of the page")
    arguments = parser.parse_args()
    found = json.loads(arguments.records.read_text())
    pictures = arguments.out / "pictures"
    if any(r["kind"] != "build" for r in found.get("records", [])):
        bench_plots.draw_scenes(found["records"], pictures / "benchmarks.png")
    if found.get("growth"):
        bench_plots.draw_growth(
            found["growth"], found["machine"]["caches"], pictures / "growth.png"
        )
    (arguments.out / "benchmarks.md").write_text(page(found))
    print(f"Page: {arguments.out / 'benchmarks.md'}")


if __name__ == "__main__":
    main()
