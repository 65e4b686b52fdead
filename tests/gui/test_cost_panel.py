# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The cost table in Blender's real window: rendered, sorted and clicked with a real pointer."""

import sys
from pathlib import Path

import bpy
from test_overlay import PATIENCE, part
from window import Gui, Steps, x_tool

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs" / "make"))
import bad_scene  # noqa: E402

PARASOL, ROCK = bad_scene.PARASOL, bad_scene.ROCK
WIDE = 470  # pixels of the sidebar
EDGES = (0, -2, 2, 6, 9)  # where its edge may be caught, from where it begins
HEADER = 458  # pixels from the top of the sidebar to the table's, while the others are as at first
TITLES, FIRST_ROW, ROW = 211, 237, 21  # of the table, so far below that top
LAST_HEADER, KEEP, MAP = 625, 593, 619  # when scrolled to the end: of Compare and its buttons


def session() -> bpy.types.PropertyGroup:
    return bpy.context.window_manager.whittle_cost


def stage(gui: Gui, mended: bool = False) -> Steps:
    """The scene made to be bad, small; the Properties editor as high as the window."""
    yield from gui.fresh()
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    bad_scene.build(gui.scene, bad_scene.Size(slivers=3_000, trees=25, layers=6), mended)
    render = gui.scene.render
    render.engine, render.resolution_x, render.resolution_y = "WHITTLE", 480, 270
    render.resolution_percentage = 100
    gui.scene.whittle.samples = 1
    gui.scene.whittle.use_counters = gui.scene.whittle.use_own_trees = True
    bpy.ops.object.select_all(action="DESELECT")
    yield from gui.redrawn()


def rendered(gui: Gui) -> Steps:
    """Presses F12 and waits until the table lists the new render; the 3D viewport comes back."""
    table = part("cost_ui.table")
    before = table.shown.result
    yield from gui.key("F12")

    def done() -> bool:
        return table.shown.result is not before and not bpy.app.is_job_running("RENDER")

    yield from gui.until(done, "the table lists the render", timeout=PATIENCE)
    with gui.override("IMAGE_EDITOR"):
        bpy.ops.render.view_cancel()
    yield 0.5


def titles() -> list[str]:
    table = part("cost_ui.table")
    return [table.shown.rows[item.place].title for item in session().rows]


def opened(gui: Gui) -> Steps:
    """The sidebar's tab, wide, with nothing open but the table of cost."""
    yield from gui.show_tab("Whittle")
    tab = gui.region("VIEW_3D", "UI")
    if tab.width >= WIDE:
        return
    for edge in EDGES:
        start, end = tab.x + edge, tab.x + tab.width - WIDE + edge
        yield from gui.drag((start, tab.y + 300), (end, tab.y + 300))
        yield 0.3
        if tab.width > 0.9 * WIDE:
            break
    assert tab.width > 0.9 * WIDE, f"the sidebar's edge is at {tab.x}, its width {tab.width}"
    yield from below(gui, HEADER, modifier="ctrl")


def below(gui: Gui, height: float, along: float = 0.2, modifier: str = "") -> Steps:
    """Clicks so many pixels below the top of the sidebar, at a share of its width."""
    tab = gui.region("VIEW_3D", "UI")
    if modifier:
        x_tool("keydown", modifier)
    try:
        yield from gui.click(tab.x + along * tab.width, tab.y + tab.height - height)
    finally:
        if modifier:
            x_tool("keyup", modifier)
    yield 0.3


def line(name: str) -> float:
    """How far below the sidebar's top a row of the table lies."""
    return FIRST_ROW + ROW * titles().index(name)


def test_clicks_sort_and_select(gui: Gui):
    yield from stage(gui)
    yield from rendered(gui)
    yield from opened(gui)
    assert titles()[0] == PARASOL and session().sort == "WORK"
    yield from below(gui, TITLES, along=0.2)
    assert session().sort == "NAME" and titles() == sorted(titles(), key=str.casefold)
    yield from below(gui, TITLES, along=0.6)
    assert session().sort == "TRIANGLES" and titles()[0] == PARASOL and titles()[-1] == "shared"
    yield from below(gui, TITLES, along=0.6)
    assert not session().descending and titles()[0] == "shared"
    yield from below(gui, TITLES, along=0.45)
    assert session().sort == "WORK" and titles()[0] == PARASOL

    def selected() -> list[str]:
        return [ob.name for ob in gui.window.view_layer.objects.selected]

    yield from below(gui, line("Ball"))
    assert selected() == ["Ball"]
    yield from below(gui, line(PARASOL))
    assert selected() == [PARASOL] == [gui.window.view_layer.objects.active.name]
    assert titles()[session().index] == PARASOL
    gui.screenshot("cost")
    yield from undo(gui)
    assert selected() == ["Ball"], "the click can be undone"
    yield from below(gui, line("shared"))
    assert selected() == [ROCK], "it stretches the shared boxes"


def undo(gui: Gui) -> Steps:
    yield from gui.move(*gui.center())
    x_tool("key", "ctrl+z")
    yield 0.6


def scrolled(gui: Gui) -> Steps:
    """The sidebar at its end."""
    tab = gui.region("VIEW_3D", "UI")
    yield from gui.move(tab.x + 100, tab.y + 100)
    for _ in range(60):
        x_tool("click", 5)
        yield 0.02
    yield 0.4


def test_compare(gui: Gui):
    yield from stage(gui)
    yield from rendered(gui)
    yield from opened(gui)
    yield from scrolled(gui)
    yield from below(gui, LAST_HEADER)
    yield from scrolled(gui)
    baseline = part("cost_ui.baseline")
    assert baseline.kept is None
    yield from below(gui, KEEP, along=0.5)
    assert baseline.kept is not None and baseline.kept.name == "Scene, frame 1"
    smooth = bpy.data.objects["Ball"].data.copy()
    bpy.data.objects[PARASOL].data = smooth
    bpy.data.objects[PARASOL].scale = (1.6, 1.6, 0.4)
    yield from rendered(gui)
    table = part("cost_ui.table")
    first = table.shown.changes[session().changes[0].place]
    assert first.row.title == PARASOL and first.difference("work") < -1_000_000
    yield from beside(gui)
    yield from scrolled(gui)
    yield from below(gui, MAP, along=0.5)
    image = gui.space("IMAGE_EDITOR").image
    assert image.name == "Whittle Difference", "the editor that is open shows it"
    yield from gui.move(gui.window.width - 2, 2)
    yield 0.5
    gui.screenshot("compare")
    shown = yield from gui.screen_pixels("IMAGE_EDITOR")
    blue = shown[..., 2] - shown[..., 0] > 40
    assert blue.mean() > 0.005, "where the parasol was, work was saved"


def beside(gui: Gui) -> Steps:
    """An Image Editor to the left of the 3D viewport, which keeps its sidebar."""
    # Blender 4 hides a sidebar that does not fit beside the toolbar.
    gui.space().show_region_toolbar = bpy.app.version >= (5, 0)
    with gui.override("VIEW_3D"):
        bpy.ops.screen.area_split(
            direction="VERTICAL", factor=0.53 if bpy.app.version >= (5, 0) else 0.45
        )
    yield 0.5
    views = [area for area in gui.window.screen.areas if area.type == "VIEW_3D"]
    left = min(views, key=lambda area: area.x)
    left.type = "IMAGE_EDITOR"
    yield 0.5
    with gui.override("IMAGE_EDITOR"):
        bpy.ops.image.view_all()
    yield from gui.show_tab("Whittle")
    yield 0.5
