# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark measures what it says: known rays, counted mismatches, honest errors."""

from __future__ import annotations

import ctypes
import importlib.util
import json
import os
import struct
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
BENCH = ROOT / "native" / "bench"
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
SIZE = 64
NEUTRAL = (
    "compare.c",
    "measure.c",
    "mesh.c",
    "rays.c",
    "fail.c",
    "file.c",
    "ply.c",
    "ply_header.c",
    "shapes.c",
    "buildings.c",
    "terrain.c",
    "scenes.c",
    "obj.c",
)
SEEN = (SIZE // 2) ** 2


def load_bench() -> ModuleType:
    """bench.py as a module."""
    spec = importlib.util.spec_from_file_location("bench", BENCH / "bench.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


bench = load_bench()


@pytest.fixture(scope="module")
def program() -> Path:
    """The benchmark program, built from this checkout."""
    return bench.build_program()


def run_program(program: Path, *scenes: str, **environment: str) -> subprocess.CompletedProcess:
    """Measures quickly; whatever comes of it."""
    options = ["--embree", str(bench.find_embree()), "--size", f"{SIZE}x{SIZE}", "--rounds", "2"]
    return subprocess.run(
        [str(program), *options, *scenes],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | environment,
    )


def records_of(done: subprocess.CompletedProcess) -> list[dict[str, Any]]:
    """The records of a run that went well."""
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


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


def test_the_atrium_surrounds_the_camera(functions: ctypes.CDLL) -> None:
    mesh = functions.scenes_load(b"atrium", ctypes.c_float(1.6))
    floats = ctypes.cast(mesh.positions, ctypes.POINTER(ctypes.c_float))
    positions = np.ctypeslib.as_array(floats, (mesh.vertex_count, 3))
    eye = np.array(mesh.camera[:3])
    assert (positions.min(axis=0) < eye).all() and (eye < positions.max(axis=0)).all()


def test_kinds_leaves_the_others_out(program: Path) -> None:
    records = records_of(run_program(program, "--kinds", "random,build", "terrain:200"))
    assert {r["kind"] for r in records} == {"build", "random"}


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4: there is no vertex 4 among 3"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", "line 4: there is no vertex -4 among 3"),
        ("v 0 0 0\nv 1 0 0\nf 1 2\n", "line 3: a face needs at least 3"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x 3\n", "line 4: a face needs at least 3"),
        ("v 0 zero 0\nf 1 1 1\n", "line 1: a vertex needs 3 finite numbers"),
        ("v 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "line 1: a vertex needs 3 finite numbers"),
        ("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "line 1: a vertex needs 3 finite numbers"),
        ("v 0 0 0\n", "holds no faces"),
    ],
)
def test_a_bad_file_is_named_with_its_line(
    program: Path, tmp_path: Path, text: str, sentence: str
) -> None:
    path = tmp_path / "bad.obj"
    path.write_text(text)
    done = run_program(program, str(path))
    assert done.returncode == 1
    assert str(path) in done.stderr
    assert sentence in done.stderr


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


class Stream(ctypes.Structure):
    """`stream` of rays.h."""

    _fields_ = [
        ("kind", ctypes.c_char_p),
        ("count", ctypes.c_size_t),
        ("origins", ctypes.c_void_p),
        ("one_origin", ctypes.c_int),
        ("directions", ctypes.c_void_p),
        ("t_max", ctypes.c_float),
        ("any_hit", ctypes.c_int),
    ]


class Hits(ctypes.Structure):
    """`hits` of rays.h."""

    _fields_ = [(name, ctypes.c_void_p) for name in ("t", "triangle", "u", "v", "blocked")]


class Mesh(ctypes.Structure):
    """`mesh` of mesh.h."""

    _fields_ = [
        ("positions", ctypes.c_void_p),
        ("vertex_count", ctypes.c_size_t),
        ("triangles", ctypes.c_void_p),
        ("triangle_count", ctypes.c_size_t),
        ("normals", ctypes.c_void_p),
        ("camera", ctypes.c_float * 10),
        ("light", ctypes.c_float * 3),
        ("has_camera", ctypes.c_int),
        ("has_light", ctypes.c_int),
    ]


@pytest.fixture(scope="module")
def functions(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """The functions that need neither side, as a library of their own."""
    library = tmp_path_factory.mktemp("functions") / "functions.so"
    sources = [str(BENCH / name) for name in NEUTRAL]
    command = ["cc", "-std=c11", "-D_GNU_SOURCE", "-shared", "-fPIC", "-o", str(library)]
    subprocess.run([*command, *sources, "-lm"], check=True)
    loaded = ctypes.CDLL(str(library))
    loaded.compare_mismatches.restype = ctypes.c_size_t
    loaded.compare_count_hits.restype = ctypes.c_size_t
    loaded.rays_primary.restype = Stream
    loaded.ply_read.restype = loaded.scenes_load.restype = Mesh
    loaded.measure_quantile.restype = ctypes.c_double
    loaded.measure_spread.restype = ctypes.c_double
    return loaded


def hits_of(t: list[float]) -> tuple[Hits, list[np.ndarray]]:
    """Hits at these t, and the arrays that must outlive them."""
    times = np.array(t, np.float32)
    arrays = [times, np.where(np.isinf(times), -1, 7).astype(np.int32)]
    arrays += [np.zeros_like(times), np.zeros_like(times)]
    return Hits(*[a.ctypes.data for a in arrays], None), arrays


def test_mismatches_are_counted(functions: ctypes.CDLL) -> None:
    infinity = float("inf")
    ours = [1.0, 1.0, 1.0, infinity, infinity, 100.0, 100.0, float("nan")]
    theirs = [1.0, 1.00009, 1.00012, infinity, 5.0, infinity, 100.009, 1.0]
    first, keep = hits_of(ours)
    second, keep_too = hits_of(theirs)
    assert keep and keep_too
    stream = Stream(kind=b"primary", count=len(ours))
    arguments = [ctypes.byref(x) for x in (stream, first, second)]
    # 1.00012 is too far, two differ in whether they hit, and nan equals nothing.
    assert functions.compare_mismatches(*arguments) == 4
    assert functions.compare_count_hits(arguments[0], arguments[1]) == 6
    assert functions.compare_identical(*arguments) == 0
    assert functions.compare_identical(arguments[0], arguments[1], arguments[1]) == 1


def test_blocked_rays_are_compared(functions: ctypes.CDLL) -> None:
    ours, theirs = np.array([0, 1, 1, 0], np.uint8), np.array([0, 1, 0, 1], np.uint8)
    stream = Stream(kind=b"shadow", count=4, any_hit=1)
    hits = [Hits(None, None, None, None, a.ctypes.data) for a in (ours, theirs)]
    assert functions.compare_mismatches(*[ctypes.byref(x) for x in (stream, *hits)]) == 2


@pytest.mark.parametrize("size", [(64, 32), (40, 24), (37, 41)])
def test_neighbours_in_the_stream_are_neighbours_in_the_image(
    functions: ctypes.CDLL, size: tuple[int, int]
) -> None:
    width, height = size
    mesh = Mesh(camera=(0, 0, 0, 0, 0, -1, 0, 1, 0, 90))
    stream = functions.rays_primary(ctypes.byref(mesh), width, height)
    assert stream.count == width * height
    floats = ctypes.cast(stream.directions, ctypes.POINTER(ctypes.c_float))
    d = np.ctypeslib.as_array(floats, (3, stream.count)).astype(float)
    x = (d[0] / -d[2] * height / width + 1) * width / 2 - 0.5
    y = (d[1] / -d[2] + 1) * height / 2 - 0.5
    pixels = np.rint([x, y]).astype(int)
    assert np.abs(pixels - [x, y]).max() < 1e-3
    assert len(np.unique(pixels[0] + width * pixels[1])) == stream.count
    assert pixels.min() == 0 and (pixels.max(axis=1) == [width - 1, height - 1]).all()
    # Away from the border a block of rays is a block of pixels: 4 x 4, 16 x 16.
    for side in (4, 16):
        if width % side == 0 and height % side == 0:
            blocks = (pixels // side).reshape(2, -1, side * side)
            assert (blocks == blocks[:, :, :1]).all()


def test_quantiles_match_numpy(functions: ctypes.CDLL) -> None:
    generator = np.random.default_rng(5)
    for count in (1, 2, 5, 8):
        values = generator.random(count) + 1
        pointer = values.ctypes.data_as(ctypes.c_void_p)
        quarter, median, three = np.quantile(values, [0.25, 0.5, 0.75])
        found = functions.measure_quantile(pointer, ctypes.c_size_t(count), ctypes.c_double(0.25))
        assert found == pytest.approx(quarter, rel=1e-12)
        spread = functions.measure_spread(pointer, ctypes.c_size_t(count))
        assert spread == pytest.approx((three - quarter) / median, rel=1e-12)


def test_rounds_are_interleaved(functions: ctypes.CDLL) -> None:
    run_type = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_void_p)

    class Contender(ctypes.Structure):
        _fields_ = [("run", run_type), ("user", ctypes.c_void_p), ("seconds", ctypes.c_void_p)]

    log: list[int] = []
    durations = {1: 0.5, 2: 0.004}  # the second is repeated: three times fill 10 ms

    @run_type
    def run(user: int) -> float:
        log.append(user)
        return durations[user]

    seconds = np.zeros((2, 3))
    pair = (Contender * 2)(*[Contender(run, i + 1, seconds[i].ctypes.data) for i in range(2)])
    functions.measure_rounds(pair, ctypes.c_size_t(2), ctypes.c_size_t(3))
    second = [2, 2, 2]
    assert log == [1, 2, 1, *second, *second, 1, 1, *second]
    assert seconds == pytest.approx(np.array([[0.5] * 3, [0.004] * 3]))


# A quad and a pentagon, x given as double, with properties and an element to pass over.
PLY_VERTICES = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0.5), (-1, 0.5, 0)]
PLY_FACES = [(0, 1, 2, 3), (0, 1, 2, 3, 4)]
PLY_TRIANGLES = [(0, 1, 2), (0, 2, 3), (0, 1, 2), (0, 2, 3), (0, 3, 4)]
PLY_HEADER = """ply
format {} 1.0
comment made for a test
comment camera: 1 2 3  4 5 6  0 1 0  50
comment light: 7 8 9
element marker 2
property list uchar short spans
element vertex 5
property uchar shade
property double x
property float y
property float z
element face 2
property list uchar int vertex_indices
property ushort group
end_header
"""


def ply_of(form: str) -> bytes:
    """The file in one of the three formats."""
    rows: list[tuple[str, tuple]] = [("Bhh", (2, 4, 5)), ("B", (0,))]
    rows += [("Bdff", (200, *vertex)) for vertex in PLY_VERTICES]
    rows += [(f"B{len(f)}iH", (len(f), *f, 60000)) for f in PLY_FACES]
    header = PLY_HEADER.format(form).encode()
    if form == "ascii":
        return header + "".join(" ".join(map(str, row)) + "\n" for _, row in rows).encode()
    order = "<" if form == "binary_little_endian" else ">"
    return header + b"".join(struct.pack(order + kinds, *row) for kinds, row in rows)


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_files_of_every_format(functions: ctypes.CDLL, tmp_path: Path, form: str) -> None:
    path = tmp_path / "shape.ply"
    path.write_bytes(ply_of(form))
    mesh = functions.ply_read(str(path).encode())
    floats = ctypes.cast(mesh.positions, ctypes.POINTER(ctypes.c_float))
    assert np.ctypeslib.as_array(floats, (mesh.vertex_count, 3)).tolist() == [
        list(map(float, vertex)) for vertex in PLY_VERTICES
    ]
    words = ctypes.cast(mesh.triangles, ctypes.POINTER(ctypes.c_uint32))
    found = np.ctypeslib.as_array(words, (mesh.triangle_count, 3))
    assert list(map(tuple, found.tolist())) == PLY_TRIANGLES
    assert list(mesh.camera) == [1, 2, 3, 4, 5, 6, 0, 1, 0, 50]
    assert list(mesh.light) == [7, 8, 9]


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ((b"ply\n", b"plyx\n"), "does not begin with ply"),
        ((b"ascii", b"binary"), "line 2: there is no format binary"),
        ((b"property double x", b"property real x"), "line 10: there is no type real"),
        ((b"element face", b"element faces"), "has no vertices or no faces"),
        ((b"end_header", b"end"), "what is"),
        ((b"0 1 2 3 4 60000", b"0 1 2 3 5 60000"), "face 1: there is no vertex 5 among 5"),
        ((b"0 1 2 3 4 60000", b"0 1 2"), "ends too early"),
        ((b"5 0 1 2 3 4 60000", b"2 0 1 60000"), "face 1: 2 corners make no polygon"),
        ((b"200 2 1 0", b"200 2 nan 0"), "vertex 2: y is not a finite number"),
        ((b"list uchar int", b"list float int"), "a list is counted in whole numbers"),
    ],
)
def test_a_bad_ply_file_is_named(
    program: Path, tmp_path: Path, change: tuple[bytes, bytes], sentence: str
) -> None:
    path = tmp_path / "bad.ply"
    text = ply_of("ascii")
    assert text.count(change[0]) == 1
    path.write_bytes(text.replace(*change))
    done = run_program(program, str(path))
    assert done.returncode == 1
    assert str(path) in done.stderr and sentence in done.stderr


def test_a_blend_file_is_exported(program: Path, tmp_path: Path) -> None:
    bpy = pytest.importorskip("bpy")
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    blend = tmp_path / "a cube.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    (ply,) = bench.as_meshes([f"{blend}+ground"], tmp_path)
    assert ply.endswith("a cube.ply+ground")
    (record,) = records_of(run_program(program, "--kinds", "primary", "--threads", "1", ply))
    assert (record["scene"], record["triangles"]) == ("a cube+ground", 14)
    assert 0 < record["hits_whittle"]


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
