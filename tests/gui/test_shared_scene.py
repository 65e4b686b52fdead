# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The heatmap and Rendered shading at once: the scene is read and built once for both."""

import bpy
import numpy as np
from probing import add_camera, click_render, hide_render, show_render
from test_overlay import PATIENCE, counted, part, shown, stage, switch
from test_viewport import at_rest, sessions
from window import Gui, Steps


def moved(gui: Gui, x: float) -> Steps:
    """Moves Suzanne; gives the heatmap when it has followed."""
    shared = part("inspect.source").shared
    before = shared.generation
    bpy.data.objects["Suzanne"].location.x = x
    yield from gui.until(lambda: shared.generation != before, "the move is built", PATIENCE)
    return (yield from shown(gui))


def test_the_heatmap_looks_into_the_rendered_viewport_s_scene(gui: Gui):
    yield from stage(gui)
    yield from gui.shade("RENDERED")
    session = yield from at_rest(gui)
    source = session.source
    assert source.builds == 1 and source.by_instance and source.lean
    switch(gui, True)
    picture = yield from shown(gui)
    session = yield from at_rest(gui)
    assert part("inspect.source").shared.source is source is session.source
    assert source.builds == 2 and not source.lean, "once for both, with a tree to count on"
    assert np.array_equal(picture.values, counted(gui, ["nodes"]))
    gui.scene.whittle_overlay.show_legend = True
    yield from gui.redrawn()
    gui.screenshot("both")
    seen = yield from moved(gui, 2.0)
    session = yield from at_rest(gui)
    assert source.builds == 3 and source.build["subtrees_built"] == 1 < source.build["subtrees"]
    assert np.array_equal(seen.values, counted(gui, ["nodes"]))
    assert not np.array_equal(seen.values, picture.values)
    image = session._tracer.image
    assert image.view.scene == seen.want.generation == source.generation
    gui.report(
        source.builds, "builds for both,", source.build["subtrees_built"], "tree in the last"
    )
    switch(gui, False)


def test_rendered_shading_takes_what_the_heatmap_has_built(gui: Gui):
    yield from stage(gui)
    switch(gui, True)
    yield from shown(gui)
    source = part("inspect.source").shared.source
    assert source.builds == 1 and not source.by_instance
    yield from gui.shade("RENDERED")
    session = yield from at_rest(gui)
    assert session.source is source and source.builds == 1 and session._tracer.image is not None
    yield from gui.shade("SOLID")
    yield from gui.until(lambda: not sessions(gui), "the engine is freed with the shading")
    picture = yield from moved(gui, 1.0)
    assert source.builds == 2 and not source.by_instance
    assert np.array_equal(picture.values, counted(gui, ["nodes"]))
    switch(gui, False)


def test_a_probed_render_has_its_own_tree_while_the_viewport_is_rendered(gui: Gui):
    yield from stage(gui)
    add_camera(gui)
    yield from gui.shade("RENDERED")
    session = yield from at_rest(gui)
    before = session._tracer.image.pixels
    result = yield from show_render(gui)
    found = yield from click_render(gui, 0.5, 0.6)
    x, y = found.pixel
    visits = sum(row[1] for row in found.counts().values())
    assert visits == result.counters["nodes"][y, x]
    assert not session.source.by_instance
    session = yield from at_rest(gui)
    assert np.array_equal(session._tracer.image.pixels, before), "the same picture by either tree"
    yield from hide_render(gui)
