# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene that overlays and rendered viewports share: who reads, builds, waits and closes."""

import time

import bpy
import numpy as np
import pytest
from viewing import look, ready


class Viewport:
    """Stands for a rendered viewport: it traces until it is told to stop."""

    edits, counts = True, False

    def __init__(self, name="viewport", log=None):
        self.name, self.log, self.job, self.source = name, [] if log is None else log, None, None

    def join(self, local=0):
        from addon.viewport import source

        graph = bpy.context.evaluated_depsgraph_get()
        self.source = source.of(graph, self, local, self.source)
        return self.source

    def trace(self, scene):
        camera = look(scene, (1600, 1000)).camera()
        self.job = self.source.scene.start(camera, {"samples": 64, "threads": 1})

    def release(self):
        self.log.append(self.name)
        if self.job is not None:
            self.job.cancel()
            while not self.job.poll()[1]:
                time.sleep(0.001)
            self.job = None


@pytest.fixture
def viewport(stage):
    """A second user of the source that the overlays look into."""
    made = Viewport()
    made.join()
    yield made
    made.source.leave(made)


def graph():
    return bpy.context.evaluated_depsgraph_get()


def finish(source):
    while source.building:
        source.poll(wait=0.01)
    assert not source.error


def test_both_use_one_scene(stage, viewport):
    assert viewport.source is stage.source and viewport.source.builds == 1
    assert viewport.source.scene is stage.scene
    viewport.source.read(graph())
    assert not stage.building and viewport.source.builds == 1, "nothing has changed"


def test_an_edit_ends_all_tracing_and_builds_what_changed(scene, stage, viewport):
    source, before = viewport.source, stage.generation
    assert not source.by_instance
    for count, x in enumerate((1.0, 2.0), start=2):
        viewport.trace(scene)
        bpy.data.objects["Cube"].location.x = x
        bpy.context.view_layer.update()
        assert source.changed and stage.stale
        source.read(graph())
        assert viewport.job is None and stage.scene is None and stage.building
        finish(source)
        assert source.builds == count and source.by_instance and stage.generation > before
    assert source.build["subtrees"] == 2 and source.build["subtrees_built"] == 1


def test_a_change_of_look_builds_nothing(scene, stage, viewport):
    source, before = viewport.source, stage.generation
    viewport.trace(scene)
    bpy.data.objects["Point"].data.energy = 7.0
    bpy.context.view_layer.update()
    source.read(graph())
    assert viewport.job is None and not source.building and source.builds == 1
    assert stage.generation > before and stage.scene is source.scene is not None


def test_a_render_s_tree_is_built_when_asked_for(scene, stage, viewport):
    source = viewport.source
    bpy.data.objects["Cube"].location.x = 1.0
    bpy.context.view_layer.update()
    source.read(graph())
    finish(source)
    assert source.by_instance
    picture = source.scene.render(look(scene).camera())["combined"]
    stage.read(graph(), whole=True)
    finish(source)
    assert not source.by_instance and source.builds == 3
    assert np.array_equal(source.scene.render(look(scene).camera())["combined"], picture)
    stage.read(graph(), whole=True)
    assert not source.building, "it is there"


def test_without_a_rendered_viewport_there_is_one_tree(scene, stage):
    bpy.data.objects["Cube"].location.x = 1.0
    ready(stage)
    assert not stage.by_instance and stage.source.builds == 2


def test_the_binary_tree_is_there_for_who_looks_at_it(scene, stage):
    stage.close()
    alone = Viewport()
    source = alone.join()
    source.read(graph())
    finish(source)
    assert source.lean and source.builds == 1
    with pytest.raises(RuntimeError):
        source.scene.nodes()
    ready(stage)
    assert stage.source is source and not source.lean and source.builds == 2
    assert len(stage.scene.nodes()) == source.build["nodes"]
    source.leave(alone)


def test_other_bins_make_another_tree(scene, stage):
    scene.whittle.bins = 2
    ready(stage)
    assert stage.build["bins"] == 2 and stage.source.builds == 2


def test_an_error_is_told_to_all_and_mended_by_the_next_reading(scene, stage, viewport):
    light = bpy.data.objects["Point"].data
    light.energy = float("inf")
    bpy.context.view_layer.update()
    viewport.source.read(graph())
    assert "Light 'Point'" in stage.error and stage.scene is None
    light.energy = 5.0
    bpy.context.view_layer.update()
    ready(stage)
    assert stage.scene is viewport.source.scene is not None


def test_the_last_one_to_leave_closes_it(stage):
    from addon.viewport import source

    first, second = Viewport("first"), Viewport("second")
    shared = first.join()
    assert second.join() is shared is stage.source
    stage.close()
    shared.leave(first)
    assert shared.scene is not None and list(source._all.values()) == [shared]
    shared.leave(second)
    assert shared.scene is None and not source._all
    second.source = None
    assert second.join() is not shared
    second.source.leave(second)


def test_a_local_view_is_a_scene_of_its_own(stage, viewport):
    """That of others stays whole; where there are no others, what was read is kept."""
    shared, local = viewport.source, viewport.join(local=1)
    assert local is not shared is stage.source
    local.read(graph(), lambda instance: instance.object.name == "Cube")
    finish(local)
    assert local.build["triangles"] == 12 < stage.build["triangles"]
    stage.close()
    back = viewport.join(local=0)
    assert back is local and back.changed
    back.read(graph())
    finish(back)
    assert back.build["triangles"] == 14


def test_another_view_layer_has_another_scene(scene, stage, viewport):
    second = scene.view_layers.new("Second")
    bpy.context.window.view_layer = second
    assert viewport.join() is not stage.source
    bpy.context.window.view_layer = scene.view_layers[0]


def test_another_file_closes_everything(stage, viewport):
    from addon.viewport import source

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert not source._all and stage.source is None and viewport.source.scene is None
