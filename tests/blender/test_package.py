# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's zip: built, installed the way a user would, enabled, rendered, kept."""

import json
import subprocess
import sys
import zipfile
from pathlib import Path

import bpy
import pytest

ROOT = Path(__file__).resolve().parents[2]

# Runs in a Blender of its own with a fresh profile. The module that the environment may hold must
# not stand in for the wheel of the extension.
CHILD = """
import importlib.machinery, json, os, sys
import bpy

class WheelOnly:
    @staticmethod
    def find_spec(name, path=None, target=None):
        if name == "whittle_core":
            inside = [entry for entry in sys.path if os.environ["PROFILE"] in entry]
            spec = importlib.machinery.PathFinder.find_spec(name, inside)
            if spec is None:
                raise ImportError("whittle_core is not in the extension", name=name)
            return spec

sys.meta_path.insert(0, WheelOnly)
MODULE = "bl_ext.user_default.whittle"
scene = bpy.context.scene

def install():
    bpy.ops.extensions.package_install_files(
        repo="user_default", filepath=os.environ["ZIP"], enable_on_install=True)

def render(name):
    scene.render.engine = "WHITTLE"
    scene.render.resolution_x, scene.render.resolution_y = 64, 40
    bpy.ops.render.render()
    path = os.path.join(os.environ["PROFILE"], name)
    bpy.data.images["Render Result"].save_render(path)
    return list(bpy.data.images.load(path).pixels)

import addon_utils
install()
scene.whittle.samples, scene.whittle.max_depth = 9, 3
first = render("first.png")
import whittle_core
found = {"file": whittle_core.__file__, "enabled": addon_utils.check(MODULE)}
bpy.ops.preferences.addon_disable(module=MODULE)
found["engine gone"] = not hasattr(bpy.types, "WHITTLE_OT_heatmaps")
bpy.ops.preferences.addon_enable(module=MODULE)
found["after enabling"] = (scene.whittle.samples, scene.whittle.max_depth)
found["same picture"] = render("second.png") == first
install()
found["after updating"] = (scene.whittle.samples, scene.whittle.max_depth)
found["same picture again"] = render("third.png") == first
bpy.ops.preferences.addon_disable(module=MODULE)
print("FOUND", json.dumps(found))
"""


@pytest.fixture(scope="module")
def extension() -> Path:
    """The zip, built from the wheel in dist/ with Blender's builder, which validates it."""
    done = subprocess.run(
        [sys.executable, str(ROOT / ".ci" / "package.py")], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    (found,) = (ROOT / "dist").glob("whittle-*.zip")
    return found


def test_the_zip_holds_the_add_on_and_one_wheel(extension):
    names = zipfile.ZipFile(extension).namelist()
    assert {"blender_manifest.toml", "__init__.py", "export/scene.py", "LICENSE"} <= set(names)
    assert len([name for name in names if name.endswith(".whl")]) == 1
    assert not [name for name in names if "__pycache__" in name or name.startswith("tests")]


def test_versions_agree(addon):
    import tomllib

    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text())
    header = (ROOT / "native" / "include" / "whittle.h").read_text()
    assert manifest["version"] == addon.native.VERSION
    assert f'#define WHITTLE_VERSION "{addon.native.VERSION}"' in header
    assert f"whittle_core-{addon.native.VERSION}-" in manifest["wheels"][0]


def test_a_user_installs_enables_renders_disables_and_updates(extension, tmp_path):
    import os

    variables = {
        "BLENDER_USER_RESOURCES": str(tmp_path),
        "BLENDER_USER_EXTENSIONS": str(tmp_path / "extensions"),
        "BLENDER_USER_CONFIG": str(tmp_path / "config"),
        "PROFILE": str(tmp_path),
        "ZIP": str(extension),
    }
    done = subprocess.run(
        [sys.executable, "-c", CHILD],
        capture_output=True,
        text=True,
        env=os.environ | variables,
        timeout=180,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    (line,) = [text for text in done.stdout.splitlines() if text.startswith("FOUND ")]
    found = json.loads(line.removeprefix("FOUND "))
    assert str(tmp_path) in found.pop("file")
    assert found == {
        "enabled": [True, True],
        "engine gone": True,
        "after enabling": [9, 3],
        "same picture": True,
        "after updating": [9, 3],
        "same picture again": True,
    }, bpy.app.version_string
