# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of rendered shading that need no window: images in their order, builds, cameras."""

import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest
from mathutils import Matrix, Vector


@pytest.fixture
def core(addon):
    from addon import native

    return native.load()


def hills(core, side):
    """A scene, not built, of side^2 quads."""
    x, y = np.meshgrid(np.linspace(-5, 5, side + 1), np.linspace(-5, 5, side + 1))
    positions = np.stack([x, y, np.sin(3 * x) * np.cos(2 * y)], axis=-1).reshape(-1, 3)
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).reshape(-1)
    one = np.stack([corner, corner + 1, corner + side + 2], axis=1)
    two = np.stack([corner, corner + side + 2, corner + side + 1], axis=1)
    scene = core.Scene()
    scene.add_instance(scene.add_mesh(positions, np.concatenate([one, two])), np.eye(4))
    scene.set_materials([{"diffuse": (0.8, 0.8, 0.8)}])
    scene.set_lights([{"kind": "point", "position": (1, 2, 6), "intensity": (50, 50, 50)}])
    return scene


def view(angle=0.0, size=(160, 100), samples=4, part=None):
    from addon.viewport.tracer import View

    to_world = Matrix.Rotation(angle, 4, "Z") @ Matrix.Translation((0, -9, 5))
    to_world @= Matrix.Rotation(1.0, 4, "X")
    projection = np.array([[1.4, 0, 0, 0], [0, 2.2, 0, 0], [0, 0, -1, -0.2], [0, 0, -1, 0]])
    return View(
        to_world=np.array(to_world, dtype=np.float64).tobytes(),
        projection=projection.tobytes(),
        clip=(0.1, 100.0),
        size=size,
        part=part or (0, 0, *size),
        samples=samples,
        settings=(("threads", 1),),
        scene=0,
    )


@pytest.fixture
def scene(core):
    made = hills(core, 40)
    made.build(threads=1)
    return made


@pytest.fixture
def tracer(addon):
    from addon.viewport.tracer import Tracer

    made = Tracer()
    yield made
    made.stop()


def images(tracer):
    """All images until there is nothing left to do."""
    found = []
    while tracer.busy():
        if tracer.wait(10.0):
            found.append(tracer.image)
    return found


def steps(found):
    return [(image.level.reduction, image.level.samples) for image in found]


# ---- Levels ----


def plan(pixels, speed, samples):
    from addon.viewport.levels import levels

    speeds = {1: speed, 2: speed, 4: speed} if isinstance(speed, float) else speed or {}
    return [(level.reduction, level.samples) for level in levels(pixels, speeds, samples)]


def test_the_images_of_a_view(addon):
    assert plan(1000, None, 1) == [(4, 1), (2, 1), (1, 1)]
    assert plan(1000, None, 4) == [(4, 1), (2, 1), (1, 1), (1, 4)]
    assert plan(1000, 1e9, 25) == [(1, 1), (1, 4), (1, 16), (1, 25)]
    assert plan(1000, 1e9, 16) == [(1, 1), (1, 4), (1, 16)]
    for wrong in (0, -1, 7):
        with pytest.raises(ValueError, match=f"square number .*, not {wrong}"):
            plan(1000, None, wrong)


def test_the_first_image_is_as_fine_as_is_quick(addon):
    from addon.viewport.levels import QUICK, SOON

    pixels = 1280 * 800
    assert plan(pixels, 1e3, 1) == [(4, 1), (2, 1), (1, 1)]
    assert plan(pixels, pixels / QUICK, 1) == [(1, 1)]
    assert plan(pixels, pixels / QUICK / 4, 1) == [(2, 1), (1, 1)]
    assert plan(pixels, pixels / QUICK / 4.1, 1) == [(4, 1), (1, 1)]
    assert plan(pixels, pixels / SOON, 1) == [(4, 1), (1, 1)]
    assert plan(pixels, pixels / SOON / 1.1, 1) == [(4, 1), (2, 1), (1, 1)]
    # Each by its own speed, and what was not measured by the slowest.
    assert plan(pixels, {1: pixels / SOON, 4: 1e3}, 1) == [(4, 1), (1, 1)]
    assert plan(pixels, {4: pixels / QUICK}, 1) == [(1, 1)]
    assert plan(pixels, {4: pixels / QUICK / 2}, 1) == [(2, 1), (1, 1)]


def test_coarse_images_leave_out_what_adds_little(addon):
    from addon.viewport.levels import COARSE_CUTOFF, Level

    def cutoff(reduction, asked):
        return Level(reduction, 1).settings({"cutoff": asked, "max_depth": 3})

    assert cutoff(1, 0.0) == {
        "cutoff": 0.0,
        "max_depth": 3,
        "passes": ["combined"],
        "samples": 1,
    }
    assert cutoff(4, 0.0)["cutoff"] == cutoff(2, 1 / 1024)["cutoff"] == COARSE_CUTOFF
    assert cutoff(4, 0.1)["cutoff"] == 0.1
    assert cutoff(4, -1.0)["cutoff"] == -1.0, "what is wrong is still judged by the core"


# ---- Tracer ----


def test_it_refines_to_what_a_render_gives(tracer, scene):
    wanted = view(size=(161, 99))
    tracer.show(scene, wanted)
    found = images(tracer)
    assert steps(found) == [(4, 1), (2, 1), (1, 1), (1, 4)]
    assert [image.size for image in found] == [(41, 25), (81, 50), (161, 99), (161, 99)]
    camera = wanted.camera(found[-1].level)
    whole = scene.render(camera, {"samples": 4, "threads": 1})["combined"]
    assert np.array_equal(found[-1].pixels, whole) and np.ptp(whole[..., 0]) > 0.1
    assert not tracer.show(scene, wanted) and not tracer.busy()


def test_a_part_of_a_region(tracer, scene):
    part = (20, 10, 101, 83)
    tracer.show(scene, view(samples=1, part=part))
    found = images(tracer)[-1]
    whole = scene.render(view().camera(found.level), {"threads": 1})["combined"]
    assert np.array_equal(found.pixels, whole[10:83, 20:101])


def test_a_new_view_ends_the_refinement_of_the_old_one(tracer, scene):
    tracer.show(scene, view(samples=1024, size=(1280, 800)))
    while not steps([tracer.image] if tracer.image else []) == [(1, 1)]:
        tracer.wait(10.0)
    began = time.perf_counter()
    tracer.show(scene, view(0.2, samples=1))
    assert tracer.wait(10.0)
    assert tracer.image.view == view(0.2, samples=1)
    # The samples that were given up would take minutes.
    assert time.perf_counter() - began < 5.0


def test_views_that_change_all_the_time_are_seen(tracer, scene):
    """Were the first image of each view given up for the next view, none would ever be seen."""
    seen, angle = set(), 0.0
    end = time.perf_counter() + 20.0
    while len(seen) < 5 and time.perf_counter() < end:
        angle += 0.01
        tracer.show(scene, view(angle, size=(640, 400)))
        if tracer.poll():
            seen.add(tracer.image.view)
    assert len(seen) == 5


def test_stopped_it_lets_the_scene_be_changed(tracer, scene):
    tracer.show(scene, view(size=(4000, 4000)))
    while tracer.progress()[1] == 0.0:
        time.sleep(0.001)
    with pytest.raises(RuntimeError):
        scene.set_world((1, 1, 1))
    tracer.stop()
    scene.set_world((1, 1, 1))
    assert not tracer.busy()
    assert tracer.show(scene, view()), "the same view is traced anew"


def test_an_error_of_the_core_is_raised_and_leaves_nothing_running(tracer, scene):
    wrong = view()
    object.__setattr__(wrong, "settings", (("max_depth", 1000),))
    with pytest.raises(ValueError, match="max_depth"):
        tracer.show(scene, wrong)
        tracer.wait(10.0)
    assert not tracer.busy()


# ---- Builds ----


def test_a_build_leaves_the_other_threads_alone(core):
    from addon.viewport.builder import Build

    build = Build(hills(core, 500), threads=1)
    looks = 0
    while not build.ended(0.001):
        looks += 1
    stats = build.result()
    assert stats["triangles"] == 500_000
    assert looks > 5, "Python stood still while the tree was built"


def test_a_build_can_be_given_up(core):
    from addon.viewport.builder import Build

    build = Build(hills(core, 700), threads=1)
    build.cancel()
    assert build.ended()
    with pytest.raises(core.Cancelled):
        build.result()
    assert not [thread for thread in threading.enumerate() if thread.name == "Whittle build"]


def test_an_error_of_a_build_is_raised_by_its_result(core):
    from addon.viewport.builder import Build

    with pytest.raises(ValueError, match="bins"):
        Build(hills(core, 4), bins=1).result()


# ---- Cameras ----


def ortho(start, end, half=4.0):
    """Blender's orthographic matrix of a square that is 2 half wide."""
    depth = end - start
    rows = [1 / half, 0, 0, 0], [0, 1 / half, 0, 0]
    return Matrix((*rows, [0, 0, -2 / depth, -(end + start) / depth], [0, 0, 0, 1]))


def test_an_orthographic_view_starts_behind_its_place(addon):
    from addon.viewport.camera import eye

    place = Matrix.Translation((1, 2, 3)) @ Matrix.Rotation(0.4, 4, "X")
    region = SimpleNamespace(
        view_matrix=place.inverted(), window_matrix=ortho(-50, 50), view_perspective="ORTHO"
    )
    space = SimpleNamespace(camera=None, clip_start=0.1, clip_end=1000.0)
    found = eye(space, region)
    assert found.clip == pytest.approx((0, 100), rel=1e-5)
    assert found.to_world[:3, 3] == pytest.approx(place @ Vector((0, 0, 50)), rel=1e-5)
    region.window_matrix = ortho(0.5, 20)
    found = eye(space, region)
    assert found.clip == pytest.approx((0.5, 20), rel=1e-5)
    assert found.to_world[:3, 3] == pytest.approx((1, 2, 3))


def test_the_edges_of_a_border_are_whole_pixels_inside_the_region(addon):
    from addon.viewport.camera import _inside

    everything = (0, 0, 100, 50)
    assert _inside((0, 0, 100, 50), (0.25, 0.5, 0.75, 1), everything) == (25, 25, 75, 50)
    assert _inside((10, 10, 60, 40), (0.5, 0, 0.999, 0.5), everything) == (35, 10, 60, 25)
    assert _inside((-100, -50, 200, 100), (0, 0, 1, 1), everything) == everything
    assert _inside((200, 0, 300, 50), (0, 0, 1, 1), everything) == (100, 0, 100, 50)
