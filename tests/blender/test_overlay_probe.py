# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The pixel probe: its counts, its tree of rays, and whom their work is charged to."""

import bpy
import numpy as np
from viewing import KINDS, SIZE, look, probed, ready


def test_a_probe_counts_what_the_heatmap_counts(scene, glass):
    from addon.inspect import properties

    scene.whittle_overlay.samples = "4"
    names = [f"{what}_{kind}" for what in ("nodes", "triangles") for kind in KINDS]
    settings = properties.core_settings(scene) | {"passes": names}
    image = glass.scene.render(look(scene).camera(), settings)
    random = np.random.default_rng(5)
    seen = set()
    for x, y in random.integers(0, SIZE, (20, 2)):
        counts = probed(scene, glass, (int(x), int(y))).counts()
        for kind in KINDS:
            _, nodes, triangles = counts.get(kind, (0, 0, 0))
            assert nodes == image[f"nodes_{kind}"][y, x, 0]
            assert triangles == image[f"triangles_{kind}"][y, x, 0]
        seen |= counts.keys()
    assert seen == set(KINDS)


def test_rays_follow_the_one_they_descend_from(scene, glass):
    made = probed(scene, glass)
    assert made.pixel == (48, 32) and made.size == SIZE
    stack = []
    for index, ray in enumerate(made.rays):
        del stack[ray.level :]
        assert ray.parent == (stack[-1] if stack else -1) and len(stack) == ray.level
        stack.append(index)
        if ray.parent >= 0:
            above = made.rays[ray.parent]
            assert above.hit and np.linalg.norm(above.end - ray.start) < 1e-3
    first = made.rays[0]
    assert (first.kind, first.target, first.material) == ("primary", "Cube", "Of Cube")
    assert np.allclose(first.end[2], 1.0, atol=1e-5) and np.isclose(first.distance, 9.0, atol=0.1)
    assert {ray.target for ray in made.rays} >= {"Cube", "Plane"}


def test_work_is_charged_to_the_objects_that_it_was_done_for(scene, glass):
    owners = glass.scene.owners()["instance"]
    names = [glass.places[index].object for index in range(len(glass.places))]
    for ray in probed(scene, glass).rays:
        assert sum(work.nodes for work in ray.work) == len(ray.nodes)
        assert sum(work.triangles for work in ray.work) == len(ray.triangles)
        for work in ray.work:
            index = names.index(work.name) if work.selects else -1
            assert work.nodes == sum(owners[node] == index for node in ray.nodes)
    assert any(work.name == "shared" for work in probed(scene, glass).rays[0].work)


def test_a_ray_that_misses_is_drawn_far_and_a_shadow_ray_to_its_light(scene, glass):
    scene.camera.data.lens = 12.0
    rays = probed(scene, glass, (0, 0)).rays
    assert [ray.kind for ray in rays] == ["primary"] and not rays[0].hit and not rays[0].target
    assert 5 < np.linalg.norm(rays[0].end - rays[0].start) < 100
    bpy.data.objects["Plane"].data.materials.clear()
    bpy.data.objects["Cube"].location.x = -2.5
    ready(glass)
    rays = probed(scene, glass, (54, 28)).rays
    shadow = next(ray for ray in rays if ray.kind == "shadow" and not ray.hit)
    assert np.allclose(shadow.end, (3, -3, 6), atol=1e-3) and shadow.light == 0
    assert np.isfinite([ray.end for ray in rays]).all()


def test_triangles_of_a_ray_lie_in_the_world(scene, glass):
    ray = probed(scene, glass).rays[0]
    assert ray.triangles.shape == (len(ray.triangles), 3, 3)
    inside = (ray.triangles >= (-4.01, -4.01, -2.01)) & (ray.triangles <= (4.01, 4.01, 1.01))
    assert inside.all() and len(ray.triangles)
    assert any((abs(t[:, 2] - 1.0) < 1e-5).all() for t in ray.triangles)


def test_the_list_shows_the_probe_and_steps_through_it(scene, glass):
    from addon.inspect import probe_overlay

    session = bpy.context.window_manager.whittle
    made = probed(scene, glass)
    assert not bpy.ops.whittle.step_ray.poll()
    probe_overlay.show(made)
    try:
        assert [row.name for row in session.rays] == [probe_overlay.summary(r) for r in made.rays]
        assert session.show_probe and probe_overlay.chosen(bpy.context) is made.rays[0]
        bpy.ops.whittle.step_ray(step=1)
        assert probe_overlay.chosen(bpy.context) is made.rays[1]
        bpy.ops.whittle.step_ray(step=-2)
        assert probe_overlay.chosen(bpy.context) is made.rays[-1]
        assert probe_overlay.visited(bpy.context) == tuple(sorted(set(made.rays[-1].nodes)))
        text = probe_overlay.explain(bpy.context)
        assert f"{len(made.rays)} rays" in text.title and not text.warning
        bpy.data.objects["Cube"].location.z = 0.5
        ready(glass)
        assert probe_overlay.visited(bpy.context) == ()
        assert "probe again" in probe_overlay.explain(bpy.context).warning
    finally:
        probe_overlay.show(None)
    assert not session.rays and not session.show_probe


def test_an_object_of_the_table_can_be_selected(scene, stage):
    assert bpy.ops.whittle.select_object(name="Plane") == {"FINISHED"}
    assert [ob.name for ob in bpy.context.selected_objects] == ["Plane"]
    assert bpy.context.view_layer.objects.active.name == "Plane"
    assert bpy.ops.whittle.select_object(name="Nothing") == {"CANCELLED"}
