# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What tests of the benchmark share: it is built when the first of them asks for it."""

from __future__ import annotations

import ctypes
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def program() -> Path:
    """The benchmark program, built from this checkout."""
    from bench_tools import bench

    return bench.build_program()


@pytest.fixture(scope="session")
def functions(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """The benchmark's functions that need neither the core nor Embree."""
    from bench_tools import load_functions

    return load_functions(tmp_path_factory.mktemp("functions"))
