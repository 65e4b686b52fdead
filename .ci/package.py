# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds dist/whittle-VERSION.zip with Blender's own builder, and validates it.

Run it with a Python that has bpy, after the wheel was built into dist/.
"""

import importlib.util
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
STAGE = ROOT / "build" / "stage"
DIST = ROOT / "dist"


def main() -> int:
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    try:
        stage(manifest)
        extension = DIST / f"{manifest['id']}-{manifest['version']}.zip"
        extension.unlink(missing_ok=True)
        blender_extension("build", "--source-dir", str(STAGE), "--output-filepath", str(extension))
        blender_extension("validate", str(extension))
    except PackageError as error:
        print(f"package: {error}", file=sys.stderr)
        return 1
    print(f"{extension.relative_to(ROOT)}: {extension.stat().st_size:,} bytes")
    return 0


class PackageError(RuntimeError):
    """The extension cannot be built; the message says what is missing."""


def stage(manifest: dict) -> None:
    """Lays the manifest, the add-on and the wheel side by side, as Blender wants them."""
    shutil.rmtree(STAGE, ignore_errors=True)
    hidden = shutil.ignore_patterns("__pycache__", "*.pyc")
    shutil.copytree(ROOT / "addon", STAGE, ignore=hidden)
    for name in ("blender_manifest.toml", "LICENSE"):
        shutil.copy(ROOT / name, STAGE)
    (STAGE / "wheels").mkdir()
    for wheel in manifest["wheels"]:
        source = DIST / Path(wheel).name
        if not source.is_file():
            raise PackageError(f"{source.relative_to(ROOT)} is missing: build the wheel first")
        shutil.copy(source, STAGE / "wheels")


def blender_extension(*arguments: str) -> None:
    """Runs a command of the tool that Blender builds and validates extensions with."""
    spec = importlib.util.find_spec("bpy")
    if spec is None:
        raise PackageError("this Python has no bpy: use the one of the project's environment")
    found = sorted(Path(spec.origin).parent.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py"))
    if not found:
        raise PackageError(f"no blender_ext.py beside {spec.origin}")
    done = subprocess.run([sys.executable, str(found[-1]), *arguments], check=False)
    if done.returncode != 0:
        raise PackageError(f"Blender's '{arguments[0]}' failed with code {done.returncode}")


if __name__ == "__main__":
    sys.exit(main())
