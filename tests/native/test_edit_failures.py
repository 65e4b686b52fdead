# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Changes refused, builds cancelled or out of memory leave a scene as it was, and hold nothing."""

import gc
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import meshes
import numpy as np
import pytest
from cameras import perspective
from editing import MESHES, PLACES, assert_equal, crowd, heavy, hits_of, rays
from trees import resident, wait_after_cancel
from whittle_core import Cancelled, Scene


def test_errors_name_what_is_wrong_and_change_nothing() -> None:
    model = crowd(3, 2)
    model.remove_instance(2)
    stats = model.build()
    scene, nodes = model.scene, model.scene.nodes().tobytes()
    flat = np.diag([1.0, 1, 0, 1])
    endless = meshes.transform(np.inf)
    triangles = MESHES["few"][1]
    for act, name in (
        (lambda: scene.set_transform(9, np.eye(4)), "instance.*9.*has 4"),
        (lambda: scene.set_transform(2, np.eye(4)), "instance.*2 was removed"),
        (lambda: scene.set_transform(-1, np.eye(4)), "instance"),
        (lambda: scene.set_transform(0, flat), "transform.*singular"),
        (lambda: scene.set_transform(0, endless), "transform"),
        (lambda: scene.set_transform(0, np.eye(3)), "transform"),
        (lambda: scene.remove_instance(2), "instance.*2 was removed"),
        (lambda: scene.remove_instance(4), "instance.*4"),
        (lambda: scene.remove_instance("first"), "instance"),
        (lambda: scene.replace_mesh(2, *MESHES["few"]), "mesh.*2"),
        (lambda: scene.replace_mesh(0, np.zeros((3, 2)), triangles), "positions"),
        (lambda: scene.replace_mesh(0, np.zeros((3, 3)), triangles), "triangles.*vertex"),
        (lambda: scene.replace_mesh(0, *MESHES["few"], np.zeros((1, 3))), "normals"),
        (lambda: scene.replace_mesh(0, *MESHES["few"], None, {"a": np.zeros(3)}), "uvs"),
        (lambda: scene.build(by_instance="yes"), "by_instance"),
    ):
        with pytest.raises(ValueError, match=name):
            act()
        assert scene.nodes().tobytes() == nodes, "it is still built"
    assert stats["instances"] == 3
    assert model.build()["subtrees_built"] == 0


def changes_of(scene: Scene) -> list[Callable[[], None]]:
    return [
        lambda: scene.set_transform(0, np.eye(4)),
        lambda: scene.replace_mesh(0, *MESHES["few"]),
        lambda: scene.remove_instance(1),
    ]


def test_a_changed_scene_must_be_built() -> None:
    for number in range(3):
        scene = crowd(3, 2).scene
        changes_of(scene)[number]()
        with pytest.raises(RuntimeError, match="build"):
            scene.intersect(*rays(1))
        scene.build()
        scene.intersect(*rays(1))


def test_a_busy_scene_cannot_be_edited() -> None:
    scene = crowd(3).scene
    job = scene.start(perspective(1024, 768, (3, -7, 2), (0, 0, 0)), {"samples": 64})
    while job.poll()[0] == 0 and not job.poll()[1]:
        time.sleep(0.001)
    for change in changes_of(scene):
        with pytest.raises(RuntimeError, match="scene"):
            change()
    job.cancel()
    with pytest.raises(Cancelled):
        job.result()
    for change in changes_of(scene):
        change()


def cancel_and_restore(scene: Scene, seconds: float, random: np.random.Generator) -> list[float]:
    """Cancels builds at random moments, half of them of one subtree only; how long each went on."""
    before, waits = hits_of(scene), []
    for number in range(24):
        one = number % 2 == 0
        if one:
            scene.set_transform(3, PLACES[12 + number % 3])
        # Another number of bins builds all of them.
        moment, bins = random.uniform(0, 0.06 if one else seconds), 16 if one else 32
        waits.append(wait_after_cancel(scene, moment, bins=bins, by_instance=True))
        scene.set_transform(3, PLACES[3])
        scene.build(by_instance=True)
        assert_equal(hits_of(scene), before, before)
    return [wait for wait in waits if wait is not None]


def test_cancelled_builds_leave_the_scene() -> None:
    """At random moments of building all subtrees, and of building one of them."""
    scene = heavy()
    start = time.perf_counter()
    scene.build(by_instance=True)
    whole = time.perf_counter() - start
    nodes = scene.nodes().tobytes()
    gc.collect()
    memory = resident()
    waits = cancel_and_restore(scene, whole, np.random.default_rng(8))
    assert len(waits) >= 6
    assert resident() - memory < 64 << 20, "one build takes some 20 MB"
    scene.build(bins=32, by_instance=True)
    scene.build(by_instance=True)
    assert scene.nodes().tobytes() == nodes
    with pytest.raises(Cancelled):
        scene.build(bins=32, by_instance=True, on_progress=lambda fraction: False)
    assert scene.nodes().tobytes() == nodes, "it is still built, as it was"
    assert scene.build(by_instance=True)["subtrees_built"] == 0
    print(f"cancelled {len(waits)} builds; the slowest took {max(waits) * 1e3:.1f} ms")
    assert max(waits) < 0.1


STARVED = """
import resource, sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
import editing as t
scene = t.heavy()
scene.build(by_instance=True)
nodes, hits = scene.nodes().tobytes(), t.hits_of(scene)
used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
failed = 0
for spare in (*range(0, 24, 3), *range(24, 96, 12)):
    scene.set_transform(0, t.PLACES[14])
    resource.setrlimit(resource.RLIMIT_AS, (used + (spare << 20), resource.RLIM_INFINITY))
    try:
        scene.build(threads=1, by_instance=True)
        scene.build(threads=1, bins=32, by_instance=True)
    except MemoryError as error:
        assert str(error), "no message"
        failed += 1
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY,) * 2)
    scene.set_transform(0, t.PLACES[0])
    scene.build(threads=1, by_instance=True)
    t.assert_equal(t.hits_of(scene), hits, hits)
scene.build(bins=32, by_instance=True), scene.build(by_instance=True)
assert scene.nodes().tobytes() == nodes
print(failed)
"""


def test_out_of_memory_leaves_the_scene() -> None:
    command = [sys.executable, "-c", STARVED, str(Path(__file__).parent)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) >= 4, "at several limits"


def test_replaced_and_removed_things_are_freed() -> None:
    scene = heavy()
    scene.build(by_instance=True)
    larger, smaller = meshes.torus(200, 60), meshes.torus(80, 60)

    def use(times: int) -> int:
        for k in range(times):
            scene.replace_mesh(0, *(larger if k % 2 else smaller))
            scene.build(by_instance=True)
            added = scene.add_instance(0, PLACES[5])
            scene.build(by_instance=True)
            scene.remove_instance(added)
            scene.build(by_instance=True)
        gc.collect()
        return resident()

    # What the allocator holds back goes up and down; what is lost would only go up.
    held = [use(3) for _ in range(6)]
    assert min(held[3:]) - min(held[:3]) < 16 << 20
