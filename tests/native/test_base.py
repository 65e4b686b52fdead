# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the core stands on, compiled alone: processors under a quota, matrices."""

import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

SOURCE = Path(__file__).parents[2] / "native" / "src"
NO_QUOTA = 2**32 - 1


@pytest.fixture(scope="module")
def base(tmp_path_factory) -> ctypes.CDLL:
    """The folder base as a library of its own."""
    compiler = os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc")
    assert compiler, "these tests need the C compiler that built the core"
    library = tmp_path_factory.mktemp("base") / "base.so"
    command = [
        compiler,
        "-std=c11",
        "-O2",
        "-ffp-contract=off",
        "-D_GNU_SOURCE",
        "-shared",
        "-fPIC",
    ]
    command += [f"-I{SOURCE}", f"-I{SOURCE.parent / 'include'}", "-o", library]
    subprocess.run(
        [*command, *sorted((SOURCE / "base").glob("*.c")), "-lm", "-lpthread"], check=True
    )
    return ctypes.CDLL(library)


def quota(base: ctypes.CDLL, folder: Path, groups: str, files: dict[str, str]) -> int:
    """Processors by a made-up /proc/self/cgroup and files below a made-up /sys/fs/cgroup."""
    (folder / "groups").write_text(groups)
    for name, content in files.items():
        path = folder / "root" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content)
    base.whittle_quota_processors.restype = ctypes.c_uint32
    return base.whittle_quota_processors(
        os.fsencode(folder / "groups"), os.fsencode(folder / "root")
    )


V1 = "9:name=systemd:/\n4:memory:/a/b\n3:cpu,cpuacct:/a/b\n2:cpuset:/\n"


@pytest.mark.parametrize(
    ("groups", "files", "processors"),
    [
        ("0::/a/b\n", {"a/b/cpu.max": "250000 100000\n"}, 2),
        ("0::/a/b\n", {"a/b/cpu.max": "max 100000\n"}, NO_QUOTA),
        ("0::/a/b\n", {"a/b/cpu.max": "max 100000\n", "a/cpu.max": "300000 100000\n"}, 3),
        ("0::/a/b\n", {"a/b/cpu.max": "700000 100000\n", "a/cpu.max": "300000 100000\n"}, 3),
        ("0::/of/the/host\n", {"cpu.max": "150000 100000\n"}, 1),
        ("0::/\n", {"cpu.max": "50000 100000\n"}, 1),
        ("0::/\n", {}, NO_QUOTA),
        ("0::/\n", {"cpu.max": "nonsense"}, NO_QUOTA),
        ("", {"cpu.max": "100000 100000"}, NO_QUOTA),
        (
            V1,
            {"cpu,cpuacct/a/b/cpu.cfs_quota_us": "400000\n",
             "cpu,cpuacct/a/b/cpu.cfs_period_us": "100000\n"},
            4,
        ),
        (V1, {"cpu/cpu.cfs_quota_us": "200000", "cpu/cpu.cfs_period_us": "100000"}, 2),
        (V1, {"cpu/a/b/cpu.cfs_quota_us": "-1", "cpu/a/b/cpu.cfs_period_us": "100000"}, NO_QUOTA),
        (V1, {"memory/a/b/cpu.cfs_quota_us": "1", "memory/a/b/cpu.cfs_period_us": "1"}, NO_QUOTA),
    ],
)  # fmt: skip
def test_quota(base, tmp_path, groups, files, processors):
    assert quota(base, tmp_path, groups, files) == processors


def test_threads_keep_to_the_processors_that_the_process_may_use():
    one = min(os.sched_getaffinity(0))
    code = (
        f"import os; os.sched_setaffinity(0, [{one}]); import whittle_core;"
        "print(whittle_core.default_threads())"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert int(run.stdout) == 1


def inverse(base: ctypes.CDLL, matrix: np.ndarray) -> np.ndarray | None:
    """None where the core calls the matrix singular."""
    base.whittle_matrix_invert.restype = ctypes.c_bool
    given = (ctypes.c_double * 16)(*np.asarray(matrix, float).ravel())
    out = (ctypes.c_double * 16)()
    return np.array(out).reshape(4, 4) if base.whittle_matrix_invert(given, out) else None


def test_inverses_of_random_matrices_of_any_scale(base):
    random = np.random.default_rng(1)
    for _ in range(2000):
        rows, columns = 10.0 ** random.integers(-30, 30, (2, 4))
        core = random.normal(size=(4, 4))
        found = inverse(base, rows[:, None] * core * columns)
        expected = np.linalg.inv(core) / columns[:, None] / rows
        bound = 1e-13 * np.linalg.cond(core) * np.abs(np.linalg.inv(core)).max()
        assert (np.abs((found - expected) * columns[:, None] * rows) <= bound).all()


def test_inverses_of_powers_of_two_and_permutations_are_exact(base):
    matrix = np.zeros((4, 4))
    matrix[[0, 1, 2, 3], [2, 0, 3, 1]] = [2.0**-300, -8.0, 2.0**200, 0.5]
    assert np.array_equal(matrix @ inverse(base, matrix), np.eye(4))


def shear(amount: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[0, 1] = amount
    return matrix


@pytest.mark.parametrize("matrix", [shear(1e4), np.diag([1, 1, 1e-12, 1]), np.diag([-1, 1, 1, 1])])
def test_stiff_matrices_are_inverted(base, matrix):
    assert inverse(base, matrix) @ matrix == pytest.approx(np.eye(4), abs=1e-9)


def rotated_and_flattened() -> np.ndarray:
    turned, _ = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))
    matrix = np.eye(4)
    matrix[:3, :3] = turned @ np.diag([1, 1, 0]) @ turned.T
    return matrix


@pytest.mark.parametrize(
    "matrix",
    [
        np.zeros((4, 4)),
        np.diag([1, 0, 1, 1]),
        np.ones((4, 4)),
        rotated_and_flattened(),
        np.diag([1, np.nan, 1, 1]),
        np.diag([1, np.inf, 1, 1]),
    ],
)
def test_singular_matrices_are_refused(base, matrix):
    assert inverse(base, matrix) is None
