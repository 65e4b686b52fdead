# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension is updated while Blender runs: its library waits for the next start."""

import io
import subprocess
import zipfile
from pathlib import Path

import bpy
from window import Gui

OLD, NEW = "0.1.0", "0.1.1"

NEXT_START = """
import bpy, sys, importlib
native = importlib.import_module("bl_ext.user_default.whittle.native")
print("NEXT START", native.problem(), native.load().__version__)
"""


def newer(path: Path | io.BytesIO) -> bytes:
    """An extension's zip, or a wheel, with the other version wherever it is written."""
    made = io.BytesIO()
    old, new = OLD.encode(), NEW.encode()
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(made, "w") as target:
        for name in source.namelist():
            data = source.read(name)
            if name.endswith(".whl"):
                data = newer(io.BytesIO(data))
            elif name.endswith((".toml", ".so", "METADATA", "native.py")):
                data = data.replace(old, new)
            target.writestr(name.replace(OLD, NEW), data)
    return made.getvalue()


def test_an_update_while_blender_runs(gui: Gui):
    yield from gui.fresh()
    bpy.ops.render.render()
    (rendered,) = gui.package.results.last
    assert gui.package.native.load().__version__ == OLD and rendered
    update = gui.folder / "update.zip"
    update.write_bytes(newer(gui.extension))
    bpy.ops.extensions.package_install_files(
        repo="user_default", filepath=str(update), overwrite=True, enable_on_install=True
    )
    yield 1.0
    assert gui.package.native.VERSION == NEW
    yield from gui.show_properties("RENDER")
    gui.screenshot("updated")
    said = gui.package.native.problem()
    assert said and NEW in said and OLD in said and "the next start of Blender" in said
    try:
        bpy.ops.render.render()
    except RuntimeError as error:
        assert "the next start of Blender" in str(error)
    else:
        raise AssertionError("it rendered with a library of another version")
    yield from gui.shade("RENDERED")
    yield 1.0
    gui.screenshot("updated-viewport")
    yield from gui.shade("SOLID")
    # The next Blender has the same profile.
    bpy.ops.wm.save_userpref()
    command = [bpy.app.binary_path, "--background", "--python-expr", NEXT_START]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert f"NEXT START None {NEW}" in done.stdout, done.stdout + done.stderr
