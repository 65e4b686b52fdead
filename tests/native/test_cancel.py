# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cancelling the heaviest build and frame at random moments: soon over, and nothing kept."""

import gc
import time
from collections.abc import Callable
from pathlib import Path

import identity
import meshes
import numpy as np
import pytest
import whittle_core
from cameras import perspective

MOMENTS = 20
LIMIT = 0.1  #: seconds
ROOM = 24 << 20  #: bytes by which memory may have grown after all cancels
TRIANGLES = 600_000


def resident() -> int:
    """Bytes of this process in memory."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


def cancel_at(share: float, whole: float, work: Callable[[Callable], None]) -> float | None:
    """Seconds from the progress callback's False to the end; None if the work ended first."""
    stopped: list[float] = []
    start = time.monotonic()

    def report(fraction: float) -> bool:
        assert 0 <= fraction <= 1
        if not stopped and time.monotonic() - start < share * whole:
            return True
        stopped.append(time.monotonic())
        return False

    try:
        work(report)
    except whittle_core.Cancelled:
        return time.monotonic() - stopped[0]
    return None


def seconds_of(work: Callable[[Callable], None]) -> float:
    """What the work takes when nothing else holds it up, or nearly."""
    times = []
    for _ in range(3):
        start = time.monotonic()
        work(lambda _: True)
        times.append(time.monotonic() - start)
    return min(times)


def worst_of(work: Callable[[Callable], None], seed: int) -> float:
    """The longest of the waits, over random moments of the time that the work takes."""
    whole = seconds_of(work)
    before = resident()
    waits = []
    for share in np.random.default_rng(seed).uniform(0, 0.95, MOMENTS):
        waits.append(cancel_at(share, whole, work))
    gc.collect()
    done = [wait for wait in waits if wait is not None]
    assert len(done) > MOMENTS // 2, f"only {len(done)} of {MOMENTS} came in time"
    assert resident() - before < ROOM
    print(
        f"{len(done)} cancels of {whole:.2f} s of work: the longest took {max(done) * 1e3:.1f} ms"
    )
    return max(done)


@pytest.fixture(scope="module")
def heavy() -> whittle_core.Scene:
    """Many triangles in many instances of several meshes."""
    scene = identity.lit([identity.DIFFUSE, identity.MIRROR, identity.GLASS])
    random = np.random.default_rng(57)
    kinds = [meshes.icosphere(5), meshes.torus(160, 64), meshes.boxes(1500)]
    built = [
        scene.add_mesh(*mesh, materials=np.full(len(mesh[1]), k, np.uint32))
        for k, mesh in enumerate(kinds)
    ]
    total = 0
    while total < TRIANGLES:
        k = int(random.integers(3))
        scene.add_instance(built[k], meshes.transform(0.4, random.uniform(-2, 2, 3)))
        total += len(kinds[k][1])
    return scene


def test_build_cancels(heavy: whittle_core.Scene) -> None:
    heavy.build()
    tree = heavy.nodes()
    worst = worst_of(lambda report: heavy.build(on_progress=report), 1)
    assert worst < LIMIT
    assert np.array_equal(heavy.nodes(), tree), "after a cancel the scene is as it was before"


def test_frame_cancels(heavy: whittle_core.Scene) -> None:
    heavy.build()
    camera = perspective(640, 400, (4, -5, 3), (0, 0, 0))
    settings = {"samples": 1, "max_depth": 4, "passes": ("combined", "depth")}
    right = heavy.render(camera, {"samples": 1})["combined"]
    worst = worst_of(lambda report: heavy.render(camera, settings, report), 2)
    assert worst < LIMIT
    assert np.array_equal(heavy.render(camera, {"samples": 1})["combined"], right)


def test_jobs_cancel(heavy: whittle_core.Scene) -> None:
    """Jobs in the background end as soon, whatever they were at."""
    heavy.build()
    camera = perspective(640, 400, (4, -5, 3), (0, 0, 0))
    worst = 0.0
    for delay in np.random.default_rng(3).uniform(0, 0.3, 10):
        job = heavy.start(camera, {"samples": 16})
        time.sleep(delay)
        start = time.monotonic()
        job.cancel()
        with pytest.raises(whittle_core.Cancelled):
            job.result()
        worst = max(worst, time.monotonic() - start)
    print(f"the longest of 10 jobs took {worst * 1e3:.1f} ms to end")
    assert worst < LIMIT
