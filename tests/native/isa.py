# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs test functions in processes that use another instruction set or another build."""

import multiprocessing
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import isa_child
import whittle_core

ISAS: tuple[str, ...] = whittle_core.isas()


@contextmanager
def process(isa: str, folder: Path | None = None) -> Iterator[Callable[..., Any]]:
    """Gives run(function, *arguments), which calls a module-level function in a new process; with
    `folder` that process imports the whittle_core that lies there."""
    context = multiprocessing.get_context("spawn")
    chosen = (isa, str(folder) if folder else None)
    with ProcessPoolExecutor(1, context, initializer=isa_child.prepare, initargs=chosen) as pool:
        used, path = pool.submit(isa_child.loaded).result()
        assert used == isa, f"asked for {isa}, got {used}"
        assert folder is None or Path(path).is_relative_to(folder), f"loaded {path}"
        yield lambda function, *arguments: pool.submit(function, *arguments).result()
