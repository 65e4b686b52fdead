# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws docs/benchmarks.md and its plot from the benchmark's records."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

DOCS = Path(__file__).resolve().parents[1]
KINDS = ("primary", "shadow", "mirror", "random")
SIDES = (
    ("whittle", "Whittle", "#2a6f97"),
    ("embree", "Embree, its best mode", "#c98c3a"),
    ("single", "Embree, single rays", "#e3cfa8"),
)

Record = dict[str, Any]

INTRODUCTION = """\
# Benchmarks

Whittle and Embree {version} build the same meshes and trace exactly the same rays, in one run of

    make bench

which also redraws this page. The machine: {processor}, {threads} threads, instruction set
{isa}; its load before the run was {load}. Ratios above 1 mean that Whittle is faster.

![Millions of rays a second, by scene and kind of ray](pictures/benchmarks.png)

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
  fastest mode: single rays, or packets with or without its coherent flag.
- *Primary*: one ray through each pixel. *Shadow*: from each primary hit to one point light, any
  hit. *Mirror*: from each primary hit along the mirrored direction of the smooth normal. *Random*:
  from points in the mesh's box in all directions. Primary rays come in blocks of 4 x 4, 16 x 16
  and 32 x 32 pixels; shadow and mirror rays are in the same order, without those that missed.
- Both sides read the rays from the same arrays and write t, triangle, u and v (shadow: one byte)
  to arrays of their own. Whittle gets each stream in one call and rebases its rays from world
  space in double precision; Embree gets its packets filled from the arrays, and its threads take
  chunks of 4096 rays. Both costs are part of the figures.
- *Build* counts the building call alone: `whittle_scene_build`, which also flattens and rebases,
  and `rtcCommitScene`. Neither the copying of the caller's arrays nor the release is in it.
- A *mismatch* is a ray that hits on one side only, or whose t differs by more than 1e-4 of itself.
  Embree's default is not watertight, so a few rays at edges differ.
- *Cycles* are those of one core: the clock is timed by a chain of dependent additions right before
  and after the measurement, because virtual machines have no counters to ask.
"""


def build_table(records: list[Record]) -> str:
    """Speed of the build and size of what it leaves."""
    lines = [
        "| threads | Whittle, Mtri/s | Embree | ratio | spread | Whittle, bytes/tri | Embree |",
        "|" + " ---: |" * 7,
    ]
    for r in records:
        sizes = [r[f"{side}_bytes"] / r["triangles"] for side in ("whittle", "embree")]
        lines.append(
            f"| {r['threads']} | {r['whittle']:.2f} | {r['embree']:.2f} | {r['ratio']:.2f} |"
            f" {r['spread']:.0%} | {sizes[0]:.0f} | {sizes[1]:.0f} |"
        )
    return "\n".join(lines) + "\n"


def trace_table(records: list[Record]) -> str:
    """Millions of rays a second by kind and threads."""
    lines = [
        "| kind | threads | Whittle | Embree best | mode | ratio | spread | Embree single | ratio |"
        + " Whittle cycles | Embree cycles | rays | mismatches |",
        "| --- | ---: | ---: | ---: | --- |" + " ---: |" * 8,
    ]
    for r in records:
        cycles = [f"{r[k]:.0f}" if k in r else "" for k in ("whittle_cycles", "embree_cycles")]
        lines.append(
            f"| {r['kind']} | {r['threads']} | {r['whittle']:.1f} | {r['embree']:.1f} |"
            f" {r['embree_mode']} | {r['ratio']:.2f} | {r['spread']:.0%} |"
            f" {r['embree_modes']['1']:.1f} | {r['ratio_single']:.2f} | {cycles[0]} | {cycles[1]} |"
            f" {r['rays']} | {r['mismatches']} |"
        )
    return "\n".join(lines) + "\n"


def page(records: list[Record]) -> str:
    """The whole page."""
    first = records[0]
    quality = first["embree_quality"]
    parts = [
        INTRODUCTION.format(
            version=first["embree_version"],
            processor=first["processor"],
            threads=max(r["threads"] for r in records),
            isa=first["isa"],
            load=first["load"],
        )
    ]
    for scene in dict.fromkeys(r["scene"] for r in records):
        own = [r for r in records if r["scene"] == scene]
        parts.append(f"## {scene}, {own[0]['triangles']:,} triangles\n\nTracing, Mrays/s:\n\n")
        parts.append(trace_table([r for r in own if r["kind"] != "build"]) + "\nBuilding:\n\n")
        parts.append(build_table([r for r in own if r["kind"] == "build"]) + "\n")
    default = "its default" if quality == "medium" else "not its default"
    parts.append(METHOD.format(quality=quality, default=default, rounds=first["rounds"]))
    return "".join(parts)


def draw_scene(axes: plt.Axes, records: list[Record]) -> None:
    """Bars for each kind of ray: Whittle, Embree's best, Embree's single rays; one thread."""
    for place, (key, label, colour) in enumerate(SIDES):
        values = [r["embree_modes"]["1"] if key == "single" else r[key] for r in records]
        places = [i + (place - 1) * 0.27 for i in range(len(records))]
        bars = axes.bar(places, values, 0.26, label=label, color=colour)
        axes.bar_label(bars, fmt="%.1f", fontsize=7, padding=1)
    axes.set_xticks(range(len(records)), [f"{r['kind']}\n{r['ratio']:.2f} ×" for r in records])
    axes.set_title(f"{records[0]['scene']}, {records[0]['triangles']:,} triangles", fontsize=10)
    axes.spines[["top", "right"]].set_visible(False)
    axes.margins(y=0.12)


def plot(records: list[Record], path: Path) -> None:
    """One panel a scene, one thread, written as PNG."""
    alone = [r for r in records if r["threads"] == 1 and r["kind"] in KINDS]
    scenes = list(dict.fromkeys(r["scene"] for r in alone))
    size = (4.6 * len(scenes), 3.8)
    figure, panels = plt.subplots(1, len(scenes), figsize=size, squeeze=False)
    for axes, scene in zip(panels[0], scenes, strict=True):
        draw_scene(axes, [r for r in alone if r["scene"] == scene])
    panels[0][0].set_ylabel("millions of rays a second, one thread")
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=3, frameon=False, fontsize=9)
    figure.suptitle("× is Whittle over Embree's best mode", fontsize=9, x=0.99, ha="right")
    figure.tight_layout(rect=(0, 0.07, 1, 1))
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)


def main() -> None:
    """Reads the records that bench.py wrote."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("records", type=Path, help="the benchmark's JSON file")
    parser.add_argument("--out", type=Path, default=DOCS, help="the folder of the page")
    arguments = parser.parse_args()
    records = json.loads(arguments.records.read_text())
    plot(records, arguments.out / "pictures" / "benchmarks.png")
    (arguments.out / "benchmarks.md").write_text(page(records))
    print(f"Page: {arguments.out / 'benchmarks.md'}")


if __name__ == "__main__":
    main()
