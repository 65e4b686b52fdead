# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender as these scripts need it: the add-on from the source tree, and a scene to render."""

from __future__ import annotations

import atexit
import os
import platform
import sys
import time
from pathlib import Path

import bpy
import exr
import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parents[2]


if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))


def register() -> None:
    """Register the add-on from the source tree, once, until the script ends."""
    import addon

    if not hasattr(bpy.types.Scene, "whittle"):
        addon.register()
        # Blender as a module does not end while a render engine is registered.
        atexit.register(addon.unregister)


def open_scene(path: Path | None = None) -> bpy.types.Scene:
    """Open a .blend file, or build the demo scene if there is none.

    Raises FileNotFoundError for a missing file, ValueError for a scene without a camera.
    """
    if path is None:
        from addon import demo

        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        demo.build(bpy.context.scene)
    elif path.is_file():
        bpy.ops.wm.open_mainfile(filepath=str(path.resolve()))
    else:
        raise FileNotFoundError(f"SCENE={path} is not a file")
    scene = bpy.context.scene
    if scene.camera is None:
        raise ValueError(f"the scene {scene.name!r} has no camera: set one in its properties")
    return scene


def name_of(path: Path | None) -> str:
    """What a table calls the scene."""
    return "demo" if path is None else path.stem


def machine() -> str:
    """The processor's name, and how busy the machine is with other work, for a page of times."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    name = names[0] if names else platform.processor() or platform.machine()
    return f"{name}, load average {os.getloadavg()[0]:.1f} before the start"


def multilayer(scene: bpy.types.Scene, path: Path) -> Path:
    """Set the scene to write a multilayer EXR of 32-bit floats; gives the file's path."""
    image = scene.render.image_settings
    if bpy.app.version >= (5, 0, 0):
        image.media_type = "MULTI_LAYER_IMAGE"
    image.file_format = "OPEN_EXR_MULTILAYER"
    image.color_depth, image.exr_codec = "32", "ZIP"
    scene.render.use_file_extension = True
    scene.render.filepath = str(path.with_suffix(".exr"))
    return path.with_suffix(".exr")


def png(scene: bpy.types.Scene, path: Path) -> Path:
    """Set the scene to write an 8-bit PNG; gives the file's path."""
    image = scene.render.image_settings
    if bpy.app.version >= (5, 0, 0):
        image.media_type = "IMAGE"
    image.file_format, image.color_mode, image.color_depth = "PNG", "RGB", "8"
    scene.render.use_file_extension = True
    scene.render.filepath = str(path.with_suffix(".png"))
    return path.with_suffix(".png")


def render(scene: bpy.types.Scene) -> float:
    """Render without writing a file; gives the seconds from start to end."""
    began = time.perf_counter()
    bpy.ops.render.render(scene=scene.name)
    return time.perf_counter() - began


def render_passes(scene: bpy.types.Scene, path: Path) -> dict[str, NDArray[np.float32]]:
    """Render to a multilayer EXR and give its passes (see exr.read)."""
    file = multilayer(scene, path)
    file.parent.mkdir(parents=True, exist_ok=True)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    return exr.read(file)
