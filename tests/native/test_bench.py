# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark measures what it says: known rays, counted mismatches, honest errors."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from bench_tools import BENCH, ROOT, SIZE, bench, records_of, run_program

FIELDS = {
    *("scene", "triangles", "kind", "threads", "isa", "rays", "whittle", "embree", "ratio"),
    *("embree_mode", "embree_quality", "hits_whittle", "hits_embree", "mismatches", "spread"),
}

# A square of side 1 seen head-on from (0, 0, 2), where the image is 2 wide and high at its depth:
# half the pixels of each axis. The light is behind it; a wall behind the camera closes the scene.
SQUARE = r"""# camera: 0 0 2  0 0 0  0 1 0  53.13010235
# light: 0 0 -2
v -0.5 -0.5 0
v 0.5 -0.5 0
v 0.5 0.5 0
v -0.5 0.5 0
vt 0 0
vn 0 0 1
f 1/1/1 2/1/1 3/1/1 \
  4/1/1   # a quad, continued
v -9 -9 3
v 9 -9 3
v 9 9 3
v -9 9 3
f -4//1 -3//1 -2//1
f -4 -2 -1
"""
SEEN = (SIZE // 2) ** 2


@pytest.fixture(scope="module", params=["\n", "\r\n"], ids=["lf", "crlf"])
def square(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The square as a file, with either kind of line end."""
    path = tmp_path_factory.mktemp("square") / "my square.obj"
    path.write_bytes(SQUARE.replace("\n", request.param).encode())
    return path


def test_known_rays_hit_what_they_must(program: Path, square: Path) -> None:
    records = records_of(run_program(program, str(square)))
    assert {r["scene"] for r in records} == {"my square"}
    assert {r["triangles"] for r in records} == {4}
    expected = {"primary": (SIZE**2, SEEN), "shadow": (SEEN, SEEN), "mirror": (SEEN, SEEN)}
    for kind, (rays, hit) in expected.items():
        own = [r for r in records if r["kind"] == kind]
        assert own
        for r in own:
            assert (r["rays"], r["hits_whittle"], r["hits_embree"]) == (rays, hit, hit), kind
            assert r["mismatches"] == 0
    random = [r for r in records if r["kind"] == "random"]
    assert random and all(0 < r["hits_whittle"] < SIZE**2 for r in random)


def test_records_are_complete_and_consistent(program: Path) -> None:
    records = records_of(run_program(program, "terrain:2000", "slivers:500+ground"))
    assert {r["scene"] for r in records} == {"terrain:2000", "slivers:500+ground"}
    threads = {r["threads"] for r in records}
    assert 1 in threads and len(threads) <= 2
    for scene in ("terrain:2000", "slivers:500+ground"):
        kinds = {r["kind"] for r in records if r["scene"] == scene and r["threads"] == 1}
        assert kinds == {"build", "primary", "shadow", "mirror", "random"}
    for r in records:
        assert r.keys() >= FIELDS
        assert r["ratio"] == pytest.approx(r["whittle"] / r["embree"], rel=1e-4)
        if r["kind"] == "build":
            assert r["whittle_bytes"] > 0 and r["embree_bytes"] > 0
            continue
        assert r["mismatches"] <= 1e-3 * r["rays"]
        assert r["embree"] == max(r["embree_modes"].values())
        assert r["embree_modes"][r["embree_mode"]] == r["embree"]
        assert r["ratio_single"] == pytest.approx(r["whittle"] / r["embree_modes"]["1"], rel=1e-4)


def test_both_sides_get_the_instruction_set_asked_for(program: Path) -> None:
    records = records_of(run_program(program, "terrain:200", WHITTLE_ISA="sse4.2"))
    widest = records_of(run_program(program, "terrain:200"))[0]["isa"]
    for r in records:
        assert r["isa"] == "sse4.2"
        assert r["embree_isa"] == "sse4.2" or widest == "sse4.2"
        if r["kind"] != "build":
            assert set(r["embree_modes"]) == {"1", "4", "4 coherent"}


def test_isa_restricts_both_sides(program: Path) -> None:
    options = ["--isa", "sse4.2", "--kinds", "random"]
    for r in records_of(run_program(program, *options, "terrain:200")):
        assert (r["isa"], r["embree_isa"]) == ("sse4.2", "sse4.2")


def test_other_builds_of_embree_are_traced_by_one_thread(program: Path) -> None:
    kinds = ["--kinds", "primary,shadow"]
    for r in records_of(run_program(program, *kinds, "terrain:2000")):
        if r["threads"] > 1:
            assert "embree_builds" not in r
            continue
        assert set(r["embree_builds"]) == {"robust", "high"}
        assert all(rate > 0 for rate in r["embree_builds"].values())
        assert r["embree_builds_mode"] in r["embree_modes"]
    for r in records_of(run_program(program, *kinds, "--builds", "one", "terrain:2000")):
        assert "embree_builds" not in r


def test_nodes_of_a_ray_alone_grow_as_the_logarithm(program: Path) -> None:
    scenes = ["terrain:2000", "terrain:32000"]
    records = records_of(run_program(program, "--kinds", "primary", "--builds", "one", *scenes))
    few, many = (r["nodes_per_ray"] for r in records if r["threads"] == 1)
    # Four more levels of the tree: more nodes, but far from 16 times as many.
    assert 1 < few < many < 3 * few


@pytest.mark.parametrize(
    ("scene", "triangles"),
    [("stadium", 35_000), ("stadium-near", 35_000), ("atrium", 400_000), ("spheres", 440_000)],
)
def test_generated_scenes_fill_the_picture(program: Path, scene: str, triangles: int) -> None:
    (record,) = records_of(
        run_program(program, "--kinds", "primary", "--builds", "one", "--threads", "1", scene)
    )
    assert record["triangles"] == pytest.approx(triangles, rel=0.06)
    assert record["hits_whittle"] > 0.6 * SIZE**2
    assert record["mismatches"] <= 3


def test_kinds_leaves_the_others_out(program: Path) -> None:
    records = records_of(run_program(program, "--kinds", "random,build", "terrain:200"))
    assert {r["kind"] for r in records} == {"build", "random"}


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["nowhere.obj"], "cannot read nowhere.obj"),
        (["teapots"], "no scene is called teapots"),
        (["terrain:1"], "number of triangles must be from 2"),
        (["--size", "64", "spheres"], "--size must be WIDTHxHEIGHT"),
        (["--rounds", "0", "spheres"], "--rounds must be a number from 1"),
        (["--quality", "best", "terrain:200"], "low, medium, high or robust, not best"),
        (["--kinds", "primary,rays", "spheres"], "not primary,rays"),
        (["--colour", "red", "spheres"], "there is no option --colour"),
        (["--embree", "missing.so", "spheres"], "cannot load Embree"),
        ([], "usage:"),
    ],
)
def test_bad_arguments_end_with_a_sentence(
    program: Path, arguments: list[str], sentence: str
) -> None:
    done = run_program(program, *arguments)
    assert done.returncode == 1
    assert sentence in done.stderr


def test_summary_is_geometric() -> None:
    ratios = {"a": 0.5, "b": 2.0, "c": 8.0}
    records = [
        {"kind": "shadow", "threads": 1, "scene": scene, "ratio": ratio}
        for scene, ratio in ratios.items()
    ]
    (row,) = bench.bench_summary.summary(records)
    assert (row.scenes, row.least, row.where, row.most) == (3, 0.5, "a", 8.0)
    assert row.mean == pytest.approx(2.0)


def test_front_writes_records_and_page(square: Path, tmp_path: Path) -> None:
    out = tmp_path / "records.json"
    command = [sys.executable, str(BENCH / "bench.py"), "--scenes", str(square)]
    command += ["--json", str(out), "--size", "64x64", "--rounds", "2"]
    # A caller's own scenes leave the project's page alone.
    page = ROOT / "docs" / "benchmarks.md"
    before = page.stat().st_mtime_ns if page.exists() else None
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (page.stat().st_mtime_ns if page.exists() else None) == before
    records = json.loads(out.read_text())["records"]
    assert all(r.keys() >= FIELDS for r in records)
    told = done.stdout.partition("Whittle over")[0].splitlines()
    rows = [line for line in told if line.startswith(("primary", "build"))]
    assert len(rows) == len([r for r in records if r["kind"] in ("primary", "build")])
    maker = ROOT / "docs" / "make" / "benchmarks.py"
    subprocess.run([sys.executable, str(maker), str(out), "--out", str(tmp_path)], check=True)
    text = (tmp_path / "benchmarks.md").read_text()
    for row in bench.bench_summary.summary(records):
        assert f"| {row.kind} | {row.threads} | 1 | {row.mean:.2f} | " in text
    for r in records:
        digits = 2 if r["kind"] == "build" else 1
        assert f"| {r['whittle']:.{digits}f} | {r['embree']:.{digits}f} | " in text
    assert (tmp_path / "pictures" / "benchmarks.png").stat().st_size > 10_000


def test_front_says_what_fails(tmp_path: Path) -> None:
    out = tmp_path / "records.json"
    command = [sys.executable, str(BENCH / "bench.py"), "--scenes", "nowhere.obj"]
    command += ["--json", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "cannot read nowhere.obj" in done.stderr
    assert not out.exists()
