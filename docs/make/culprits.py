# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene with faults, what the cost table says of it, and the same scene mended: a page."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
import textwrap
from pathlib import Path
from typing import Any

import bad_scene
import bpy
import studio

DOCS = Path(__file__).resolve().parents[1]
TOP = 500  # visits that the last colour of both heatmaps stands for

PAGE = """\
# Finding what costs

This scene has {triangles:,} triangles; to trace {rays:,} rays in it and count took {seconds:.0f} s.

![A parasol, a rock, a mirror ball and trees](pictures/culprits.png)

What takes so long? The page, its scene and its pictures come from

    {command}

`whittle heatmap` counts {visits_before:,.0f} node visits and triangle tests for a pixel:

![Node visits of the scene with faults: the parasol burns](pictures/culprits_heat.png)

and `cost.json` says whose they are:

{before}

*Shared* are visits to nodes that hold triangles of several objects; **{stretched_by}** has most of
the fault that those are large. The hints give the reasons:

{hints}

So the parasol's cone was built from rings, the rock's lost triangle deleted, and the trees planted
apart. The picture above is that of the mended scene: only the trees look different. What is left is
{visits_after:,.0f} visits and tests for a pixel, and {seconds_after:.1f} s; in the same colours:

![Node visits of the mended scene](pictures/culprits_mended.png)

{after}

Two budgets would have refused the scene, with exit code 3 and the name of the object:

    blender -b scene.blend --command whittle heatmap --output cost \\
        --budget "nodes_p95<=120" --budget "sliver_share(*)<=0.25"

The SAH cost of the whole hierarchy went from {sah_before:.1f} to {sah_after:.1f} only. It is what a
random ray through the root's box is expected to pay, and the lost triangle had made that box so
large that most such rays met nothing. The rays that a picture needs cannot be fooled like that.
"""


def variant(mended: bool, size: bad_scene.Size, width: int, out: Path) -> dict[str, Any]:
    """Renders the scene with its heatmaps; gives its part of cost.json and its statistics."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "WHITTLE"
    scene.render.resolution_x, scene.render.resolution_y = width, width * 5 // 8
    scene.whittle.heat_range, scene.whittle.heat_max = "FIXED", TOP
    bad_scene.build(scene, size, mended)
    scene.whittle.samples = 1
    words = ["heatmap", "--output", str(out)]
    if not mended:
        words += ["--budget", "nodes_p95<=120", "--budget", "sliver_share(*)<=0.25"]
    code = command(words)
    if code != (0 if mended else 3):
        raise RuntimeError(f"the command ended with exit code {code}")
    (frame,) = json.loads((out / "cost.json").read_text())["frames"]
    (statistics,) = json.loads((out / "statistics_0001.json").read_text())
    if mended:
        scene.render.resolution_percentage = 200
        scene.whittle.samples = 16
        command(["render", "--output", str(out)])
    return frame | {"statistics": statistics}


def command(words: list[str]) -> int:
    """Runs Whittle's command in this process."""
    from addon import batch

    return batch.main(words)


def table(frame: dict[str, Any], most: int = 5) -> str:
    """The first rows by object."""
    lines = [
        "| object | count | triangles | of all work | visits | tests | memory | own SAH |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for row in frame["objects"][:most]:
        own = "" if row["sah_cost"] is None else f"{row['sah_cost']:,.0f}"
        shares = (row[name] for name in ("share", "node_share", "test_share", "memory_share"))
        numbers = " | ".join(f"{100 * share:.1f} %" for share in shares)
        count = "" if row["shared"] else f"{row['instances']:,} | {row['triangles']:,}"
        name = "*shared*" if row["shared"] else row["name"]
        lines.append(f"| {name} | {count or ' | '} | {numbers} | {own} |")
    return "\n".join(lines)


def hints(frame: dict[str, Any]) -> str:
    """An item of a list for each hint of each object."""
    items = [
        f"- **{row['name']}**: {hint['text']}; {hint['mend']}."
        for row in frame["objects"]
        for hint in row["hints"]
    ]
    wrap = textwrap.TextWrapper(100, subsequent_indent="  ", break_on_hyphens=False)
    return "\n".join(map(wrap.fill, items))


def work(frame: dict[str, Any]) -> float:
    """Visits and tests for a pixel."""
    metrics = frame["metrics"]
    return metrics["nodes_mean"] + metrics["triangles_mean"]


def page(before: dict[str, Any], after: dict[str, Any], said: str) -> str:
    (shared,) = (row for row in before["objects"] if row["shared"])
    return PAGE.format(
        triangles=before["metrics"]["triangles"],
        rays=before["metrics"]["rays"],
        seconds=before["statistics"]["seconds"]["trace"],
        seconds_after=after["statistics"]["seconds"]["trace"],
        command=said,
        visits_before=work(before),
        visits_after=work(after),
        before=table(before),
        after=table(after),
        stretched_by=shared["stretched_by"],
        hints=hints(before),
        sah_before=before["tree"]["sah_cost"],
        sah_after=after["tree"]["sah_cost"],
    )


def main() -> int:
    """Exit codes: 0 the page is there, 1 something went wrong and stderr says what."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--slivers", type=int, default=bad_scene.Size.slivers)
    parser.add_argument("--width", type=int, default=320)
    parser.add_argument("--docs", type=Path, default=DOCS, help="where the page goes")
    options = parser.parse_args()
    studio.register()
    size = bad_scene.Size(slivers=options.slivers)
    pictures = options.docs / "pictures"
    pictures.mkdir(parents=True, exist_ok=True)
    try:
        with tempfile.TemporaryDirectory() as folder:
            bad, good = Path(folder, "bad"), Path(folder, "good")
            before = variant(False, size, options.width, bad)
            after = variant(True, size, options.width, good)
            shutil.copy(good / "frame_0001.png", pictures / "culprits.png")
            shutil.copy(bad / "heat_nodes_0001.png", pictures / "culprits_heat.png")
            shutil.copy(good / "heat_nodes_0001.png", pictures / "culprits_mended.png")
    except (RuntimeError, OSError) as error:
        print(f"whittle: {error}", file=sys.stderr)
        return 1
    said = ".venv-{}.{}/bin/python docs/make/culprits.py".format(*sys.version_info[:2])
    (options.docs / "finding-culprits.md").write_text(page(before, after, said), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
