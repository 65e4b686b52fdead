# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: ``blender FILE --command whittle ...`` or ``python -m addon ...``.

Exit codes: 0 all frames are there; 1 a frame failed; 2 the command line is wrong.
"""

import argparse
import os
import sys
import time

import bpy

from . import heat, passes, progress, results
from .builtin_panels import ENGINE

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
    try:
        _open(options)
        for frame in options.frames or [bpy.context.scene.frame_current]:
            _run_frame(options, frame)
    except (BatchError, heat.HeatError, OSError) as error:
        print(f"whittle: {error}", file=sys.stderr)
        return 1
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="whittle", description=__doc__.split("\n")[0])
    commands = parser.add_subparsers(dest="command", required=True)
    for name, text in (
        ("render", "render frames and their statistics (JSON) into a folder"),
        ("heatmap", "render frames, counting, and draw the counts as PNG into a folder"),
    ):
        command = commands.add_parser(name, help=text, description=text)
        command.add_argument("--file", help="a .blend to open first")
        command.add_argument("--out", default=".", help="the folder; default: this one")
        command.add_argument("--frames", type=frames, help="such as 7, 1-10, 1-250:5 or 1,4,9-12")
        command.add_argument("--samples", type=int, help="per pixel, instead of the scene's")
        command.add_argument("--quiet", action="store_true", help="no progress")
    commands.choices["render"].add_argument("--format", choices=sorted(FORMATS), default="png")
    return parser


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
    scene = bpy.context.scene
    scene.render.engine = ENGINE
    if options.samples is not None:
        scene.whittle.samples = options.samples
    if options.command == "heatmap":
        scene.whittle.use_counters = True
    os.makedirs(options.out, exist_ok=True)


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
    saved = _save_picture(options, frame) if options.command == "render" else []
    saved += _save_heatmaps(options, frame) if options.command == "heatmap" else []
    saved.append(_save_statistics(options, frame))
    print("\n".join(f"whittle: wrote {path}" for path in saved), flush=True)


def _save_picture(options: argparse.Namespace, frame: int) -> list[str]:
    """Saves the render; it appears under its name only when it is whole."""
    kind, extension = FORMATS[options.format]
    path = os.path.join(options.out, f"frame_{frame:04d}{extension}")
    partial = os.path.join(options.out, f"frame_{frame:04d}.partial{extension}")
    set_format(bpy.context.scene.render.image_settings, kind)
    bpy.data.images["Render Result"].save_render(os.path.abspath(partial))
    os.replace(partial, path)
    return [path]


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
        for row in passes.COUNTERS:
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
