# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender's window: installs the extension, then steps through a file's tests.

blender --python tests/gui/inside.py -- TEST_FILE FOLDER EXTENSION NAME...

Each test is a generator function whose argument is a Gui; what it yields are seconds to wait. The
folder gets report.json, anew after each test: {"tests": {name: {outcome, seconds, text, printed}}}.
"""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import sys
import time
import traceback
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))
import window  # noqa: E402

LONGEST = 300.0  #: seconds for a test, unless its function has the attribute `seconds`
TOOLS = ("xdotool", "scrot")


class Run:
    """The tests of a file, one after the other."""

    def __init__(self, test_file: Path, folder: Path, extension: Path, names: list[str]) -> None:
        self.test_file, self.extension, self.names = test_file, extension, names
        self.gui = window.Gui(folder, extension)
        self.report: dict[str, Any] = {"blender": bpy.app.version_string, "tests": {}}
        self.deadline = time.monotonic() + LONGEST
        self.steps = self._all()

    def tick(self) -> float | None:
        """One step; Blender calls it again after the seconds that it gives."""
        try:
            if time.monotonic() > self.deadline:
                self.deadline += LONGEST
                return self.steps.throw(TimeoutError("the test took too long"))
            return next(self.steps)
        except StopIteration:
            self._end(0)
        except BaseException:
            self.report["error"] = traceback.format_exc()
            traceback.print_exc()
            self._end(1)
        return None

    def _all(self) -> window.Steps:
        missing = [tool for tool in TOOLS if not shutil.which(tool)]
        if missing:
            self.report["not_run"] = f"{' and '.join(missing)} not found beside Blender"
            return
        yield 0.5
        bpy.ops.extensions.package_install_files(
            repo="user_default", filepath=str(self.extension), enable_on_install=True
        )
        if not hasattr(bpy.types.Scene, "whittle"):
            raise RuntimeError(f"{self.extension} was not enabled: see Blender's output")
        yield 0.5
        module = _load(self.test_file)
        for name in self.names:
            yield from self._one(name, getattr(module, name))
            self._write()

    def _one(self, name: str, test: Any) -> window.Steps:
        began = time.monotonic()
        self.deadline = began + getattr(test, "seconds", LONGEST)
        self.gui.printed = []
        row = {"outcome": "passed", "text": ""}
        print(f"---- {name}", flush=True)
        try:
            yield from test(self.gui)
        except Exception:
            row = {"outcome": "failed", "text": traceback.format_exc()}
            traceback.print_exc()
            self.gui.screenshot(f"failed-{name}")
        row |= {"seconds": time.monotonic() - began, "printed": self.gui.printed}
        self.report["tests"][name] = row

    def _write(self) -> None:
        text = json.dumps(self.report, indent=2) + "\n"
        (self.gui.folder / "report.json").write_text(text, encoding="utf-8")

    def _end(self, code: int) -> None:
        self._write()
        sys.stdout.flush()
        sys.stderr.flush()
        # Not sys.exit: Blender would free, inside this timer, what the timer stands on.
        os._exit(code)


def _load(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def main() -> None:
    test_file, folder, extension, *names = sys.argv[sys.argv.index("--") + 1 :]
    view = bpy.context.preferences.view
    view.show_splash = False
    view.render_display_type = "AREA"  # there is no window manager to place a second window
    paths = [Path(path).resolve() for path in (test_file, folder, extension)]
    run = Run(*paths, names)
    bpy.app.timers.register(run.tick, first_interval=0.1, persistent=True)


main()
