# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The heatmap command: what it counts, whom it names, and its exit codes."""

import csv
import json
import sys
from pathlib import Path

import bpy
import numpy as np
import pictures
import pytest
from blender_process import programs

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs" / "make"))
import bad_scene  # noqa: E402

KINDS = ("primary", "shadow", "reflection", "refraction")
WORK = ("node_visits", "triangle_tests")
SMALL = bad_scene.Size(slivers=2_000, trees=25, layers=6)


@pytest.fixture
def file(scene, tmp_path):
    """The bad scene as a .blend."""
    bad_scene.build(scene, SMALL)
    path = tmp_path / "bad.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


@pytest.fixture(autouse=True)
def without_drawing(addon, monkeypatch):
    """Drawn heatmaps are tested elsewhere."""
    monkeypatch.setattr(addon.batch, "_save_heatmaps", lambda options, frame: [])


@pytest.fixture
def heatmap(addon, file, tmp_path):
    """Runs the command on the bad scene; gives the exit code."""

    def run(*arguments: str) -> int:
        folder = str(tmp_path / "out")
        words = ["heatmap", "--file", str(file), "--output", folder, "--quiet", *arguments]
        return addon.batch.main(words)

    return run


def frame_of(folder) -> dict:
    (frame,) = json.loads((folder / "cost.json").read_text())["frames"]
    return frame


def rows_of(frame: dict, kind: str = "objects") -> dict[str, dict]:
    return {"shared" if row["shared"] else row["name"]: row for row in frame[kind]}


def test_the_first_rows_name_the_culprits(heatmap, tmp_path):
    assert heatmap() == 0
    rows = rows_of(frame_of(tmp_path / "out"))
    dearest = [name for name in rows if name != "shared"]
    assert dearest[0] == bad_scene.PARASOL and rows[bad_scene.PARASOL]["share"] > 0.5
    hints = {name: [hint["kind"] for hint in row["hints"]] for name, row in rows.items()}
    assert hints[bad_scene.PARASOL][0] == "slivers"
    assert rows[bad_scene.PARASOL]["slivers"] > 0.9 * SMALL.slivers
    assert rows[bad_scene.PARASOL]["sah_cost"] > 5 * rows[bad_scene.BALL]["sah_cost"]
    for name in (bad_scene.PINE, bad_scene.FIR):
        assert "overlap" in hints[name] and rows[name]["overlap"] > 0.5
        assert rows[name]["instances"] == SMALL.trees
    assert rows["shared"]["stretched_by"] == bad_scene.ROCK
    assert hints[bad_scene.ROCK] == ["stray", "stretch"]
    rock = rows[bad_scene.ROCK]
    assert rock["stray_triangles"] == 1 and rock["stray_share"] > 0.99
    assert rows[bad_scene.BALL]["stray_share"] < 0.1 > rows[bad_scene.BALL]["overlap"]


def test_the_mended_scene_has_none_of_these_hints(addon, scene, tmp_path):
    bad_scene.build(scene, SMALL, mended=True)
    assert addon.batch.main(["heatmap", "--out", str(tmp_path), "--quiet"]) == 0
    rows = rows_of(frame_of(tmp_path))
    hints = {hint["kind"] for row in rows.values() for hint in row["hints"]}
    assert not hints & {"slivers", "stray", "overlap"}
    assert rows[bad_scene.PARASOL]["share"] < 0.5


def test_the_rows_add_up_to_the_pixels(addon, heatmap, tmp_path):
    out = tmp_path / "out"
    assert heatmap("--samples", "4") == 0
    frame = frame_of(out)
    (layer,) = json.loads((out / "statistics_0001.json").read_text())
    passes = pictures.layer(out / "counters_0001.exr")
    for kind in KINDS:
        for key, source, name in (
            ("node_visits", "nodes", "Nodes"),
            ("triangle_tests", "triangles", "Triangles"),
        ):
            total = layer["render"][source][kind]
            for rows in (frame["objects"], frame["materials"]):
                assert sum(row[key][kind] for row in rows) == total
            image = passes[f"{name} {kind.title()}"].astype(np.float64)
            assert image.sum() == total, "32-bit floats hold each count"
    assert passes["Nodes"].max() > 2048, "more than 16 bits hold"
    counts = passes["Nodes"] / 4
    assert frame["metrics"]["nodes_p95"] == pytest.approx(np.percentile(counts, 95))
    assert frame["metrics"]["nodes_max"] == counts.max()
    assert frame["tree"]["sah_cost"] == pytest.approx(layer["build"]["sah_cost"])
    assert frame["samples"] == 4


def test_instances_are_one_row_with_their_count(addon, scene, tmp_path):
    collection = bpy.data.collections.new("Grove")
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2)
    tree = bpy.context.object
    tree.name = "Tree"
    scene.collection.objects.unlink(tree)
    collection.objects.link(tree)
    for x in (-2, 0, 2):
        empty = bpy.data.objects.new("Here", None)
        empty.location.x = x
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        scene.collection.objects.link(empty)
    assert addon.batch.main(["heatmap", "--out", str(tmp_path), "--quiet"]) == 0
    row = rows_of(frame_of(tmp_path))["Tree"]
    assert row["instances"] == 3 and row["triangles"] == 3 * 80


def test_each_frame_and_layer_has_its_rows(addon, scene, tmp_path):
    bpy.ops.mesh.primitive_cube_add()
    scene.view_layers.new("Second")
    assert addon.batch.main(["heatmap", "--out", str(tmp_path), "--frames", "1,3", "--quiet"]) == 0
    frames = json.loads((tmp_path / "cost.json").read_text())["frames"]
    first = scene.view_layers[0].name
    assert [(frame["frame"], frame["layer"]) for frame in frames] == [
        (1, first),
        (1, "Second"),
        (3, first),
        (3, "Second"),
    ]
    assert len((tmp_path / "cost.csv").read_text().splitlines()) == 1 + 4 * 2 * 2


def test_kept_budgets_are_exit_code_0(heatmap, capsys):
    assert heatmap("--budget", "nodes_p95<=1e9", "--budget", "triangles(Para*)<=2000") == 0
    assert capsys.readouterr().out.count("is kept") == 2


def test_broken_budgets_are_exit_code_3_and_name_the_object(heatmap, tmp_path, capsys):
    assert heatmap("--budget", "nodes_mean<=5", "--budget", "depth<=64") == 3
    said = capsys.readouterr()
    assert "budget 'nodes_mean<=5' is broken: " in said.err
    assert "object 'Parasol'" in said.err and "depth<=" not in said.err
    kept = {row["budget"]: row["kept"] for row in frame_of(tmp_path / "out")["budgets"]}
    assert kept == {"nodes_mean<=5": False, "depth<=64": True}
    assert heatmap("--budget", "sliver_share(*)<=0.5") == 3
    said = capsys.readouterr().err
    assert "is that of object 'Parasol'" in said and "slivers" in said


@pytest.mark.parametrize("text", ["nodes_p95=12", "speed<=12", "nodes_p95<=much", ""])
def test_an_unreadable_budget_is_exit_code_2_before_anything_is_rendered(
    heatmap, tmp_path, capsys, text
):
    assert heatmap("--budget", text) == 2
    assert "--budget" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_budget_of_an_object_that_is_not_there_is_exit_code_2(heatmap, capsys):
    assert heatmap("--budget", "triangles(Bush)<=10") == 2
    assert "no object of this render is called 'Bush'" in capsys.readouterr().err


def test_an_unreadable_file_is_exit_code_1(addon, tmp_path, capsys):
    bad = tmp_path / "bad.blend"
    bad.write_bytes(b"not a scene")
    for path in (bad, tmp_path / "none.blend"):
        words = ["heatmap", "--file", str(path), "--out", str(tmp_path / "out")]
        assert addon.batch.main([*words, "--budget", "nodes_p95<=12"]) == 1
        assert path.name in capsys.readouterr().err


def test_a_file_that_blender_itself_could_not_open_is_exit_code_1(
    addon, file, tmp_path, monkeypatch, capsys
):
    """Blender would go on with its startup scene."""
    words = ["heatmap", "--out", str(tmp_path / "out"), "--quiet"]
    for name, code in (("none.blend", 1), ("bad.blend", 0), ("BAD.BLEND1", 1)):
        argv = ["blender", "-b", str(tmp_path / name), "--command", "whittle", *words]
        monkeypatch.setattr("sys.argv", argv)
        assert addon.batch.main(words) == code
        assert (name in capsys.readouterr().err) == (code == 1)


def test_the_help_lists_the_metrics(addon, capsys):
    assert addon.batch.main(["heatmap", "--help"]) == 0
    said = capsys.readouterr().out
    assert "triangles_per_pixel" in said and "nodes_shadow" in said and "exit code 3" in said


@pytest.mark.parametrize("blender", programs(), ids=lambda blender: blender.package)
def test_exit_codes_of_blender_itself(blender, file, tmp_path):
    out = tmp_path / "out"
    arguments = ["-b", file, "--command", "whittle", "heatmap", "--output", out]
    for budget, code in (
        ("nodes_p95<=1e9", 0),
        ("triangles(Parasol)<=100", 3),
        ("nodes_p95<<1", 2),
    ):
        done = blender.run(*arguments, "--budget", budget)
        assert done.returncode == code, done.stdout + done.stderr
        assert ("'Parasol'" in done.stderr) == (code == 3)
    bad = tmp_path / "unreadable.blend"
    bad.write_bytes(b"not a scene")
    done = blender.run("-b", bad, *arguments[2:])
    assert done.returncode == 1 and "unreadable.blend" in done.stdout + done.stderr


def test_the_example_s_page_is_made_of_its_counts(addon, tmp_path, monkeypatch):
    import culprits

    monkeypatch.undo()  # heatmaps are drawn
    words = ["culprits.py", "--slivers", "800", "--width", "64", "--docs", str(tmp_path)]
    monkeypatch.setattr("sys.argv", words)
    assert culprits.main() == 0
    page = (tmp_path / "finding-culprits.md").read_text()
    assert "| Parasol | 1 | 800 | " in page and "**Rock** has most" in page
    kept = (ROOT / "docs" / "finding-culprits.md").read_text()
    shown = [line for line in kept.splitlines() if line.startswith("![")]
    assert len(shown) == 3 and all(line in page for line in shown)
    assert len(list((tmp_path / "pictures").iterdir())) == 3


@pytest.fixture
def before(heatmap, tmp_path):
    """The cost.json of the bad scene."""
    assert heatmap() == 0
    path = tmp_path / "before.json"
    (tmp_path / "out" / "cost.json").rename(path)
    return path


def test_a_baseline_adds_the_differences_and_prints_the_largest(
    heatmap, before, scene, tmp_path, capsys
):
    bpy.data.objects[bad_scene.PARASOL].data = bpy.data.objects[bad_scene.BALL].data
    bpy.ops.wm.save_mainfile()
    capsys.readouterr()
    assert heatmap("--baseline", str(before)) == 0
    said = [line for line in capsys.readouterr().out.splitlines() if "tests before" in line]
    assert len(said) == 5 and "object 'Parasol'" in " ".join(said[:2])
    frame = frame_of(tmp_path / "out")
    old = json.loads(before.read_text())["frames"][0]
    found = frame["baseline"]
    assert (found["file"], found["frame"]) == (str(before), frame["frame"])
    for kind, rows in (("object", "objects"), ("material", "materials")):
        mine = [change for change in found["changes"] if change["kind"] == kind]
        work = [
            sum(sum(row[name].values()) for row in one[rows] for name in WORK)
            for one in (old, frame)
        ]
        assert sum(change["work_difference"] for change in mine) == work[1] - work[0] < 0
    lines = (tmp_path / "out" / "cost.csv").read_text().splitlines()
    differences = {row["name"]: row["work_difference"] for row in csv.DictReader(lines)}
    (parasol,) = (c for c in found["changes"] if (c["kind"], c["name"]) == ("object", "Parasol"))
    assert differences["Parasol"] and parasol["triangles_difference"] == 2208 - SMALL.slivers


def test_nothing_changes_without_a_change(heatmap, before, tmp_path):
    assert heatmap("--baseline", str(before)) == 0
    assert frame_of(tmp_path / "out")["baseline"]["changes"] == []
    with (tmp_path / "out" / "cost.csv").open() as file:
        assert {row["work_difference"] for row in csv.DictReader(file)} == {"0"}


def test_another_number_of_samples_is_refused(heatmap, before, capsys):
    assert heatmap("--baseline", str(before), "--samples", "4") == 2
    assert "render with as many" in capsys.readouterr().err


@pytest.mark.parametrize("text", [None, "no json", "[]", '{"schema": "whittle-cost"}'])
def test_an_unreadable_baseline_is_exit_code_2_before_anything_is_rendered(
    heatmap, tmp_path, capsys, text
):
    path = tmp_path / "old.json"
    if text is not None:
        path.write_text(text)
    assert heatmap("--baseline", str(path)) == 2
    assert "old.json" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_baseline_without_its_frames_is_said_so(heatmap, before, capsys):
    document = json.loads(before.read_text())
    del document["frames"][0]["size"]
    before.write_text(json.dumps(document))
    assert heatmap("--baseline", str(before)) == 2
    assert "lacks what a cost.json has: 'size'" in capsys.readouterr().err
