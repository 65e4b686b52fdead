# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The heatmap over a real viewport: its colours are those of the core's counts, pixel by pixel."""

import importlib
import time
from collections.abc import Iterator
from contextlib import contextmanager

import bpy
import numpy as np
from mathutils import Quaternion
from numpy.typing import NDArray
from window import PACKAGE, Gui, Steps

PATIENCE = 200.0  #: seconds; the first Material Preview compiles its shaders meanwhile


def part(name: str):
    """A module of the extension."""
    return importlib.import_module(f"{PACKAGE}.{name}")


def stage(gui: Gui) -> Steps:
    """Suzanne above a mirror, in glass, with one light; overlays show their colours exactly."""
    yield from gui.fresh()
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    bpy.ops.object.light_add(location=(3, -3, 6))
    bpy.ops.mesh.primitive_plane_add(size=12, location=(0, 0, -1))
    bpy.context.object.data.materials.append(material("Mirror", Metallic=1.0, Roughness=0.0))
    bpy.ops.mesh.primitive_monkey_add(size=3)
    glass = material("Glass", Roughness=0.0)
    glass.node_tree.nodes["Principled BSDF"].inputs["Transmission Weight"].default_value = 1.0
    bpy.context.object.data.materials.append(glass)
    settings = gui.scene.whittle_overlay
    settings.opacity, settings.show_legend = 1.0, False
    # What Blender draws over the colours.
    gui.space().overlay.show_cursor = gui.space().overlay.show_text = False
    gui.space().show_gizmo = False
    yield from gui.redrawn()


def material(name: str, **inputs: float) -> bpy.types.Material:
    made = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0):
        made.use_nodes = True
    for key, value in inputs.items():
        made.node_tree.nodes["Principled BSDF"].inputs[key].default_value = value
    return made


def switch(gui: Gui, on: bool) -> None:
    bpy.context.window_manager.whittle.show_heat = on


def heat_of(gui: Gui):
    """The heatmap of the main viewport, or None."""
    entry = part("inspect.overlay").viewports.get(gui.region("VIEW_3D").as_pointer())
    return None if entry is None else entry.heat


def shown(gui: Gui) -> Steps:
    """Waits until the heatmap is whole, and was drawn; gives its picture."""

    def whole() -> bool:
        heat = heat_of(gui)
        assert heat is None or not heat.error, heat.error
        source = part("inspect.source").shared
        if heat is None or source.stale or source.building:
            return False
        return heat.finished and heat.picture.want.generation == source.generation

    gui.area("VIEW_3D").tag_redraw()
    yield 0.2
    yield from gui.until(whole, "the heatmap is whole", timeout=PATIENCE)
    yield from gui.redrawn()
    return heat_of(gui).picture


def counted(gui: Gui, passes: list[str], samples: int = 1) -> NDArray[np.float32]:
    """Counts of the view as a render of the core gives them, the sum of the passes (h, w)."""
    data, space, region = gui.space().region_3d, gui.space(), gui.region("VIEW_3D")
    camera = {
        "to_world": np.linalg.inv(np.array(data.view_matrix, dtype=np.float64)),
        "projection": np.array(data.window_matrix, dtype=np.float64),
        "width": region.width,
        "height": region.height,
        "clip_start": space.clip_start,
        "clip_end": space.clip_end,
    }
    if not data.is_perspective:
        half = -1.0 / data.window_matrix[2][2]
        camera["to_world"][:3, 3] += half * camera["to_world"][:3, 2]
        camera |= {"clip_start": 0.0, "clip_end": 2.0 * half}
    settings = {"passes": passes, "samples": samples}
    image = part("inspect.source").shared.scene.render(camera, settings)
    return sum(image[name][..., 0].astype(np.float64) for name in passes)


def check(gui: Gui, counts: NDArray, span: tuple[float, float], colormap: str) -> Steps:
    """Compares the frame buffer with the colour map of the counts."""
    low, high = span
    wanted = part("heat.colormaps").apply(colormap, (counts - low) / (high - low))
    found = yield from gui.pixels()
    error = abs(found[..., :3] - wanted).max(axis=-1)
    wrong = np.argwhere(error > 1.01 / 255)
    gui.report(f"{colormap} {low:g} to {high:g}: largest error {255 * error.max():.2f} / 255")
    assert counts.max() > low
    assert not len(wrong), f"{len(wrong)} pixels, from {wrong.min(axis=0)} to {wrong.max(axis=0)}"


def test_colours_are_those_of_the_core_s_counts(gui: Gui):
    yield from stage(gui)
    switch(gui, True)
    picture = yield from shown(gui)
    counts = counted(gui, ["nodes"])
    assert np.array_equal(picture.values, counts)
    yield from check(gui, counts, (0.0, picture.top), "VIRIDIS")
    gui.screenshot("heat")
    settings = gui.scene.whittle_overlay
    settings.range, settings.low, settings.high = "FIXED", 5.0, 150.0
    for colormap in ("TURBO", "GREY"):
        settings.colormap = colormap
        yield from gui.redrawn()
        yield from check(gui, counts, (5.0, 150.0), colormap)


def test_any_engine_any_shading_any_view(gui: Gui):
    yield from stage(gui)
    switch(gui, True)
    data = gui.space().region_3d
    eevee = "BLENDER_EEVEE" if bpy.app.version >= (5, 0) else "BLENDER_EEVEE_NEXT"
    for engine, shading, view in (
        (eevee, "MATERIAL", "ORTHO"),
        ("BLENDER_WORKBENCH", "RENDERED", "PERSP"),
        ("WHITTLE", "WIREFRAME", "PERSP"),
    ):
        gui.scene.render.engine = engine
        gui.space().shading.type = shading
        data.view_perspective = view
        data.view_rotation = Quaternion((0.8, 0.5, 0.2, 0.1)).normalized()
        data.view_distance = 9.0
        yield from gui.redrawn()
        picture = yield from shown(gui)
        counts = counted(gui, ["nodes"])
        gui.report(engine, shading, view)
        assert np.array_equal(picture.values, counts)
        yield from check(gui, counts, (0.0, picture.top), "VIRIDIS")


test_any_engine_any_shading_any_view.seconds = 3 * PATIENCE


def test_metrics_kinds_and_samples(gui: Gui):
    yield from stage(gui)
    settings = gui.scene.whittle_overlay
    switch(gui, True)
    settings.metric, settings.samples = "TRIANGLES", "4"
    settings.kinds = {"reflection", "refraction"}
    picture = yield from shown(gui)
    counts = counted(gui, ["triangles_reflection", "triangles_refraction"], samples=4)
    assert np.array_equal(picture.values, counts)
    yield from check(gui, counts, (0.0, picture.top), "VIRIDIS")


def test_a_moved_object_is_read_again(gui: Gui):
    yield from stage(gui)
    switch(gui, True)
    before = yield from shown(gui)
    bpy.data.objects["Suzanne"].location.x = 2.0
    yield from gui.until(lambda: part("inspect.source").shared.stale, "the change is seen")
    after = yield from shown(gui)
    assert after.want.generation > before.want.generation
    assert np.array_equal(after.values, counted(gui, ["nodes"]))
    assert not np.array_equal(after.values, before.values)


def test_orbiting_shows_coarse_pictures_at_once_and_then_sharpens(gui: Gui):
    """Turns the view with the real mouse; the window must never wait for the rays."""
    yield from gui.fresh()
    demo = part("demo")
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    demo.build(gui.scene)
    gui.space().region_3d.view_distance = 16.0
    switch(gui, True)
    yield from shown(gui)
    gui.screenshot("demo")
    heat = heat_of(gui)
    still = heat.picture
    seen, spent = [], []
    with timed(spent):
        x, y = gui.center()
        for step in gui.drag((x, y), (x + 160, y + 40), button=2, moves=16, wait=0.4):
            end = time.monotonic() + step
            while time.monotonic() < end:
                yield 0.005
                if heat.picture is not still and (not seen or heat.picture is not seen[-1]):
                    seen.append(heat.picture)
        picture = yield from shown(gui)
    views = {picture.want.view for picture in seen}
    gui.report(f"{len(views)} views drawn while orbiting, at 1/{[p.divisor for p in seen]}")
    gui.report(f"the window waited for us at most {1000 * max(spent):.0f} ms at a time")
    firsts = [
        one.divisor
        for one, before in zip(seen[1:], seen, strict=False)
        if one.want.view != before.want.view
    ]
    assert len(views) >= 4 and min(firsts) > 1 and sorted(spent)[-2] < 0.2
    assert np.array_equal(picture.values, counted(gui, ["nodes"]))
    assert picture.want.view != still.want.view


test_orbiting_shows_coarse_pictures_at_once_and_then_sharpens.seconds = 2 * PATIENCE


@contextmanager
def timed(spent: list[float]) -> Iterator[None]:
    """Notes the seconds of each piece of work that the heatmap does on the window's thread."""
    places = [
        (part("inspect.heat").Heat, "step"),
        (part("inspect.heat_overlay").HeatOverlay, "paint"),
        (part("inspect.legend"), "paint"),
    ]
    kept = [getattr(*place) for place in places]

    def noting(work):
        def run(*arguments):
            began = time.perf_counter()
            try:
                return work(*arguments)
            finally:
                spent.append(time.perf_counter() - began)

        return run

    for (owner, name), work in zip(places, kept, strict=True):
        setattr(owner, name, noting(work))
    try:
        yield
    finally:
        for (owner, name), work in zip(places, kept, strict=True):
            setattr(owner, name, work)


def test_switched_off_nothing_is_left(gui: Gui):
    yield from stage(gui)
    yield 1.0
    yield 1.0
    bare = yield from gui.pixels()
    switch(gui, True)
    yield from shown(gui)
    over = yield from gui.pixels()
    gui.space().overlay.show_overlays = False
    hidden = yield from gui.pixels()
    switch(gui, False)
    bare_hidden = yield from gui.pixels()
    assert abs(hidden - bare_hidden).mean() < 1e-3
    gui.space().overlay.show_overlays = True
    yield 1.0
    after = yield from gui.pixels()
    assert abs(after - bare).mean() < 1e-3 < abs(over - bare).mean()
    yield from gui.until(lambda: not part("inspect.overlay").viewports, "nothing is kept")


def test_disabled_while_it_traces(gui: Gui):
    yield from stage(gui)
    gui.scene.whittle_overlay.samples = "16"
    switch(gui, True)
    yield from gui.until(lambda: heat_of(gui) and heat_of(gui).busy, "something is traced")
    bpy.ops.preferences.addon_disable(module=PACKAGE)
    yield from gui.redrawn()
    assert not hasattr(bpy.types.Scene, "whittle_overlay")
    bpy.ops.preferences.addon_enable(module=PACKAGE)
    yield from gui.redrawn()
    settings = gui.scene.whittle_overlay
    assert settings.samples == "16"
    settings.samples = "1"
    switch(gui, True)
    picture = yield from shown(gui)
    assert np.array_equal(picture.values, counted(gui, ["nodes"]))
    switch(gui, False)
