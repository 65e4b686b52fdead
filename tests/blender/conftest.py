# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests inside Blender share: the add-on from the source tree, and an empty scene."""

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
bpy = pytest.importorskip("bpy")
sys.path.insert(0, str(ROOT))
VERDICT = pytest.StashKey[int]()


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    session.config.stash[VERDICT] = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config: pytest.Config) -> None:
    """Ends the process at once, with the verdict.

    Blender as a module closes itself when Python frees it. Of 4.2 it was found that references to
    it which outlast Python, as any library may leak them, make it crash there. That 4.5 sometimes
    waited at its end for ever is thought to have the same cause, but was not proved. That scripts
    which use the add-on end by themselves is tested in processes of their own.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(config.stash.get(VERDICT, pytest.ExitCode.INTERNAL_ERROR))


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


@pytest.fixture
def stage(scene, addon):
    """A cube that mirrors over a floor, lit, read and built; the scene's source."""
    import viewing

    from addon.inspect import source

    bpy.ops.mesh.primitive_cube_add(size=2)
    bpy.ops.mesh.primitive_plane_add(size=8, location=(0, 0, -2))
    bpy.ops.object.light_add(location=(3, -3, 6))
    source.shared.close()
    viewing.ready(source.shared)
    yield source.shared
    source.shared.close()


@pytest.fixture
def glass(stage, scene):
    """The cube becomes glass, the floor half a mirror."""
    import viewing

    for name, inputs in (
        ("Cube", {"Transmission Weight": 1.0, "Roughness": 0.0}),
        ("Plane", {"Metallic": 0.5, "Roughness": 0.0}),
    ):
        material = bpy.data.materials.new(f"Of {name}")
        if bpy.app.version < (5, 0):
            material.use_nodes = True
        for key, value in inputs.items():
            material.node_tree.nodes["Principled BSDF"].inputs[key].default_value = value
        bpy.data.objects[name].data.materials.append(material)
    viewing.ready(stage)
    return stage
