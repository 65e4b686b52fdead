# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: ``blender FILE --command whittle ...`` or ``python -m addon ...``.

Exit codes: 0 all frames are there; 1 a frame failed; 2 the command line is wrong; 3 all frames are
there, but a budget is broken.
"""

import argparse
import os
import re
import sys
import time

import bpy

from . import cost, heat, passes, progress, results
from .builtin_panels import ENGINE
from .cost.budgets import help_text
from .cost.compare import CompareError, sentence
from .cost.files import Before
from .cost.report import Report

BROKEN = 3  # the exit code
MOST_CHANGES = 5  # that are printed of a view layer
FORMATS = {"png": ("PNG", ".png"), "exr": ("OPEN_EXR_MULTILAYER", ".exr")}


class BatchError(RuntimeError):
    """A frame could not be made; the message says why."""


def main(argv: list[str]) -> int:
    """Runs one subcommand and returns the exit code."""
    parser = _parser()
    try:
        options = parser.parse_args(argv)
    except SystemExit as stop:
        return stop.code
    broken = 0
    try:
        _open(options)
        report = None
        if _counts(options):
            report = Report(bpy.data.filepath, options.budget, options.baseline)
        for frame in options.frames or [bpy.context.scene.frame_current]:
            _run_frame(options, frame)
            if report:
                broken += _judge_frame(options, report)
    except (BatchError, heat.HeatError, OSError) as error:
        print(f"whittle: {error}", file=sys.stderr)
        return 1
    except cost.BudgetError as error:
        print(f"whittle: --budget {error}", file=sys.stderr)
        return 2
    except CompareError as error:
        print(f"whittle: --baseline: {error}", file=sys.stderr)
        return 2
    return BROKEN if broken else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="whittle", description=__doc__.split("\n")[0])
    commands = parser.add_subparsers(dest="command", required=True)
    for name, text in (
        ("render", "render frames and their statistics (JSON) into a folder"),
        ("heatmap", "render frames, counting: heatmaps, counts and who they are due to"),
    ):
        command = commands.add_parser(
            name,
            help=text,
            description=text,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        command.add_argument("--file", help="a .blend to open first")
        command.add_argument(
            "--output", "--out", dest="out", default=".", help="the folder; default: this one"
        )
        command.add_argument("--frames", type=frames, help="such as 7, 1-10, 1-250:5 or 1,4,9-12")
        command.add_argument("--samples", type=int, help="per pixel, instead of the scene's")
        command.add_argument("--quiet", action="store_true", help="no progress")
    commands.choices["render"].add_argument("--format", choices=sorted(FORMATS), default="png")
    heatmap = commands.choices["heatmap"]
    heatmap.epilog = f"metrics of budgets\n\n{help_text(_counters())}"
    heatmap.add_argument(
        "--budget",
        type=budget,
        action="append",
        default=[],
        help=f"such as nodes_p95<=120; may be given several times; exit code {BROKEN} if broken",
    )
    heatmap.add_argument(
        "--baseline",
        type=baseline,
        help="a cost.json of an earlier run: says which objects and materials changed since",
    )
    return parser


def budget(text: str) -> cost.Budget:
    """A budget of the command line."""
    try:
        return cost.Budget.parse(text, _counters())
    except cost.BudgetError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def baseline(path: str) -> Before:
    """The cost.json to compare with, read before this run may write over it."""
    try:
        return Before(path)
    except CompareError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def _counters() -> list[str]:
    return [row.source for row in passes.COUNTERS]


def _counts(options: argparse.Namespace) -> bool:
    return options.command == "heatmap"


def frames(text: str) -> list[int]:
    """Frame numbers of a list of ranges: "1-5:2,9" is 1, 3, 5, 9."""
    numbers: list[int] = []
    for part in text.split(","):
        span, _, step = part.partition(":")
        first, dash, last = span.partition("-")
        try:
            stop = int(last) if dash else int(first)
            numbers.extend(range(int(first), stop + 1, int(step or 1)))
        except ValueError as error:
            text = f"'{part}' is not of the form 7, 1-10 or 1-250:5"
            raise argparse.ArgumentTypeError(text) from error
    if not numbers:
        raise argparse.ArgumentTypeError(f"'{text}' names no frame")
    return numbers


def _open(options: argparse.Namespace) -> None:
    """Opens the file asked for, chooses the engine and makes the folder."""
    if options.file:
        try:
            bpy.ops.wm.open_mainfile(filepath=os.path.abspath(options.file))
        except RuntimeError as error:
            raise BatchError(str(error).strip()) from error
    else:
        check_opened(sys.argv)
    scene = bpy.context.scene
    scene.render.engine = ENGINE
    if options.samples is not None:
        scene.whittle.samples = options.samples
    if _counts(options):
        scene.whittle.use_counters = scene.whittle.use_own_trees = True
    os.makedirs(options.out, exist_ok=True)


def check_opened(words: list[str]) -> None:
    """BatchError if Blender's command line names a .blend that Blender could not read: it goes on
    with its startup scene and says nothing more."""
    if "--command" not in words:
        return
    before = words[: words.index("--command")]
    files = [word for word in before if re.search(r"\.blend\d*$", word, re.IGNORECASE)]
    if files and os.path.realpath(files[-1]) != os.path.realpath(bpy.data.filepath):
        raise BatchError(f"{files[-1]} could not be opened: is it there, and a Blender file?")


def _run_frame(options: argparse.Namespace, frame: int) -> None:
    scene = bpy.context.scene
    scene.frame_set(frame)
    results.last.clear()
    line = None if options.quiet else ProgressLine(f"frame {frame}")
    if line:
        progress.listeners.append(line)
    try:
        bpy.ops.render.render()
    except RuntimeError as error:
        raise BatchError(f"frame {frame}: {str(error).strip()}") from error
    finally:
        if line:
            progress.listeners.remove(line)
            line.end()
    if not results.last:
        raise BatchError(f"frame {frame}: cancelled")
    began = time.perf_counter()
    if _counts(options):
        saved = [_save_render(options.out, f"counters_{frame:04d}", "exr")]
        saved += _save_heatmaps(options, frame)
    else:
        saved = [_save_render(options.out, f"frame_{frame:04d}", options.format)]
    for result in results.last:
        result.seconds["write"] = time.perf_counter() - began
        print(f"whittle: frame {frame}, {result.layer}: {summary(result)}")
    saved.append(_save_statistics(options, frame))
    print("\n".join(f"whittle: wrote {path}" for path in saved), flush=True)


def summary(result: results.Result) -> str:
    """Where a view layer's time went, in one line."""
    names = {"export": "read", "hand_over": "hand over"}
    phases = [f"{names.get(name, name)} {spent:.2f} s" for name, spent in result.seconds.items()]
    tracing = ", ".join(f"{name} {spent:.2f}" for name, spent in result.tracing().items())
    place = list(result.seconds).index("trace")
    phases[place] += f" ({tracing})"
    return ", ".join(phases)


def _judge_frame(options: argparse.Namespace, report: Report) -> int:
    """Writes what the frame costs; how many budgets it breaks."""
    broken = 0
    try:
        for result in results.last:
            for verdict in report.add(result):
                layer = f", {result.layer}" if len(results.last) > 1 else ""
                said = f"whittle: frame {result.frame}{layer}: {verdict.sentence()}"
                print(said, file=sys.stdout if verdict.kept else sys.stderr, flush=True)
                broken += not verdict.kept
            for change in report.changes[:MOST_CHANGES]:
                print(f"whittle: frame {result.frame}: {sentence(change)}", flush=True)
    finally:
        for path in report.write(options.out):
            print(f"whittle: wrote {path}", flush=True)
    return broken


def _save_render(folder: str, name: str, form: str) -> str:
    """Saves the render; it appears under its name only when it is whole."""
    kind, extension = FORMATS[form]
    path = os.path.join(folder, name + extension)
    partial = os.path.join(folder, f"{name}.partial{extension}")
    settings = bpy.context.scene.render.image_settings
    set_format(settings, kind)
    if form == "exr":
        settings.color_depth = "32"  # counts have more digits than 16 bits hold
    bpy.data.images["Render Result"].save_render(os.path.abspath(partial))
    os.replace(partial, path)
    return path


def set_format(settings: bpy.types.ImageFormatSettings, kind: str) -> None:
    """Chooses a file format; newer Blenders want to know first what kind of file it is."""
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE" if kind == "OPEN_EXR_MULTILAYER" else "IMAGE"
    settings.file_format = kind


def _save_heatmaps(options: argparse.Namespace, frame: int) -> list[str]:
    settings = bpy.context.scene.whittle
    top = settings.heat_max if settings.heat_range == "FIXED" else None
    paths = []
    for result in results.last:
        layer = f"_{bpy.path.clean_name(result.layer)}" if len(results.last) > 1 else ""
        for row in passes.counted(result.counters):
            path = os.path.join(options.out, f"heat_{row.source}{layer}_{frame:04d}.png")
            heat.write(path, heat.draw(result, row.source, settings.heat_map, top))
            paths.append(path)
    return paths


def _save_statistics(options: argparse.Namespace, frame: int) -> str:
    path = os.path.join(options.out, f"statistics_{frame:04d}.json")
    partial = f"{path}.partial"
    with open(partial, "w", encoding="utf-8") as file:
        file.write(results.to_json(results.last))
    os.replace(partial, path)
    return path


class ProgressLine:
    """One line on the error stream: redrawn in a terminal, else said at each new phase."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._phase = ""
        self._start = time.monotonic()
        self._redraw = sys.stderr.isatty()

    def __call__(self, phase: str, fraction: float) -> None:
        text = f"whittle: {self._title}: {progress.TEXTS[phase]}"
        if self._redraw:
            seconds = time.monotonic() - self._start
            print(f"\r{text} {fraction:4.0%} {seconds:6.1f} s\033[K", end="", file=sys.stderr)
        elif phase != self._phase:
            print(text, file=sys.stderr, flush=True)
        self._phase = phase

    def end(self) -> None:
        if self._redraw:
            print(file=sys.stderr)


_command = None


def register() -> None:
    global _command
    _command = bpy.utils.register_cli_command("whittle", main)


def unregister() -> None:
    global _command
    bpy.utils.unregister_cli_command(_command)
    _command = None
