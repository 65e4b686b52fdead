# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The module whittle_core, its meshes and its instances, as its .pyi promises."""

import array
import ast
import inspect
import subprocess
import sys
from math import inf, nan
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest
import whittle_core
from small_scenes import DOWN, ONE, TRIANGLE, built, changed
from whittle_core import Scene

STUB = Path(__file__).parents[2] / "native" / "python" / "whittle_core.pyi"


# ---- The module itself ---------------------------------------------------------------------------


def test_signatures_are_those_of_the_stub():
    (scene,) = (
        node
        for node in ast.parse(STUB.read_text()).body
        if isinstance(node, ast.ClassDef) and node.name == "Scene"
    )
    methods = {node.name: node.args for node in scene.body if isinstance(node, ast.FunctionDef)}
    assert methods.keys() == {name for name in dir(Scene) if not name.startswith("_")}
    for name, arguments in methods.items():
        parameters = list(inspect.signature(getattr(Scene, name)).parameters.values())[1:]
        names = [argument.arg for argument in arguments.args[1:]]
        required = len(names) - len(arguments.defaults)
        assert [p.name for p in parameters] == names + [a.arg for a in arguments.kwonlyargs], name
        assert [p.name for p in parameters if p.default is p.empty] == names[:required], name
        assert [p.name for p in parameters if p.kind is not p.KEYWORD_ONLY] == names, name


def test_module_holds_what_the_stub_declares():
    declared = {
        node.target.id if isinstance(node, ast.AnnAssign) else node.name
        for node in ast.parse(STUB.read_text()).body
        if isinstance(node, ast.AnnAssign | ast.FunctionDef | ast.ClassDef)
    }
    assert declared == {
        name for name in dir(whittle_core) if not name.startswith("_") or name == "__version__"
    } - {"__name__"}


def test_instruction_sets():
    assert whittle_core.isa() in whittle_core.isas()
    assert set(whittle_core.isas()) <= {"sse4.2", "avx2", "avx512"}
    assert whittle_core.isas()[0] == "sse4.2"


@pytest.mark.parametrize("isa", ["avx9000", "AVX2 ", *({"avx512"} - set(whittle_core.isas()))])
def test_unavailable_instruction_set_is_an_error(isa):
    program = (
        "import whittle_core as w\n"
        "scene = w.Scene()\n"
        "scene.build()\n"
        "for act in w.isa, lambda: scene.intersect([[0, 0, 0]], [[0, 0, 1]]):\n"
        "    try:\n        act()\n"
        "    except RuntimeError as error:\n        assert 'WHITTLE_ISA' in str(error), error\n"
        "    else:\n        raise SystemExit(f'{act} went through')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], env={"WHITTLE_ISA": isa}, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr


def test_numpy_is_imported_when_it_is_needed():
    program = (
        "import sys, whittle_core\n"
        "scene = whittle_core.Scene()\n"
        "assert 'numpy' not in sys.modules\n"
        "scene.build()\n"
        "scene.nodes()\n"
        "assert 'numpy' in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


def test_it_loads_in_another_interpreter_of_the_process():
    program = (
        "try:\n    import _interpreters as other\n    made = other.create('legacy')\n"
        "except ImportError:\n"
        "    import _xxsubinterpreters as other\n    made = other.create(isolated=False)\n"
        "import whittle_core as w\n"
        "inside = 'import whittle_core as w; w.Scene().build(); assert w.isa(); print(w.isa())'\n"
        "failure = other.run_string(made, inside)\n"
        "assert failure is None, failure\n"
        "other.destroy(made)\n"
        "assert w.Scene().build()['nodes'] == 0\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == whittle_core.isa()


def test_types_cannot_be_misused():
    with pytest.raises(TypeError):
        Scene(1)
    with pytest.raises(TypeError):
        whittle_core.Job()


# ---- Meshes --------------------------------------------------------------------------------------


def packed(dtype: str) -> np.ndarray:
    """The triangle in a structured array whose floats are not aligned."""
    rows = np.zeros(3, np.dtype([("pad", "u1"), ("co", dtype, 3)]))
    rows["co"] = TRIANGLE
    return rows["co"]


@pytest.mark.parametrize(
    "positions",
    [
        TRIANGLE.tolist(),
        TRIANGLE.astype(np.float64),
        TRIANGLE.astype(np.float16),
        TRIANGLE.astype(">f4"),
        TRIANGLE.astype(np.int8),
        np.asfortranarray(TRIANGLE),
        np.repeat(TRIANGLE, 2, axis=0)[::2],
        TRIANGLE[::-1].copy()[::-1],
        packed("f4"),
        packed("f8"),
        memoryview(array.array("f", TRIANGLE.ravel())).cast("B").cast("f", [3, 3]),
    ],
    ids=lambda value: getattr(value, "dtype", type(value)).__class__.__name__,
)
@pytest.mark.parametrize("triangles", [[[0, 1, 2]], ONE.astype(">i8"), ONE.astype(np.uint64), ONE])
def test_meshes_from_any_array(positions, triangles):
    hits = built(positions, triangles).intersect(*DOWN)
    assert (hits["t"], hits["triangle"], hits["u"], hits["v"]) == (1, 0, 0.25, 0.25)


def test_indices_count_from_zero():
    scene = Scene()
    assert [scene.add_mesh(TRIANGLE, ONE) for _ in range(3)] == [0, 1, 2]
    assert [scene.add_instance(2, np.eye(4)) for _ in range(2)] == [0, 1]


def test_arrays_are_copied():
    positions, triangles = TRIANGLE.copy(), ONE.copy()
    scene = Scene()
    scene.add_instance(scene.add_mesh(positions, triangles), np.eye(4))
    positions[:], triangles[:] = nan, 99
    scene.build()
    assert scene.intersect(*DOWN)["t"] == 1


BAD_MESHES = {
    "positions": [
        TRIANGLE[:, :2],
        TRIANGLE.ravel(),
        TRIANGLE[None],
        TRIANGLE + 1j,
        TRIANGLE.astype(str),
        TRIANGLE.astype(bool),
        TRIANGLE.astype(object),
        "abc",
        None,
        [[0, 0, 0], [1, 0]],
        np.datetime64("2026-01-01"),
    ],
    "triangles": [
        ONE.astype(np.float32),
        ONE[0],
        ONE[:, :2],
        [[0, 1, 3]],
        [[0, 1, -1]],
        [[0, 1, 2**32]],
        np.uint64([[0, 1, 2**64 - 1]]),
        [["a", "b", "c"]],
        {},
    ],
    "normals": [TRIANGLE[:2], TRIANGLE[None, None], TRIANGLE[None, :2], "up", TRIANGLE * 1j],
    "uvs": [
        TRIANGLE,
        {"UVMap": TRIANGLE},
        {"UVMap": TRIANGLE[:2, :2]},
        {3: TRIANGLE[:, :2]},
        {"UVMap": None},
        3,
    ],
    "materials": [[0, 1], [0.5], [-1], [[0]], 0, "a"],
}


@pytest.mark.parametrize(
    ("name", "value"), [(name, value) for name, values in BAD_MESHES.items() for value in values]
)
def test_bad_meshes_name_the_argument(name, value):
    arguments = {"positions": TRIANGLE, "triangles": ONE, name: value}
    scene = Scene()
    with pytest.raises(ValueError, match=rf"^{name}\b"):
        scene.add_mesh(**arguments)
    assert scene.add_mesh(TRIANGLE, ONE) == 0, "the scene is as before"


def test_names_of_texture_coordinates_are_told():
    with pytest.raises(ValueError, match=r"^uvs\['Ü 1'\] must have shape \(3, 2\) or \(1, 3, 2\)"):
        Scene().add_mesh(TRIANGLE, ONE, uvs={"Ü 1": TRIANGLE})


def test_normals_uvs_and_materials_in_both_shapes():
    scene = Scene()
    corner = np.tile(np.float32([0, 0, 1]), (1, 3, 1))
    for normals in (corner, corner[0]):
        scene.add_mesh(TRIANGLE, ONE, normals=normals, materials=[3], uvs={"a": TRIANGLE[:, :2]})
    maps = MappingProxyType({"a": corner[..., :2], "b": TRIANGLE[:, :2]})
    assert scene.add_mesh(TRIANGLE, ONE, normals, maps, np.int16([0])) == 2


# ---- Instances -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "value"),
    [("transform", value) for value in (np.zeros((4, 4)), changed(0, 3, nan), changed(1, 1, inf))]
    + [("transform", value) for value in (changed(2, 2, 0), changed(3, 0, 1), changed(3, 3, 2))]
    + [("transform", value) for value in (np.eye(3), np.eye(4)[0], "M", None, np.eye(4) * 1j)]
    + [("mesh", value) for value in (1, -1, 2**32, 0.0, None, "0")]
    + [("object_id", value) for value in (2**31, -(2**31) - 1, 0.5)]
    + [("visibility", value) for value in (-1, 16, 1.0, None)],
)
def test_bad_instances_name_the_argument(name, value):
    scene = Scene()
    scene.add_mesh(TRIANGLE, ONE)
    with pytest.raises(ValueError, match=rf"\b{name}\b"):
        scene.add_instance(**{"mesh": 0, "transform": np.eye(4), name: value})
    assert scene.add_instance(0, np.eye(4)) == 0, "the scene is as before"


def test_transform_maps_column_vectors():
    moved = np.float32([[0, -2, 0, 5], [2, 0, 0, 6], [0, 0, 2, 7], [0, 0, 0, 1]])
    vertices = (moved @ np.c_[TRIANGLE, np.ones(3)].T).T[:, :3]
    origins = vertices.mean(axis=0)[None] + [0, 0, 1]
    for transform in (moved, moved.tolist(), np.asfortranarray(moved)):
        hits = built(TRIANGLE, ONE, [transform]).intersect(origins, [[0, 0, -1]])
        np.testing.assert_allclose(hits["t"], 1, rtol=1e-6)
        np.testing.assert_allclose([hits["u"], hits["v"]], 1 / 3, rtol=1e-5)
