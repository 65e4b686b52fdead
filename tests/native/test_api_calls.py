# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How calls of whittle_core behave while they run: progress, threads, jobs, failures and memory."""

import gc
import os
import resource
import subprocess
import sys
import threading
import time
import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import meshes
import numpy as np
import pytest
import whittle_core
from small_scenes import ONE, TRIANGLE, built, camera, rays
from whittle_core import Cancelled, Scene


@pytest.fixture(scope="module")
def large() -> tuple:
    """A mesh whose build with one thread and many bins takes a good part of a second."""
    return meshes.random_triangles(600_000, 0.01, seed=5)


@pytest.fixture(scope="module")
def soup() -> Scene:
    return built(*meshes.random_triangles(2000, 0.1, seed=3))


def slow_render() -> tuple[dict, dict]:
    """A camera and settings that keep two cores busy for seconds."""
    return camera(1024, 768), {"samples": 64}


def wait_until_busy(job: whittle_core.Job) -> None:
    while job.poll()[0] == 0 and not job.poll()[1]:
        time.sleep(0.001)
    assert not job.poll()[1], "the job was too quick to be caught"


# ---- Progress ------------------------------------------------------------------------------------


def both_calls(large: tuple) -> list:
    scene = built(*large)
    view, settings = slow_render()
    settings |= {"samples": 16, "threads": 1}
    return [
        lambda report: scene.build(bins=32, threads=1, on_progress=report),
        lambda report: scene.render(view, settings, report),
    ]


def test_progress_is_steady_and_on_the_calling_thread(large):
    """One report at the start and one each 50 ms, however long the machine takes."""
    for call in both_calls(large):
        reports, threads = [], set()

        def report(fraction, reports=reports, threads=threads):
            reports.append(fraction)
            threads.add(threading.get_ident())

        start = time.perf_counter()
        call(report)
        elapsed = time.perf_counter() - start
        assert threads == {threading.get_ident()}
        assert reports == sorted(reports) and 0 <= reports[0] and reports[-1] <= 1
        assert len(reports) >= 2, f"{elapsed:.3f} s are too quick to tell"
        assert 5 * elapsed <= len(reports) <= 20 * elapsed + 1


@pytest.mark.parametrize("answer", [False, 0, np.False_])
def test_false_cancels(large, answer):
    for call in both_calls(large):
        with pytest.raises(Cancelled):
            call(lambda fraction: answer)


def test_none_and_true_go_on(soup):
    for answer in (None, True, 1):
        assert soup.render(camera(), on_progress=lambda fraction, a=answer: a)
    assert soup.render(camera(), None, None)


def test_exceptions_of_the_callback_come_through(large):
    def fail(fraction):
        raise LookupError("as given")

    for call in both_calls(large):
        with pytest.raises(LookupError, match="as given"):
            call(fail)


def test_a_cancelled_build_leaves_the_scene_as_it_was(large):
    scene = built(TRIANGLE, ONE)
    hits = scene.intersect([[0.2, 0.2, 1]], [[0, 0, -1]])
    scene.add_instance(scene.add_mesh(*large), np.eye(4))
    with pytest.raises(Cancelled):
        scene.build(on_progress=lambda fraction: False)
    with pytest.raises(RuntimeError, match="build"):
        scene.nodes()
    assert scene.build()["triangles"] == 600_001
    assert scene.intersect([[0.2, 0.2, 1]], [[0, 0, -1]]).keys() == hits.keys()


def test_a_signal_ends_a_render():
    program = (
        "import signal, sys\n"
        "sys.path.insert(0, sys.argv[1])\n"
        "import meshes, test_api_calls as t\n"
        "scene = t.built(*meshes.random_triangles(2000, 0.1, seed=3))\n"
        "view, settings = t.slow_render()\n"
        "signal.setitimer(signal.ITIMER_REAL, 0.3)\n"
        "class Alarm(Exception): pass\n"
        "def ring(*_): raise Alarm\n"
        "signal.signal(signal.SIGALRM, ring)\n"
        "act = {'render': scene.render, 'job': lambda *a: scene.start(*a).result()}[sys.argv[2]]\n"
        "try:\n    act(view, dict(settings, samples=4096))\n"
        "except Alarm:\n    sys.exit(7)\n"
    )
    for act in ("render", "job"):
        command = [sys.executable, "-c", program, str(Path(__file__).parent), act]
        assert subprocess.run(command, timeout=60).returncode == 7


# ---- Threads -------------------------------------------------------------------------------------


class Ticking(threading.Thread):
    """Counts as fast as the interpreter's lock lets it."""

    def __enter__(self):
        self.count, self.ending = 0, False
        self.start()
        return self

    def run(self):
        while not self.ending:
            self.count += 1
            time.sleep(0.0005)

    def __exit__(self, *_):
        self.ending = True
        self.join()


def test_python_runs_on_meanwhile(large):
    origins, directions = rays(400_000)
    few = origins[:20], directions[:20]
    scene = built(*large)
    view = camera(640, 480)
    calls = {
        "build": scene.build,
        "intersect": lambda: scene.intersect(origins, directions, threads=1),
        "occluded": lambda: scene.occluded(origins, directions, threads=1),
        "reference_intersect": lambda: scene.reference_intersect(*few, threads=1),
        "render": lambda: scene.render(view, {"samples": 4}),
        "result": lambda: job.result(),
    }
    with Ticking() as ticking:
        for name, call in calls.items():
            if name == "result":
                job = scene.start(view, {"samples": 4})
            before, start = ticking.count, time.perf_counter()
            call()
            elapsed = time.perf_counter() - start
            assert elapsed > 0.02, f"{name} is too quick to tell"
            assert ticking.count - before >= 50 * elapsed, name


def test_results_do_not_depend_on_threads_or_packets(soup):
    origins, directions = rays(3000)
    wanted = soup.intersect(origins, directions, threads=1, packet=1)
    for options in ({"threads": 2}, {"threads": 7}, {"packet": 64}, {"packet": 256, "threads": 3}):
        for name, column in soup.intersect(origins, directions, **options).items():
            np.testing.assert_array_equal(column.view("u4"), wanted[name].view("u4"))


def test_many_threads_trace_one_scene(soup):
    origins, directions = rays(5000)
    wanted = soup.intersect(origins, directions)["t"]
    image = soup.render(camera())["combined"]
    with ThreadPoolExecutor(8) as pool:
        traced = [pool.submit(soup.intersect, origins, directions, threads=2) for _ in range(16)]
        drawn = [pool.submit(soup.render, camera(), {"threads": 2}) for _ in range(16)]
        for future in traced:
            np.testing.assert_array_equal(future.result()["t"], wanted)
        for future in drawn:
            np.testing.assert_array_equal(future.result()["combined"], image)


def test_a_busy_scene_cannot_be_changed():
    scene = built(*meshes.random_triangles(2000, 0.1, seed=3))
    job = scene.start(*slow_render())
    wait_until_busy(job)
    changes = [
        lambda: scene.add_mesh(TRIANGLE, ONE),
        lambda: scene.add_instance(0, np.eye(4)),
        lambda: scene.set_materials([]),
        lambda: scene.set_lights([]),
        lambda: scene.set_world((1, 1, 1)),
        scene.build,
    ]
    for change in changes:
        with pytest.raises(RuntimeError, match="scene"):
            change()
    assert scene.occluded(*rays(10)).shape == (10,), "others may trace meanwhile"
    job.cancel()
    with pytest.raises(Cancelled):
        job.result()
    for change in changes:
        change()


def test_changes_that_meet_fail_or_succeed_whole(large):
    """Two threads that change one scene: each call either happens or says that it is busy."""

    def add(scene):
        try:
            return scene.add_mesh(*large)
        except RuntimeError:
            return None

    scene = Scene()
    with ThreadPoolExecutor(4) as pool:
        added = [index for index in pool.map(add, [scene] * 12) if index is not None]
    assert sorted(added) == list(range(len(added)))
    assert scene.build()["meshes"] == len(added)


@pytest.mark.parametrize("change", ["mesh", "instance"])
def test_tracing_needs_a_build_after_the_last_change(change):
    scene = Scene()
    acts = [
        lambda: scene.intersect(*rays(1)),
        lambda: scene.occluded(*rays(1)),
        lambda: scene.reference_intersect(*rays(1)),
        lambda: scene.render(camera()),
        lambda: scene.start(camera()).result(),
        scene.nodes,
        scene.triangles,
    ]
    for _ in range(2):
        for act in acts:
            with pytest.raises(RuntimeError, match="build"):
                act()
        scene.build()
        for act in acts:
            act()
        mesh = scene.add_mesh(TRIANGLE, ONE)
        if change == "instance":
            scene.build()
            scene.add_instance(mesh, np.eye(4))


# ---- Jobs ----------------------------------------------------------------------------------------


def test_a_job_gives_what_render_gives(soup):
    wanted = soup.render(camera(), {"passes": ["combined", "depth"]})
    job = soup.start(camera(), {"passes": ["combined", "depth"]})
    result = job.result()
    assert job.poll() == (1.0, True)
    assert result.keys() == wanted.keys() == {"combined", "depth", "stats"}
    for name in ("combined", "depth"):
        np.testing.assert_array_equal(result[name], wanted[name])
    assert result["stats"]["rays"] == wanted["stats"]["rays"]
    assert job.result() is result


def test_a_cancelled_job_stays_cancelled(soup):
    job = soup.start(*slow_render())
    wait_until_busy(job)
    start = time.perf_counter()
    job.cancel()
    for _ in range(2):
        with pytest.raises(Cancelled):
            job.result()
    assert time.perf_counter() - start < 2
    assert job.poll()[1]
    job.cancel()


def test_a_job_raises_what_render_raises(soup):
    with pytest.raises(ValueError, match="samples"):
        soup.start(camera(), {"samples": 3}).result()


def test_a_job_keeps_its_scene():
    job = built(*meshes.random_triangles(2000, 0.1, seed=3)).start(camera(256, 256))
    gc.collect()
    assert job.result()["combined"].any()


def test_a_running_job_may_be_dropped():
    scene = built(*meshes.random_triangles(2000, 0.1, seed=3))
    for _ in range(3):
        wait_until_busy(scene.start(*slow_render()))
        scene.build()
    abandoned = "import sys; sys.path.insert(0, sys.argv[1]); import test_api_calls as t, meshes\n"
    abandoned += "scene = t.built(*meshes.random_triangles(2000, 0.1, seed=3))\n"
    abandoned += "job = scene.start(*t.slow_render()); t.wait_until_busy(job)\n"
    command = [sys.executable, "-c", abandoned, str(Path(__file__).parent)]
    assert subprocess.run(command, timeout=30).returncode == 0


def test_a_job_in_a_cycle_is_collected(soup):
    class Mark:
        dropped = False

        def __del__(self):
            Mark.dropped = True

    job = soup.start(camera())
    result = job.result()
    result["self"], result["mark"] = job, Mark()
    del job, result
    gc.collect()
    assert Mark.dropped


# ---- Memory --------------------------------------------------------------------------------------


def test_rays_are_not_copied(soup):
    soup.intersect(*rays(10))
    origins, directions = (np.asfortranarray(values) for values in rays(200_000))
    tracemalloc.start()
    hits = soup.intersect(origins, directions.astype(np.float32))
    results = sum(column.nbytes for column in hits.values())
    argument = directions.nbytes // 2
    assert tracemalloc.get_traced_memory()[1] < results + argument + 100_000
    tracemalloc.stop()


def test_no_reference_is_kept_or_lost():
    positions, normals = TRIANGLE.copy(), np.ones((3, 3), np.float32)
    maps, matrix = {"a": TRIANGLE[:, :2].copy()}, np.eye(4)
    origins, directions = rays(10)
    view, settings = camera(), {"samples": 4, "passes": ["combined", "nodes"]}
    held = [positions, normals, maps, maps["a"], matrix, origins, directions, view, settings]
    held += [view["to_world"], settings["passes"]]

    def use():
        scene = Scene()
        mesh = scene.add_mesh(positions, ONE, normals, maps)
        scene.add_instance(mesh, matrix)
        scene.set_materials([{"diffuse": (1, 1, 1)}])
        scene.build(on_progress=lambda fraction: None)
        scene.intersect(origins, directions, counters=True)
        scene.render(view, settings)
        scene.start(view, settings).result()
        for bad in ({"normals": positions[:2]}, {"uvs": {"a": matrix}}, {"materials": matrix}):
            with pytest.raises(ValueError):
                scene.add_mesh(positions, ONE, **bad)
        with pytest.raises(ValueError):
            scene.intersect(origins, directions, t_min=directions)
        with pytest.raises(ValueError):
            scene.render(view, dict(settings, samples=5))

    use()
    before = [sys.getrefcount(value) for value in held]
    for _ in range(50):
        use()
    assert [sys.getrefcount(value) for value in held] == before


def test_scenes_and_images_are_freed():
    positions, triangles = meshes.random_triangles(20_000, 0.1, seed=3)

    def resident() -> int:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * resource.getpagesize()

    def use(times: int) -> int:
        for _ in range(times):
            scene = built(positions, triangles)
            scene.render(camera(128, 128), {"passes": ["combined", "nodes"]})
            scene.intersect(*rays(2_000))
            scene.start(*slow_render()).cancel()
        gc.collect()
        return resident()

    before = use(10)
    assert use(30) - before < 8e6, "a scene takes 3 MB and the job's image 12 MB"


STARVED = """
import resource, sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
import meshes, small_scenes, numpy as np, whittle_core
scene = whittle_core.Scene()
positions, triangles = meshes.random_triangles(300_000, 0.01, seed=5)
scene.add_instance(scene.add_mesh(positions, triangles), np.eye(4))
small = small_scenes.built(*meshes.random_triangles(10, 0.1, seed=3))
small.render(small_scenes.camera())
used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()

def starve(spare, act):
    resource.setrlimit(resource.RLIMIT_AS, (used + spare, resource.RLIM_INFINITY))
    try:
        act()
    except MemoryError as error:
        assert str(error), "no message"
    else:
        raise SystemExit(f"{act} went through")
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY,) * 2)

starve(12_000_000, scene.build)
starve(12_000_000, lambda: scene.add_mesh(np.tile(positions, (4, 1)), triangles))
starve(50_000_000, lambda: small.render(small_scenes.camera(4096, 4096)))
starve(50_000_000, lambda: small.start(small_scenes.camera(4096, 4096)))
starve(50_000_000, lambda: small.render(small_scenes.camera(2**32 - 1, 2**32 - 1)))
assert scene.build()["triangles"] == 300_000
assert small.render(small_scenes.camera())["combined"].any()
"""


def test_out_of_memory_is_a_memory_error():
    # Freed memory goes back to the system, so that the limit is not met from what is left over.
    settings = {**os.environ, "MALLOC_ARENA_MAX": "1", "MALLOC_MMAP_THRESHOLD_": "65536"}
    command = [sys.executable, "-c", STARVED, str(Path(__file__).parent)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, env=settings)
    assert done.returncode == 0, done.stderr
