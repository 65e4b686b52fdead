# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests inside Blender share: the add-on from the source tree, and an empty scene."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
bpy = pytest.importorskip("bpy")
sys.path.insert(0, str(ROOT))


@pytest.fixture(scope="session")
def addon() -> Iterator:
    """The add-on, registered."""
    import addon as package

    package.register()
    yield package
    package.unregister()


@pytest.fixture
def scene(addon) -> Iterator:
    """A scene with a camera 10 m above the origin that looks down, and nothing else."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "WHITTLE"
    scene.render.resolution_x, scene.render.resolution_y = 64, 40
    scene.world = None
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = (0, 0, 10)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.whittle.samples = 1
    bpy.context.view_layer.update()
    yield scene
    addon.results.last.clear()
