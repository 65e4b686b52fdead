# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender as a user's batch job starts it: the real program if BLENDER names one, or a stand-in."""

import os
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

DRIVER = Path(__file__).with_name("blender_driver.py")


@dataclass(frozen=True)
class Blender:
    """A command line that starts Blender, and the name of the add-on's package inside it."""

    command: tuple[str, ...]
    package: str

    def run(self, *arguments: object, **environment: str) -> subprocess.CompletedProcess[str]:
        """Runs Blender to its end; PACKAGE in an argument is the add-on's package."""
        words = [str(word).replace("PACKAGE", self.package) for word in arguments]
        return subprocess.run(
            [*self.command, *words],
            capture_output=True,
            text=True,
            check=False,
            timeout=120,
            env=os.environ | environment,
        )


def programs() -> list[Blender]:
    """The stand-in, and the real program where the environment variable BLENDER gives its command
    (with the extension installed in its profile)."""
    found = [Blender((sys.executable, str(DRIVER)), "addon")]
    if os.environ.get("BLENDER"):
        found.append(
            Blender(tuple(shlex.split(os.environ["BLENDER"])), "bl_ext.user_default.whittle")
        )
    return found
