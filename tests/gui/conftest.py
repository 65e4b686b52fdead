# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the tests of this folder inside Blender's window: one Blender for each file.

BLENDER_WINDOW holds the command that opens the window: a program on a display, or a wrapper that
makes one. It is called in the project's folder, with paths relative to it. Without it nothing runs.
BLENDER_WINDOW_SECONDS limits the time that all of them take together; a Blender that hangs is ended
in any case.
"""

from __future__ import annotations

import ast
import contextlib
import json
import os
import shlex
import shutil
import signal
import subprocess
import time
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
OUT = ROOT / "build" / "gui"
START, EACH = 120, 310  # seconds: for Blender to start, and for each test
GRACE = 20  # seconds from the request to end until the end
WINDOW = ("--window-geometry", "0", "0", "1280", "800")
LIMIT = "BLENDER_WINDOW_SECONDS"
BEGAN = time.monotonic()
NOT_RUN = "NOT RUN: no Blender with a window: make gui-test BLENDER=path"


def pytest_pycollect_makemodule(module_path: Path, parent: pytest.Collector) -> pytest.Module:
    return WindowFile.from_parent(parent, path=module_path)


class WindowFile(pytest.Module):
    """A file whose tests run in Blender: it is read here, and imported only there."""

    report: dict[str, Any] | None = None

    def collect(self) -> Iterator[pytest.Item]:
        for node in ast.parse(self.path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
                yield WindowTest.from_parent(self, name=node.name)

    def result(self, name: str) -> dict[str, Any] | None:
        """What became of a test; the first to ask runs all that were chosen."""
        if self.report is None:
            chosen = [item.name for item in self.session.items if item.parent is self]
            self.report = run_blender(self.path, chosen)
        if "not_run" in self.report:
            pytest.skip("NOT RUN: " + self.report["not_run"])
        return self.report["tests"].get(name)


class WindowTest(pytest.Item):
    """One test of such a file."""

    def runtest(self) -> None:
        if not os.environ.get("BLENDER_WINDOW"):
            pytest.skip(NOT_RUN)
        row = self.parent.result(self.name)
        if row is None:
            text = self.parent.report["error"]
            raise WindowFailure(f"Blender ended before this test did:\n{text}")
        for line in row["printed"]:
            self.add_report_section("call", "stdout", line)
            print(line)
        if row["outcome"] != "passed":
            raise WindowFailure(row["text"])

    def repr_failure(self, excinfo: pytest.ExceptionInfo, style: Any = None) -> Any:
        if isinstance(excinfo.value, WindowFailure):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int, str]:
        return self.path, 0, self.name


class WindowFailure(Exception):
    """A test that failed inside Blender; the text is what it said there."""


def run_blender(test_file: Path, names: list[str]) -> dict[str, Any]:
    """Runs tests of a file in a Blender of its own; gives the report, see inside.py."""
    folder = OUT / test_file.stem
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    words = [test_file, folder, extension()]
    paths = [str(path.relative_to(ROOT)) for path in words]
    command = [*shlex.split(os.environ["BLENDER_WINDOW"]), *WINDOW]
    command += ["--python", "tests/gui/inside.py", "--", *paths, *names]
    seconds = min(START + EACH * len(names), time_left())
    if seconds <= 0:
        return {"tests": {}, "error": f"no time is left of {LIMIT}"}
    code, output = call(command, seconds, folder / "profile")
    (folder / "output.txt").write_text(output, encoding="utf-8")
    shutil.rmtree(folder / "profile", ignore_errors=True)
    file = folder / "report.json"
    report = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {"tests": {}}
    end = "\n".join(output.splitlines()[-40:])
    report.setdefault("error", f"exit code {code}; the last lines of its output:\n{end}")
    return report


def time_left() -> float:
    """Seconds that all windows may still take."""
    return float(os.environ.get(LIMIT, "inf")) - (time.monotonic() - BEGAN)


def extension() -> Path:
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    path = ROOT / "dist" / f"{manifest['id']}-{manifest['version']}.zip"
    if not path.is_file():
        pytest.fail(f"{path.relative_to(ROOT)} is missing: make package", pytrace=False)
    return path


def call(command: list[str], seconds: float, profile: Path) -> tuple[int, str]:
    """Exit code and output of a command that is ended, with its children, when time is up."""
    # A profile of its own: the user's preferences and extensions are neither read nor changed.
    variables = os.environ | {"BLENDER_USER_RESOURCES": str(profile)}
    child = subprocess.Popen(
        command,
        cwd=ROOT,
        env=variables,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        start_new_session=True,
    )
    try:
        output, _ = child.communicate(timeout=seconds)
    except subprocess.TimeoutExpired:
        output = stop(child) + f"\nended after {seconds:.0f} s\n"
    except BaseException:  # pytest itself is asked to end
        stop(child)
        raise
    return child.returncode, output


def stop(child: subprocess.Popen) -> str:
    """Ends a command with its children, by force if need be; what it had said."""
    for request in (signal.SIGTERM, signal.SIGKILL):
        with contextlib.suppress(ProcessLookupError, subprocess.TimeoutExpired):
            os.killpg(child.pid, request)
            return child.communicate(timeout=GRACE)[0]
    return "it does not end, or a child of it does not"


def pytest_configure(config: pytest.Config) -> None:
    """A request to end ends the window too, which is in no group of ours."""
    if os.environ.get("BLENDER_WINDOW"):
        signal.signal(signal.SIGTERM, lambda *_: pytest.exit("ended by a signal", 143))
