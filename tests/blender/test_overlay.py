# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The viewport's heatmap without a window: views, metrics, refinement, the scene that is kept."""

import time

import bpy
import numpy as np
from viewing import SIZE, finish, look, ready, wanted

# ---- Views ---------------------------------------------------------------------------------------


def test_a_view_renders_as_the_camera_that_it_copies(scene, stage, addon):
    from addon.export import camera as cameras
    from addon.notes import Notes

    for kind in ("PERSP", "ORTHO"):
        view = look(scene, type=kind, ortho_scale=6.0, shift_x=0.1)
        graph = bpy.context.evaluated_depsgraph_get()
        shot = cameras.export(graph, scene.camera, SIZE, (0, 0, *SIZE), Notes())
        settings = {"passes": ["position", "nodes"]}
        one = stage.scene.render(shot, settings)
        other = stage.scene.render(view.camera(), settings)
        assert abs(one["position"] - other["position"]).max() < 1e-4
        assert (one["nodes"] == other["nodes"]).mean() > 0.99


def test_orthographic_views_see_what_lies_behind_them(stage):
    """Blender's begin half of the clip distance behind the point that they turn around."""
    from addon.inspect.view import View

    view = np.eye(4)
    view[2, 3] = 0.0  # looks down from the middle of the cube
    window = np.diag([0.25, 0.375, -2.0 / 100.0, 1.0])
    here = View(tuple(view.flat), tuple(window.flat), SIZE, (0.01, 50.0))
    image = stage.scene.render(here.camera(), {"passes": ["position"]})
    assert np.isclose(image["position"][32, 48, 2], 1.0)
    assert here.camera()["clip_start"] == 0.0 and np.isclose(here.camera()["clip_end"], 100.0)


def test_a_divisor_makes_the_same_view_smaller(scene, stage):
    camera = look(scene).camera(5)
    assert (camera["width"], camera["height"]) == (20, 13)


# ---- Metrics -------------------------------------------------------------------------------------


def test_kinds_and_weights_add_up(scene, stage):
    from addon.inspect.metrics import KINDS, Choice

    view = look(scene)

    def values(**choice):
        made = Choice(**choice)
        return made.values(stage.scene.render(view.camera(), {"passes": made.passes()}))

    nodes, triangles = values(metric="NODES"), values(metric="TRIANGLES")
    assert nodes.shape == SIZE[::-1] and nodes.dtype == np.float32 and nodes.min() >= 1
    parts = [values(metric="NODES", kinds=frozenset({kind})) for kind in KINDS]
    assert np.array_equal(sum(parts), nodes) and parts[1].any()
    some = values(metric="NODES", kinds=frozenset({"primary", "shadow"}))
    assert np.array_equal(some, parts[0] + parts[1])
    both = values(metric="BOTH", weights=(2.0, 0.5))
    assert np.array_equal(both, 2 * nodes + np.float32(0.5) * triangles)
    assert not values(metric="NODES", kinds=frozenset()).any()


def test_depth_coherence_and_time(scene, stage):
    from addon.inspect.heat import Heat

    def shown(metric):
        heat = Heat()
        heat.want(wanted(scene, stage, look(scene), metric=metric))
        finish(heat, stage)
        return heat.picture

    depth = shown("LEAF_DEPTH")
    assert depth.highest == depth.values.max() <= stage.build["depth"] and depth.values.any()
    assert (depth.values == np.rint(depth.values)).all()
    coherence = shown("COHERENCE")
    assert 0 < coherence.mean and 1.5 < coherence.highest <= 100 and coherence.top == 100
    seconds = shown("SECONDS")
    assert (seconds.values > 0).all() and seconds.mean < 1e6
    assert len(np.unique(seconds.values)) <= 6 * 4  # tiles


# ---- Heatmaps ------------------------------------------------------------------------------------


def test_a_heatmap_comes_coarse_first_and_ends_exact(scene, stage):
    from addon.inspect.heat import Heat

    heat, view = Heat(), look(scene)
    heat.want(wanted(scene, stage, view))
    divisors = finish(heat, stage)
    assert divisors[0] > 1 and divisors[-1] == 1
    assert divisors == sorted(divisors, reverse=True)
    exact = stage.scene.render(view.camera(), {"passes": ["nodes"], "samples": 1})
    assert np.array_equal(heat.picture.values, exact["nodes"][..., 0])
    assert heat.picture.highest == exact["nodes"].max() and heat.finished and not heat.busy


def test_another_view_cancels_a_fine_job_and_starts_again(scene, stage):
    from addon.inspect.heat import REST, Heat

    heat = Heat()
    scene.whittle_overlay.samples = "16"
    heat.want(wanted(scene, stage, look(scene, (1600, 1000))))
    heat.step(stage.scene)
    coarse = heat._job
    heat.want(wanted(scene, stage, look(scene, (1600, 998))))
    assert heat._job is coarse  # a moving view still shows something
    while heat.picture is None:
        heat.step(stage.scene)
    assert heat.picture.want != heat.wanted
    heat.moved -= REST
    while heat._job is None or heat._first:
        heat.step(stage.scene)
    fine = heat._job
    heat.want(wanted(scene, stage, look(scene)))
    assert heat._job is None
    finish(heat, stage)
    assert heat.picture.values.shape == SIZE[::-1] and fine.poll()[1]


def test_an_error_of_the_core_is_kept_and_not_tried_again(scene, stage):
    from addon.inspect.heat import Heat

    heat = Heat()
    scene.whittle.max_depth = 1000
    heat.want(wanted(scene, stage, look(scene)))
    finish_error = time.monotonic() + 20
    while heat.busy:
        heat.step(stage.scene)
        assert time.monotonic() < finish_error
    assert "max_depth" in heat.error and heat.picture is None
    scene.whittle.max_depth = 2
    heat.want(wanted(scene, stage, look(scene)))
    finish(heat, stage)
    assert heat.finished and not heat.error


def test_the_automatic_range_and_the_histogram(stage, scene):
    from addon.inspect.heat import picture

    want = wanted(scene, stage, look(scene))
    counts = np.tile(np.arange(1000, dtype=np.float32), (4, 1))
    made = picture(want, 1, {"nodes": counts[..., np.newaxis], "stats": {"seconds": 0.5}})
    assert made.top == np.percentile(counts, 99.5) and made.highest == 999
    assert np.isclose(made.mean, 499.5) and np.isclose(made.p95, np.percentile(counts, 95))
    bars = made.histogram(0.0, 64.0)
    assert bars.sum() == 4000 and (bars[:-1] == 4).all() and bars[-1] == 4000 - 63 * 4
    flat = picture(want, 1, {"nodes": np.zeros((2, 2, 1), "f4"), "stats": {"seconds": 0.5}})
    assert flat.top == 1.0 and flat.histogram(0.0, flat.top)[0] == 4


# ---- The scene that is kept ----------------------------------------------------------------------


def test_what_changes_rays_makes_the_scene_stale(scene, stage):
    cube, light = bpy.data.objects["Cube"], bpy.data.objects["Point"]

    def stale_after(change):
        stage.source.stale = False
        change()
        bpy.context.view_layer.update()
        return stage.stale

    assert not stale_after(lambda: setattr(scene.camera, "location", (1, 2, 3)))
    assert not stale_after(lambda: cube.select_set(False))
    assert not stale_after(lambda: setattr(scene.whittle_overlay, "opacity", 0.5))
    assert stale_after(lambda: setattr(cube, "location", (0, 0, 1)))
    assert stale_after(lambda: setattr(light.data, "energy", 7.0))
    assert stale_after(lambda: cube.data.materials.append(bpy.data.materials.new("New")))
    assert stale_after(lambda: cube.data.transform(np.eye(4) * 0.5))
    assert stale_after(lambda: scene.frame_set(7))


def test_the_scene_is_read_again_when_it_rests(scene, stage, monkeypatch):
    from addon.inspect import source

    subject = stage.subject
    assert not stage.wants_reading(subject, automatic=True)
    stage.source.mark_stale()
    assert not stage.wants_reading(subject, automatic=True)
    stage.source.since -= source.SETTLE
    assert stage.wants_reading(subject, automatic=True)
    assert not stage.wants_reading(subject, automatic=False)
    stage.source.seconds_read = source.QUICK + 0.1
    assert not stage.wants_reading(subject, automatic=True)
    assert stage.wants_reading(("Scene", "Another Layer"), automatic=False)
    before = stage.generation
    bpy.ops.mesh.primitive_cube_add(location=(4, 0, 0))
    ready(stage)
    assert stage.generation == before + 1 and not stage.stale
    names = {index: place.object for index, place in stage.places.items()}
    assert names == {0: "Cube", 1: "Plane", 2: "Cube.001"}


def test_a_scene_that_cannot_be_built_says_why(scene, stage):
    scene.whittle.bins = 1
    stage.read(bpy.context.evaluated_depsgraph_get())
    while stage.building:
        stage.poll()
    assert "bins" in stage.error and stage.scene is None
