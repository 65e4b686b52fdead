# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that the benchmark reads: .obj, .ply of every format, .blend; bad ones are named."""

from __future__ import annotations

import ctypes
import struct
from pathlib import Path

import numpy as np
import pytest
from bench_tools import bench, records_of, run_program


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
