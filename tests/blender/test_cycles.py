# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whittle and Cycles agree on the demo scene: every edge to the pixel, exposure within 2 %."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
pytest.importorskip("bpy")
sys.path.insert(0, str(ROOT / "docs" / "make"))

EXPOSURE = 0.02
SMALL = 200  # pixels; objects of fewer are too noisy in Cycles' picture to be judged alone


@pytest.fixture(scope="module")
def figures(tmp_path_factory):
    """One run of the script that docs/fidelity.md is made with, on a small picture."""
    path = tmp_path_factory.mktemp("fidelity") / "figures.json"
    script = ROOT / "docs" / "make" / "fidelity.py"
    size = ["--percent", "15", "--samples", "256", "--rounds", "1"]
    done = subprocess.run(
        [sys.executable, script, *size, "--json", path], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return json.loads(path.read_text())


def test_edges_agree_to_the_pixel(figures):
    edges = figures["edges"]
    assert edges["on_edges"] > 500
    assert edges["differ"] - edges["explained"] == 0
    assert edges["differ"] <= edges["on_edges"] / 50


def test_the_whole_picture_is_as_bright(figures):
    whole = figures["exposure"][0]
    assert whole["name"] == "Everything"
    assert np.allclose(whole["ratios"], 1, atol=EXPOSURE)


def test_every_object_is_as_bright(figures):
    large = [row for row in figures["exposure"] if row["pixels"] >= SMALL]
    assert len(large) >= 8
    for row in large:
        # A channel that is next to black says nothing.
        lit = np.array(row["cycles"]) > 0.02
        assert np.allclose(np.array(row["ratios"])[lit], 1, atol=EXPOSURE), row


def test_a_shifted_picture_would_be_noticed():
    """The comparison is sharp: one pixel's shift moves nearly every edge pixel."""
    import fidelity

    index = np.zeros((40, 60), dtype=np.float32)
    index[10:30, 20:50] = 3
    assert (index != np.roll(index, 1, axis=1)).sum() == 40
    assert fidelity.edge_pixels(index).sum() == 20 + 20 + 30 + 30 - 1


def test_rays_of_a_pixels_centre_pass_where_the_camera_looks():
    import fidelity

    camera = {
        "width": 64,
        "height": 40,
        "to_world": np.eye(4),
        "projection": np.array([[2, 0, 0, 0], [0, 3.2, 0, 0], [0, 0, -1, -0.2], [0, 0, -1, 0.0]]),
    }
    origins, directions = fidelity.probe(camera, row=20, column=32)
    assert np.allclose(origins, 0)
    slopes = directions[:, :2] / -directions[:, 2:]
    pixel = 2 / 64 / 2  # at distance 1
    assert np.allclose(slopes.mean(axis=0), pixel / 2)
    reach = (slopes[:, 0].max() - slopes[:, 0].min()) / 2
    assert np.isclose(reach, fidelity.FILTER * pixel)
