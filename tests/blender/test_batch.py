# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: what it writes, and its exit codes."""

import json
import subprocess
import sys
from pathlib import Path

import bpy
import pictures
import pytest
from blender_process import programs

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def file(scene, tmp_path):
    """A .blend of a lit cube that moves."""
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    cube.keyframe_insert("location", frame=1)
    cube.location.x = 2
    cube.keyframe_insert("location", frame=3)
    bpy.ops.object.light_add(type="POINT", location=(2, -2, 5))
    path = tmp_path / "cube.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


@pytest.fixture
def main(addon, scene):
    """The command line inside this process."""
    return addon.batch.main


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize(
    "text, numbers",
    [("7", [7]), ("1-3", [1, 2, 3]), ("1-9:4", [1, 5, 9]), ("1,4-5", [1, 4, 5])],
)
def test_frame_lists(addon, text, numbers):
    assert addon.batch.frames(text) == numbers


@pytest.mark.parametrize("text", ["", "x", "3-1", "1-5:0", "1-5:x", "-3"])
def test_frame_lists_that_say_nothing(main, tmp_path, text, capsys):
    assert main(["render", "--out", str(tmp_path / "out"), f"--frames={text}"]) == 2
    assert "--frames" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_render_writes_pictures_and_statistics(main, file, tmp_path):
    out = tmp_path / "new" / "out"
    assert main(["render", "--file", str(file), "--out", str(out), "--frames", "1-3:2"]) == 0
    assert names(out) == [
        "frame_0001.png",
        "frame_0003.png",
        "statistics_0001.json",
        "statistics_0003.json",
    ]
    assert not pictures.same(out / "frame_0001.png", out / "frame_0003.png")
    (layer,) = json.loads((out / "statistics_0003.json").read_text())
    assert list(layer["seconds"]) == ["export", "build", "trace", "hand_over", "write"]
    assert min(layer["seconds"].values()) > 0
    assert sum(layer["tracing"].values()) == pytest.approx(layer["seconds"]["trace"])
    assert layer["frame"] == 3 and layer["build"]["triangles"] == 12
    assert layer["render"]["rays"]["primary"] == 64 * 40


def test_render_writes_multilayer_exr(main, file, tmp_path):
    arguments = ["render", "--file", str(file), "--out", str(tmp_path / "out"), "--format", "exr"]
    assert main([*arguments, "--samples", "4"]) == 0
    assert "Combined" in pictures.layer(tmp_path / "out" / "frame_0001.exr")


def test_heatmap_writes_a_picture_of_each_counter(main, addon, file, tmp_path):
    assert main(["heatmap", "--file", str(file), "--out", str(tmp_path / "out")]) == 0
    expected = ["cost.csv", "cost.json", "counters_0001.exr", "statistics_0001.json"]
    counted = [row for row in addon.passes.COUNTERS if row.source != "coherence"]
    expected += [f"heat_{row.source}_0001.png" for row in counted]
    assert names(tmp_path / "out") == sorted(expected)


def test_a_failing_frame_is_exit_code_1(main, file, tmp_path, capsys):
    arguments = ["render", "--file", str(file), "--out", str(tmp_path / "out")]
    assert main([*arguments, "--samples", "5"]) == 1
    assert "frame 1" in capsys.readouterr().err and names(tmp_path / "out") == []


def test_a_missing_file_is_exit_code_1(main, tmp_path, capsys):
    arguments = ["render", "--file", str(tmp_path / "none.blend"), "--out", str(tmp_path / "out")]
    assert main(arguments) == 1
    assert "none.blend" in capsys.readouterr().err


def test_a_folder_that_cannot_be_made_is_exit_code_1(main, file, tmp_path):
    (tmp_path / "out").write_text("in the way")
    assert main(["render", "--file", str(file), "--out", str(tmp_path / "out")]) == 1


@pytest.mark.parametrize("arguments", [[], ["fly"], ["render", "--samples", "many"]])
def test_a_wrong_command_line_is_exit_code_2(main, arguments):
    assert main(arguments) == 2


def test_help_is_exit_code_0(main, capsys):
    assert main(["--help"]) == 0
    assert "heatmap" in capsys.readouterr().out


def test_as_a_python_module(file, tmp_path):
    out = tmp_path / "out"
    command = [sys.executable, "-m", "addon", "render", "--file", str(file), "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr
    assert names(out) == ["frame_0001.png", "statistics_0001.json"]


@pytest.mark.parametrize("blender", programs(), ids=lambda blender: blender.package)
def test_as_a_command_of_blender(blender, file, tmp_path):
    out = tmp_path / "out"
    arguments = ["-b", file, "--command", "whittle", "render", "--out", out]
    done = blender.run(*arguments, "--frames", "2")
    assert done.returncode == 0, done.stdout + done.stderr
    assert names(out) == ["frame_0002.png", "statistics_0002.json"]
    done = blender.run(*arguments, "--frames", "3", "--samples", "7")
    assert done.returncode == 1 and len(names(out)) == 2
