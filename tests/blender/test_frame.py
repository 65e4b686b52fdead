# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark's whole frames: phases of both engines, in turns, and the page's part on them."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
bpy = pytest.importorskip("bpy")
sys.path.insert(0, str(ROOT / "docs" / "make"))

PIXELS = 96 * 64


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """One run on the scene that Blender starts with."""
    folder = tmp_path_factory.mktemp("frame")
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    blend = folder / "cube.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    command = [sys.executable, ROOT / "docs" / "make" / "frame.py", folder / "frame.json"]
    command += ["--scene", blend, "--size", "96", "64", "--rounds", "1", "--samples", "1", "4"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads((folder / "frame.json").read_text())


def test_phases_of_both_engines(found):
    assert [frame["samples"] for frame in found["frames"]] == [1, 4]
    for frame in found["frames"]:
        assert set(frame["seconds"]) == {"whittle", "cycles", "alone"}
        assert frame["rays"]["primary"] == frame["samples"] * PIXELS
        assert frame["triangles"] == 12
        for seconds in frame["seconds"].values():
            assert {len(values) for values in seconds.values()} == {frame["rounds"]}
            for row in zip(*(seconds[name] for name in ("read", "build", "trace")), strict=True):
                assert min(row) > 0
            phases = [seconds[name][0] for name in ("read", "trace", "write")]
            assert sum(phases) <= seconds["total"][0] + 0.02  # Blender rounds what saving took


def test_a_million_triangles_are_read_as_quads_and_as_triangles(found):
    assert [row["corners"] for row in found["reading"]] == [4, 3]
    for row in found["reading"]:
        assert row["triangles"] == 1_000_000
        assert {name: len(values) for name, values in row["seconds"].items()} == {
            "whittle": 1,
            "cycles": 1,
            "export": 1,
        }
        for whole, export in zip(row["seconds"]["whittle"], row["seconds"]["export"], strict=True):
            assert 0 < export < whole


def test_cycles_a_ray_are_those_of_all_threads():
    from bench_summary import cycles_a_ray

    frame = {
        "seconds": {"whittle": {"trace": [0.4, 0.5, 0.9]}},
        "threads": 2,
        "gigahertz": 3.0,
        "rays": {"primary": 10_000_000, "shadow": 20_000_000},
    }
    assert cycles_a_ray(frame, "trace") == pytest.approx(100)


def test_threads_are_compared_with_one_on_what_they_trace():
    from bench_summary import thread_gain

    seconds = {"alone": {"trace": [1.9, 1.8, 9.0]}, "whittle": {"trace": [1.0, 7.0, 0.5]}}
    assert thread_gain({"seconds": seconds}) == pytest.approx(1.9)


def test_the_page_tells_ratios_to_cycles(found):
    from bench_summary import medians
    from benchmarks import frame_part

    text = frame_part(found)
    for frame in found["frames"]:
        whole = [medians(frame["seconds"][name])["total"] for name in ("whittle", "cycles")]
        row = f"| whole job | {whole[0]:.3f} | {whole[1]:.3f} | {whole[1] / whole[0]:.2f} |"
        assert row in text
    said = " ".join(text.split())
    assert "the lecture's budget is 37.5" in said and "times as fast as one." in said
