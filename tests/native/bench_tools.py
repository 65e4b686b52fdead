# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark in the hands of its tests: the program, and its functions as a library."""

from __future__ import annotations

import ctypes
import importlib.util
import json
import os
import subprocess
from pathlib import Path
from types import ModuleType
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
BENCH = ROOT / "native" / "bench"
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


def load_bench() -> ModuleType:
    """bench.py as a module."""
    spec = importlib.util.spec_from_file_location("bench", BENCH / "bench.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


bench = load_bench()


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


def load_functions(folder: Path) -> ctypes.CDLL:
    """The functions that need neither side, as a library of their own that is put into a folder."""
    library = folder / "functions.so"
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
