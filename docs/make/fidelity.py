# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whittle against Cycles on one scene and camera: edges, exposure and time; docs/fidelity.md."""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import bpy
import capture
import cycles_setup
import numpy as np
import studio
from numpy.typing import NDArray

BOUNCES = 8
FILTER = 0.01  # pixels: as far as Cycles' samples stray from the centre of theirs
OURS = 16  # samples of Whittle's: its light has no noise, only edges to smooth
PROBES = 33  # a side of the grid of rays that looks for an edge in a pixel's centre

Image = NDArray[np.float32]


@dataclass
class Edges:
    """Pixels whose nearest object the two engines see differently, and why."""

    pixels: int
    on_edges: int
    differ: int
    explained: int  # both objects lie within FILTER pixels of the pixel's centre


@dataclass
class Exposure:
    """Means over some pixels, in linear light."""

    name: str
    pixels: int
    whittle: list[float]
    cycles: list[float]

    def ratios(self) -> list[float]:
        """Whittle over Cycles, by channel; 1 where both are black."""
        pairs = zip(self.whittle, self.cycles, strict=True)
        return [1.0 if a == b else a / b if b else float("inf") for a, b in pairs]


def cycles_passes(scene: bpy.types.Scene, path: Path, samples: int, pinned: bool) -> dict:
    """Cycles' combined picture and object index (under Whittle's name for it)."""
    cycles_setup.use(scene, samples, BOUNCES)
    if pinned:
        cycles_setup.pin_to_centres(scene, FILTER)
    found = studio.render_passes(scene, path)
    return {"Combined": found["Combined"], "Object Index": _either(found)}


def _either(found: dict[str, Image]) -> Image:
    return found["Object Index" if "Object Index" in found else "IndexOB"]  # 5, and 4


def whittle_passes(scene: bpy.types.Scene, path: Path, samples: int) -> dict[str, Image]:
    """Whittle's picture with as many bounces as Cycles has, and its object index."""
    scene.render.engine = "WHITTLE"
    scene.whittle.samples, scene.whittle.max_depth = samples, BOUNCES
    scene.whittle.use_counters = False
    return studio.render_passes(scene, path)


def compare_edges(scene: bpy.types.Scene, folder: Path) -> Edges:
    """Object indices at the centres of pixels: every difference must have an edge within FILTER."""
    theirs = cycles_passes(scene, folder / "cycles_index", 1, pinned=True)["Object Index"][..., 0]
    ours = whittle_passes(scene, folder / "whittle_index", 1)["Object Index"][..., 0]
    rows, columns = np.nonzero(ours != theirs)
    explained = 0
    if rows.size:
        shot = capture.shot(scene)
        core_scene = shot.scene()
        core_scene.build()
        ids = np.array([named["object_id"] for _, named in shot.recording.instances] + [0])
        for row, column in zip(rows, columns, strict=True):
            hits = core_scene.intersect(*probe(shot.camera, row, column), visibility=1)
            seen = set(ids[hits["instance"]].tolist())
            explained += {int(ours[row, column]), int(theirs[row, column])} <= seen
    return Edges(ours.size, int(edge_pixels(theirs).sum()), int(rows.size), explained)


def edge_pixels(index: Image) -> NDArray[np.bool_]:
    """Pixels whose right or upper neighbour shows another object."""
    found = np.zeros(index.shape, dtype=bool)
    found[:, :-1] |= index[:, 1:] != index[:, :-1]
    found[:-1] |= index[1:] != index[:-1]
    return found


def probe(camera: dict[str, Any], row: int, column: int) -> tuple[NDArray, NDArray]:
    """Rays through a grid of points that reaches FILTER from a pixel's centre each way."""
    steps = np.linspace(-FILTER, FILTER, PROBES)
    x, y = np.meshgrid(column + 0.5 + steps, row + 0.5 + steps)
    ndc = np.stack(
        [
            x.ravel() / camera["width"] * 2 - 1,
            y.ravel() / camera["height"] * 2 - 1,
            np.full(x.size, -1.0),
            np.ones(x.size),
        ]
    )
    points = np.linalg.inv(camera["projection"]) @ ndc
    points = (points / points[3])[:3].T
    to_world = camera["to_world"]
    flat = camera["projection"][3][3] == 1.0  # orthographic: parallel rays
    starts = points * (1.0, 1.0, 0.0) if flat else np.zeros_like(points)
    ways = np.tile((0.0, 0.0, -1.0), (len(points), 1)) if flat else points
    return starts @ to_world[:3, :3].T + to_world[:3, 3], ways @ to_world[:3, :3].T


def compare_exposure(
    scene: bpy.types.Scene, folder: Path, samples: int
) -> tuple[list[Exposure], Image, Image]:
    """Means of the whole picture and of each object in it, and the two pictures."""
    theirs = cycles_passes(scene, folder / "cycles", samples, pinned=False)
    ours = whittle_passes(scene, folder / "whittle", OURS)
    names = {item.pass_index: item.name for item in scene.objects} | {0: "Background"}
    index = ours["Object Index"][..., 0]
    a, b = ours["Combined"][..., :3], theirs["Combined"][..., :3]
    masks = [("Everything", np.ones(index.shape, dtype=bool))]
    masks += [(names[int(i)], index == i) for i in np.unique(index)]
    rows = [Exposure(name, int(m.sum()), _mean(a[m]), _mean(b[m])) for name, m in masks if m.any()]
    return rows, a, b


def _mean(pixels: Image) -> list[float]:
    return pixels.mean(axis=0, dtype=np.float64).tolist()


def time_both(scene: bpy.types.Scene, rounds: int) -> dict[str, list[float]]:
    """Seconds of a render with one sample from start to end, the engines taking turns."""
    times: dict[str, list[float]] = {"whittle": [], "cycles": []}
    for _ in range(rounds):
        cycles_setup.use(scene, 1, BOUNCES)
        times["cycles"].append(studio.render(scene))
        scene.render.engine = "WHITTLE"
        scene.whittle.samples = 1
        times["whittle"].append(studio.render(scene))
    return times


def measure(path: Path | None, percent: int, samples: int, rounds: int) -> dict[str, Any]:
    """All three comparisons; the sizes of the pictures in percent of the scene's own."""
    found: dict[str, Any] = {"scene": studio.name_of(path), "blender": bpy.app.version_string}
    found["machine"] = studio.machine()
    studio.register()
    scene = studio.open_scene(path)
    scene.view_layers[0].use_pass_object_index = True
    with tempfile.TemporaryDirectory() as folder:
        scene.render.resolution_percentage = percent
        found["size"] = [scene.render.resolution_x * percent // 100]
        found["size"].append(scene.render.resolution_y * percent // 100)
        found["edges"] = compare_edges(scene, Path(folder))
        found["percent"], found["samples"] = percent, samples
        found["exposure"], found["ours"], found["theirs"] = compare_exposure(
            scene, Path(folder), samples
        )
        found["times"] = time_both(scene, rounds)
    return found


def to_json(found: dict[str, Any]) -> str:
    """The figures, without the pictures."""
    plain = {key: value for key, value in found.items() if key not in ("ours", "theirs")}
    plain["edges"] = asdict(found["edges"])
    plain["exposure"] = [asdict(row) | {"ratios": row.ratios()} for row in found["exposure"]]
    return json.dumps(plain, indent=1) + "\n"


def report(found: dict[str, Any]) -> str:
    """The figures as Markdown tables."""
    edges, times = found["edges"], found["times"]
    lines = [
        "| object | pixels | red | green | blue |",
        "| --- | ---: | ---: | ---: | ---: |",
    ]
    for row in found["exposure"]:
        ratios = " | ".join(f"{ratio:.4f}" for ratio in row.ratios())
        lines.append(f"| {row.name} | {row.pixels:,} | {ratios} |")
    medians = {name: statistics.median(values) for name, values in times.items()}
    return PAGE.format(
        scene=found["scene"],
        blender=found["blender"],
        machine=found["machine"],
        percent=found["percent"],
        python=".venv-{}.{}/bin/python".format(*sys.version_info),
        width=found["size"][0],
        height=found["size"][1],
        filter=FILTER,
        bounces=BOUNCES,
        samples=found["samples"],
        ours=OURS,
        pixels=edges.pixels,
        on_edges=edges.on_edges,
        differ=edges.differ,
        explained=edges.explained,
        unexplained=edges.differ - edges.explained,
        exposure="\n".join(lines),
        rounds=len(times["whittle"]),
        whittle=medians["whittle"],
        cycles=medians["cycles"],
        ratio=medians["cycles"] / medians["whittle"],
    )


PAGE = """\
# Whittle against Cycles

Both engines render the same scene ({scene}) from the same camera in Blender {blender}, at
{width} x {height}, in one run of

    {python} docs/make/fidelity.py --percent {percent} --samples {samples} --rounds {rounds}

with the environment that `make test` sets up. The machine:
{machine}.

Cycles is set to draw what Whittle draws: sharp lights, no light from diffuse surfaces to others,
{bounces} bounces in mirrors and glass, nothing clamped.

![Whittle, Cycles, and their difference](pictures/fidelity.png)

## Edges

Cycles renders one sample with a filter of {filter} pixels, so that its rays pass within {filter}
pixels of the pixels' centres; Whittle's one sample passes through the centres. Object indices:

| | pixels |
| --- | ---: |
| in the picture | {pixels:,} |
| with another object to the right or above | {on_edges:,} |
| where the engines differ | {differ:,} |
| of these, both objects lie within {filter} pixels of the centre | {explained:,} |
| unexplained | {unexplained:,} |

## Exposure

Cycles with {samples} samples, Whittle with {ours}. Whittle's mean over Cycles', in linear light,
over the pixels of each object:

{exposure}

## Time

One sample a pixel, from the start of the render to its end, the median of {rounds} turns each:
Whittle {whittle:.2f} s, Cycles {cycles:.2f} s. Cycles over Whittle: {ratio:.2f}.
"""


def draw(found: dict[str, Any], path: Path) -> None:
    """The two pictures and ten times their difference, side by side."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    ours, theirs = found["ours"], found["theirs"]
    panels = {
        "Whittle": ours,
        f"Cycles, {found['samples']} samples": theirs,
        "Difference x 10": 10 * np.abs(ours - theirs),
    }
    figure, axes = plt.subplots(1, 3, figsize=(15, 3.6), layout="constrained")
    for axis, (title, pixels) in zip(axes, panels.items(), strict=True):
        axis.imshow(_display(pixels), origin="lower")
        axis.set_title(title)
        axis.set_axis_off()
    figure.savefig(path, dpi=110)


def _display(linear: Image) -> Image:
    """Linear light as sRGB in [0, 1]."""
    clipped = np.clip(linear, 0, 1)
    return np.where(clipped <= 0.0031308, clipped * 12.92, 1.055 * clipped ** (1 / 2.4) - 0.055)


def main() -> int:
    """Exit codes: 0 written, 1 something went wrong and stderr says what."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", type=Path, help="a .blend file; default: the demo scene")
    parser.add_argument("--percent", type=int, default=100, help="of the scene's resolution")
    parser.add_argument("--samples", type=int, default=256, help="of the exposure's pictures")
    parser.add_argument("--rounds", type=int, default=5, help="of the timing")
    parser.add_argument("--out", type=Path, default=studio.ROOT / "docs", help="the page's folder")
    parser.add_argument("--json", type=Path, help="write the figures here, and no page")
    arguments = parser.parse_args()
    try:
        found = measure(arguments.scene, arguments.percent, arguments.samples, arguments.rounds)
    except (RuntimeError, ValueError, OSError) as error:
        print(f"whittle: {str(error).strip()}", file=sys.stderr)
        return 1
    if arguments.json:
        arguments.json.write_text(to_json(found), encoding="utf-8")
        return 0
    (arguments.out / "pictures").mkdir(parents=True, exist_ok=True)
    (arguments.out / "fidelity.md").write_text(report(found), encoding="utf-8")
    draw(found, arguments.out / "pictures" / "fidelity.png")
    print(report(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())
