# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo scene is what it promises: large, in view, a quarter mirror or glass, understood."""

import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
bpy = pytest.importorskip("bpy")
sys.path.insert(0, str(ROOT / "docs" / "make"))

SHARP = {"BSDF_GLOSSY", "BSDF_GLASS", "BSDF_PRINCIPLED"}


@pytest.fixture(scope="module")
def shot(addon):
    """What the core is given of the demo, and the names and shaders of its objects by index."""
    import capture
    import studio

    scene = studio.open_scene()
    assert scene.render.engine == "WHITTLE"
    scene.render.resolution_percentage = 20
    shaders = {
        item.pass_index: item.material_slots[0].material.node_tree.nodes[0].type
        for item in scene.objects
        if item.type == "MESH"
    }
    return capture.shot(scene), shaders


@pytest.fixture(scope="module")
def corners(shot):
    """Every triangle's corners in the camera's clip space: (n, 3, 4)."""
    recording, camera = shot[0].recording, shot[0].camera
    to_clip = camera["projection"] @ np.linalg.inv(camera["to_world"])
    found = []
    for (mesh, transform, *_), _ in recording.instances:
        named = recording.meshes[mesh][1]
        points = np.c_[named["positions"], np.ones(len(named["positions"]))]
        clip = points @ (to_clip @ np.array(transform)).T
        vertices = named["triangles"]
        if named["corners"] is not None:
            vertices = named["corners"][vertices]
        found.append(clip[vertices])
    return np.concatenate(found)


def test_it_has_half_a_million_triangles_most_of_them_in_view(corners):
    w = corners[..., 3:]
    inside = (np.abs(corners[..., :3]) <= w).all(axis=(1, 2))
    assert len(corners) >= 500_000
    assert inside.mean() >= 0.6


def test_a_quarter_of_its_pixels_is_mirror_or_glass(shot):
    found, shaders = shot
    scene = found.scene()
    scene.build()
    settings = found.settings | {"samples": 1, "passes": ("object_index",)}
    index = scene.render(found.camera, settings)["object_index"][..., 0].astype(int)
    sharp = np.isin(index, [key for key, shader in shaders.items() if shader in SHARP])
    assert sharp.mean() >= 0.25
    assert {"BSDF_GLOSSY", "BSDF_GLASS", "BSDF_PRINCIPLED", "BSDF_DIFFUSE"} <= {
        shaders[key] for key in np.unique(index) if key in shaders
    }


def test_everything_in_it_is_understood(shot):
    # That bulbs and panels light nothing is so in Cycles too: they are hidden from diffuse rays.
    assert [note for note in shot[0].notes if not note.startswith("Glowing surfaces")] == []


def test_it_has_several_lights_and_no_light_from_the_sky(shot):
    recording = shot[0].recording
    assert sorted(light["kind"] for light in recording.lights) == ["point", "point", "point", "sun"]
    assert tuple(recording.world["ambient"]) == (0.0, 0.0, 0.0)
    assert all(channel > 0 for channel in recording.world["color"])


def test_its_objects_have_indices_of_their_own(shot):
    ids = [named["object_id"] for _, named in shot[0].recording.instances]
    assert len(set(ids)) == len(ids) and 0 not in ids
