# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/error-and-time.md and its plot, from a report's figures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import error
import matplotlib
import same_bits

matplotlib.use("Agg")
import matplotlib.pyplot as plt

if TYPE_CHECKING:
    from report import Report

PHASES = {"export": "#9aa5b1", "build": "#c98c3a", "trace": "#2a6f97", "shade": "#7fb069"}

PAGE = """\
# Error against run time

The scene is {scene} ({triangles:,} triangles) at {width} x {height}, in Blender {blender}.
The machine: {machine}; {threads} threads, instruction set {isa}.
Everything here comes from one run of

    {command}

![Error against wall time, and where the time goes](pictures/error-and-time.png)

Errors are distances from a reference of {reference_samples:,} stratified samples a pixel with
other seeds, {reference_depth} bounces and a cut-off of 2^-16. It is the mean of two halves, whose
difference puts its own error at {own_error:.2e} (RMSE); smaller errors cannot be told from it.
*RMSE* is in linear light over all pixels and channels, highlights at full strength; *shown* is the
same after clipping to what a display shows. *p99*: 99 % of the pixels are closer. *Off*: pixels
that differ by more than 1/255 in a channel. Times are wall time in seconds, medians of {rounds};
trace and shade share a render's time as their threads' clocks do. Renders drop rays that would
add less than 1/1024 to their pixel.

{errors}

## Settings that change no bit

The same picture ({passes}; {samples} samples) under each setting,
compared bit by bit. {verdict}

{identities}

## Leaving out

What a scene does not need is left out of the kernel and of memory. For each need: the scene with
it; changed so that it does not need it, under the kernel that leaves it out; and that same scene
under the generic kernel, which leaves nothing out. The last two must give the same bits. One
sample a pixel unless the need is another; memory is the finished structures and the render's
working memory. The scenes with and without a need trace other rays: compare the last two for what
leaving out itself saves.

{needs}
"""


def page(found: Report) -> str:
    """The whole page as Markdown."""
    failures = found.failures()
    return PAGE.format(
        scene=found.scene,
        command=found.command,
        triangles=found.triangles,
        width=found.size[0],
        height=found.size[1],
        blender=found.blender,
        machine=found.machine,
        threads=found.threads,
        isa=found.isa,
        reference_samples=found.reference.samples,
        reference_depth=error.REFERENCE["max_depth"],
        own_error=found.reference.own_error,
        rounds=found.rounds,
        errors=_errors(found),
        passes=", ".join(same_bits.PASSES),
        samples=same_bits.SAMPLES,
        verdict=f"**Changed bits: {', '.join(failures)}.**" if failures else "All are the same.",
        identities=_identities(found),
        needs=_needs(found),
    )


def _table(head: tuple[str, ...], left: int, rows: list[tuple[str, ...]]) -> str:
    """A Markdown table whose first ``left`` columns are text and whose others are numbers."""
    rule = ["---"] * left + ["---:"] * (len(head) - left)
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (head, rule, *rows))


def _errors(found: Report) -> str:
    head = ("pattern", "samples", "depth", "RMSE", "shown", "p99", "off", "export", "build")
    rows = [
        (
            row.pattern,
            f"{row.samples}",
            f"{row.depth}",
            f"{row.rmse:.4f}",
            f"{row.rmse_shown:.4f}",
            f"{row.p99:.4f}",
            f"{row.wrong:.1%}",
            f"{row.export:.2f}",
            f"{row.build:.2f}",
            f"{row.trace:.2f}",
            f"{row.shade:.2f}",
            f"{row.seconds:.2f}",
            f"{row.rays / 1e6:.2f}",
        )
        for row in found.errors
    ]
    return _table((*head, "trace", "shade", "total", "Mrays"), 1, rows)


def _identities(found: Report) -> str:
    first = found.identities[0].digest
    rows = [
        (
            row.setting,
            row.value,
            row.digest[:12],
            "yes" if row.digest == first else "**no**",
            f"{row.build:.2f}",
            f"{row.render:.2f}",
        )
        for row in found.identities
    ]
    return _table(("setting", "value", "digest", "same bits", "build s", "render s"), 4, rows)


def _needs(found: Report) -> str:
    head = ("need", "with it", "without", "generic", "with it", "without", "generic")
    rows = [
        (
            row.need,
            *(f"{m.seconds:.3f} s" for m in (row.on, row.off, row.generic)),
            *(f"{m.bytes / 1e6:.2f} MB" for m in (row.on, row.off, row.generic)),
            "yes" if row.same else "**no**",
        )
        for row in found.needs
    ]
    return _table((*head, "same bits"), 1, rows)


def draw(found: Report, path: Path) -> None:
    """Left: error against time, a curve for each depth. Right: where the time goes."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 4.6), layout="constrained")
    _draw_errors(found, left)
    _draw_phases(found, right)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw_errors(found: Report, axis: plt.Axes) -> None:
    shades = plt.get_cmap("viridis")
    for index, depth in enumerate(error.DEPTHS):
        rows = [r for r in found.errors if r.depth == depth and r.pattern == "regular"]
        color = shades(index / len(error.DEPTHS))
        axis.plot(*_points(rows), "o-", color=color, label=f"depth {depth}")
        for row in rows if depth == error.DEPTHS[-1] else ():
            axis.annotate(
                f"{row.samples}", (row.seconds, row.rmse), (0, 7), textcoords="offset points"
            )
    rows = [row for row in found.errors if row.pattern == "stratified"]
    axis.plot(*_points(rows), "x--", color="#b03a48", label=f"stratified, depth {rows[0].depth}")
    axis.axhline(found.reference.own_error, color="gray", linestyle=":", label="reference's own")
    axis.set(xscale="log", yscale="log", xlabel="wall time in seconds, export to picture")
    axis.set(ylabel="RMSE, linear light", title="Error against run time (numbers: samples)")
    axis.grid(True, which="both", alpha=0.25)
    axis.legend()


def _points(rows: list[error.Row]) -> tuple[list[float], list[float]]:
    return [row.seconds for row in rows], [row.rmse for row in rows]


def _draw_phases(found: Report, axis: plt.Axes) -> None:
    rows = [r for r in found.errors if r.depth == error.DEPTHS[-1] and r.pattern == "regular"]
    names = [str(row.samples) for row in rows]
    floor = [0.0] * len(rows)
    for phase, color in PHASES.items():
        heights = [getattr(row, phase) for row in rows]
        axis.bar(names, heights, bottom=floor, color=color, label=phase)
        floor = [a + b for a, b in zip(floor, heights, strict=True)]
    axis.set(xlabel="samples a pixel", ylabel="wall time in seconds")
    axis.set_title(f"Where the time goes, depth {error.DEPTHS[-1]}")
    axis.legend()
