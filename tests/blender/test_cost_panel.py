# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The cost panels: their sums, orders, filter and selection; the baseline and its differences."""

from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from test_overlay_panels import Layout

KINDS = ("primary", "shadow", "reflection", "refraction")


@pytest.fixture
def session(scene, addon):
    """A floor, a ball and a twice placed cone, of two materials; what the panels are set to."""
    from addon.cost_ui import baseline, table

    bpy.ops.mesh.primitive_plane_add(size=12)
    bpy.context.object.name = "Floor"
    bpy.ops.mesh.primitive_uv_sphere_add(location=(-1.5, 0, 1))
    bpy.context.object.name = "Ball"
    bpy.context.object.data.materials.append(bpy.data.materials.new("Red"))
    collection = bpy.data.collections.new("Cones")
    cone = bpy.data.objects.new("Cone", bpy.data.objects["Ball"].data.copy())
    collection.objects.link(cone)
    for x in (1, 2.5):
        empty = bpy.data.objects.new("Place", None)
        empty.location, empty.instance_type = (x, 0, 1), "COLLECTION"
        empty.instance_collection = collection
        scene.collection.objects.link(empty)
    bpy.ops.object.light_add(location=(3, -3, 6))
    scene.whittle.use_counters = True
    session = bpy.context.window_manager.whittle_cost
    for name in ("kind", "search", "columns", "sort", "descending", "metric", "change_sort"):
        session.property_unset(name)
    yield session
    baseline.clear()
    addon.results.last.clear()
    table.refresh()


def render():
    """Renders and lists, as the window's timer would; gives the result."""
    from addon import results
    from addon.cost_ui import table

    bpy.ops.render.render()
    table.refresh()
    return results.last[0]


def listed(session):
    from addon.cost_ui import table

    return [table.shown.rows[item.place] for item in session.rows]


def names(session):
    return [row.title for row in listed(session)]


def text_of(draw):
    labels = []
    layout = PanelLayout(labels)
    draw(layout, bpy.context)
    return " | ".join(labels)


class PanelLayout(Layout):
    """Also sub-panels, open, and bars."""

    def panel(self, name, default_closed):
        assert default_closed and name.startswith("whittle_")
        return PanelLayout(self._labels), PanelLayout(self._labels)

    def progress(self, text, factor):
        assert 0 <= factor <= 1
        self._labels.append(text)

    def __getattr__(self, name):
        if name in ("row", "column", "box", "split", "grid_flow"):
            return lambda **_: PanelLayout(self._labels)
        raise AttributeError(name)


@pytest.mark.parametrize("kind", ["OBJECT", "MATERIAL"])
def test_the_rows_add_up_to_the_total_the_statistics_and_the_pixels(session, kind):
    from addon.cost_ui import numbers

    result = render()
    session.kind = kind
    rows = listed(session)
    assert len(rows) == (4 if kind == "OBJECT" else 3)
    for ray in KINDS:
        for ours, theirs in (("node_visits", "nodes"), ("triangle_tests", "triangles")):
            total = sum(getattr(row, ours)[ray] for row in rows)
            assert total == result.render[theirs][ray]
            assert total == result.counters[f"{theirs}_{ray}"].sum(dtype=np.float64)
    visits, tests = (sum(result.render[name].values()) for name in ("nodes", "triangles"))
    said = " ".join(numbers.totals(result))
    assert visits > tests > 1000 and f"{visits:,} node" in said and f"{tests:,} triangle" in said


def test_without_counts_the_panels_say_what_to_switch_on(session, scene):
    from addon.cost_ui import panels, table

    scene.whittle.use_counters = False
    render()
    assert not session.rows and table.shown.result is None
    assert "Rays' Work and render" in text_of(panels.draw_cost)
    assert not bpy.ops.whittle.keep_baseline.poll()
    assert bpy.ops.whittle.count() == {"FINISHED"} and scene.whittle.use_counters
    table.refresh()
    assert len(session.rows) == 4


@pytest.mark.parametrize(
    "column", ["WORK", "NODES", "TESTS", "TRIANGLES", "MEMORY", "BUILD", "FILL", "OVERLAP", "SAH"]
)
def test_a_click_on_a_column_sorts_by_it_and_a_second_turns_the_order(session, scene, column):
    from addon.cost_ui import columns

    scene.whittle.use_own_trees = True
    render()
    session.sort = "NAME"
    orders = []
    for _ in range(2):
        bpy.ops.whittle.sort_cost(column=column)
        values = [columns.COLUMNS[column].of(row) for row in listed(session)]
        known = [value for value in values if value is not None]
        assert len(values) == 4 and None not in values[: len(known)], "unknown ones come last"
        assert len(set(known)) > 1
        orders.append(known)
    assert orders[0] == sorted(orders[0], reverse=True) and orders[1] == sorted(orders[1])


def test_names_sort_and_filter_and_the_active_row_stays(session):
    render()
    bpy.ops.whittle.sort_cost(column="NAME")
    assert names(session) == ["Ball", "Cone", "Floor", "shared"]
    session.index = 2
    bpy.ops.whittle.sort_cost(column="NAME")
    assert names(session)[session.index] == "Floor" and session.index == 1
    session.search = "l*o"
    assert names(session) == ["Floor"]
    session.search = "BALL"
    assert names(session) == ["Ball"]
    session.search = "nothing of the sort"
    assert not session.rows


def test_a_click_selects_the_object_its_material_or_who_places_it(session, scene):
    from addon.cost_ui import operators

    layer = bpy.context.view_layer
    render()
    before = list(layer.objects.selected)
    assert before != [bpy.data.objects["Ball"]], "filling the table selects nothing"
    session.index = names(session).index("Ball")
    ball = bpy.data.objects["Ball"]
    assert list(layer.objects.selected) == [ball] and layer.objects.active == ball
    session.index = names(session).index("Cone")
    assert [ob.name.split(".")[0] for ob in layer.objects.selected] == ["Place", "Place"]
    session.kind = "MATERIAL"
    session.index = names(session).index("Red")
    assert list(layer.objects.selected) == [ball]
    select = bpy.ops.whittle.select_cost
    assert select(kind="object", name="Gone") == {"CANCELLED"}
    assert list(layer.objects.selected) == [ball]
    assert {"REGISTER", "UNDO"} <= operators.WHITTLE_OT_select_cost.bl_options


def test_a_line_has_a_cell_for_each_column(session):
    from addon.cost_ui import panels

    render()
    session.columns = {"WORK", "TRIANGLES"}
    for item, row in zip(session.rows, listed(session), strict=True):
        labels = []
        panels.WHITTLE_UL_cost.draw_item(
            SimpleNamespace(), bpy.context, PanelLayout(labels), session, item, 0, None, ""
        )
        assert labels[0] == (f"shared ({row.stretched_by})" if row.shared else row.name)
        assert labels[1:] == [f"{100 * row.share:.1f} %", f"{row.triangles:,}"], row


def test_the_hints_of_the_active_row_hold_their_number(session, scene):
    from addon.cost_ui import panels

    ball = bpy.data.objects["Ball"]
    ball.data.vertices[0].co = (0, 0, 400)
    scene.whittle.use_own_trees = True
    render()
    (row,) = (row for row in listed(session) if row.title == "Ball")
    assert "stretch" in {hint.kind for hint in row.hints}
    session.index = names(session).index("Ball")
    said = text_of(panels.draw_cost).replace(" | ", " ")
    for hint in row.hints:
        assert hint.text in said and hint.mend[1:] in said
    session.index = names(session).index("shared")
    assert "'Ball' stretches" in text_of(panels.draw_cost)


def test_overlap_is_measured_on_request(session, scene):
    from addon.cost_ui import panels, table

    render()
    assert "Overlap (EPO)" not in text_of(panels.draw_quality)
    assert bpy.ops.whittle.measure_overlap() == {"FINISHED"}
    table.refresh()
    assert "Overlap (EPO)" in text_of(panels.draw_quality)
    assert all(row.overlap is not None for row in listed(session) if not row.shared)


def test_quality_shows_the_tree_and_bars_that_add_up(session):
    from addon.cost_ui import numbers, panels

    result = render()
    quality = result.cost.quality
    rows = dict(numbers.tree(result))
    assert rows["Leaves"] == f"{quality['leaves']:,}" and rows["Nodes"] == f"{quality['nodes']:,}"
    tests = sum(result.render["triangles"].values())
    assert float(rows["Tests per Ray"]) == pytest.approx(tests / result.rays(), rel=0.01)
    for name in ("depth_histogram", "leaf_size_histogram"):
        bars = numbers.histogram(quality[name])
        assert sum(n for _, n, _ in bars) == quality["leaves"] and len(bars) <= 12
        assert max(length for *_, length in bars) == 1
    assert "Packets with Statistics" in text_of(panels.draw_quality).replace(" | ", " ")


def test_bars_bring_neighbours_together(addon):
    from addon.cost_ui.numbers import histogram

    counts = np.zeros(65, dtype=np.uint64)
    counts[3:28] = 2
    bars = histogram(counts)
    assert bars[0][:2] == ("3-5", 6) and bars[-1][:2] == ("27", 2) and len(bars) == 9
    assert histogram(np.zeros(5, dtype=np.uint64)) == []


def test_the_lectures_packets_are_told_of(session, scene):
    from addon.cost_ui import numbers

    scene.whittle.mode = "LECTURE"
    result = render()
    stats, rows = result.render, dict(numbers.packets(result))
    share = stats["active_rays"] / stats["visited_rays"]
    assert 0 < share < 1 and rows["Coherence"] == f"{100 * share:.1f} %"
    assert float(rows["Rays / Rays at a Node"]) == pytest.approx(1 / share, abs=1e-3)
    used = [rows[f"Use of {stats['lanes']} Lanes, {what}"] for what in ("Nodes", "Tests")]
    for what, text in zip(("node", "triangle"), used, strict=True):
        part = stats[f"{what}_lanes_used"] / stats[f"{what}_lanes"]
        assert 0 < part < 1 and text == f"{100 * part:.1f} %"
    decided = [rows[f"{who} Decided"] for who in ("First Ray", "Frustum", "Ray by Ray")]
    assert sum(float(text.strip("< %")) for text in decided) == pytest.approx(100, abs=0.2)


def test_a_layer_is_chosen(session, scene):
    from addon.cost_ui import table

    second = scene.view_layers.new("Second")
    bpy.data.objects["Ball"].hide_render = False
    second.layer_collection.exclude = False
    render()
    assert table.layers() == [scene.view_layers[0].name, "Second"]
    session.layer = "Second"
    assert table.shown.result.layer == "Second" and len(session.rows) == 4


# ---- Compare ----


def changed(session):
    from addon.cost_ui import table

    return [table.shown.changes[item.place] for item in session.changes]


def test_a_remeshed_object_is_the_row_that_changed_and_the_map_shows_where(session, addon):
    from addon.cost_ui import baseline, panels, table

    before = render()
    assert bpy.ops.whittle.keep_baseline(name="As it was") == {"FINISHED"}
    assert baseline.kept.name == "As it was" and not session.changes
    assert not bpy.ops.whittle.difference_map.poll()
    ball = bpy.data.objects["Ball"]
    ball.modifiers.new("Finer", "SUBSURF").render_levels = 2
    after = render()
    (change,) = (change for change in changed(session) if change.row.title == "Ball")
    assert change.difference("triangles") > 5000
    rows = {row.title: row for row in listed(session)}
    for name in ("work", "node_visits"):
        old, new = change.values(name)
        assert change.difference(name) == new - old
    assert change.after == rows["Ball"] and "Cone" not in {
        pair.row.title for pair in changed(session) if pair.difference("triangles")
    }
    said = text_of(panels.draw_compare)
    assert "Baseline: As it was" in said and "SAH Cost" in said
    work = [r.counters["nodes"] + r.counters["triangles"] for r in (before, after)]
    total = sum(
        pair.difference("work") for pair in table.shown.changes if pair.row.kind == "object"
    )
    assert total == (work[1] - work[0]).sum(dtype=np.float64) != 0
    assert bpy.ops.whittle.difference_map() == {"FINISHED"}
    image = bpy.data.images["Whittle Difference"]
    pixels = np.array(image.pixels[:]).reshape(image.size[1], image.size[0], 4)
    scale = image.size[0] // 64
    picture = pixels[-40 * scale :: scale, ::scale, :3]
    difference = work[1] - work[0]
    redder = picture[..., 0] > picture[..., 2] + 0.02
    bluer = picture[..., 2] > picture[..., 0] + 0.02
    strong = abs(difference) > 0.1 * abs(difference).max()
    assert redder[strong & (difference > 0)].all() and bluer[strong & (difference < 0)].all()
    assert not (redder | bluer)[difference == 0].any()
    bpy.ops.whittle.clear_baseline()
    assert baseline.kept is None and not session.changes


def test_another_builder_setting_changes_visits_but_no_triangles(session, scene):
    from addon.cost_ui import baseline, panels

    scene.whittle.bins = 32
    render()
    bpy.ops.whittle.keep_baseline()
    scene.whittle.bins = 2
    result = render()
    assert baseline.settings_changed(result) == [("Bins", 32, 2)]
    assert "Bins: 32, now 2" in text_of(panels.draw_compare)
    assert session.changes and all(pair.difference("triangles") == 0 for pair in changed(session))
    session.metric = "TRIANGLES"
    assert not session.changes
    session.metric = "NODES"
    for column in ("BEFORE", "AFTER", "DIFFERENCE", "NAME"):
        bpy.ops.whittle.sort_changes(column=column)
        values = {
            "BEFORE": [pair.values("node_visits")[0] for pair in changed(session)],
            "AFTER": [pair.values("node_visits")[1] for pair in changed(session)],
            "DIFFERENCE": [abs(pair.difference("node_visits")) for pair in changed(session)],
            "NAME": [pair.row.title.casefold() for pair in changed(session)],
        }[column]
        down = session.change_descending
        assert len(values) > 1 and values == sorted(values, reverse=down), column


def test_what_came_and_what_went_are_changes(session):
    render()
    bpy.ops.whittle.keep_baseline()
    bpy.data.objects.remove(bpy.data.objects["Ball"])
    bpy.ops.mesh.primitive_cube_add(location=(0, 2, 0))
    render()
    pairs = {pair.row.title: pair for pair in changed(session)}
    assert pairs["Ball"].after is None and pairs["Ball"].difference("work") < 0
    assert pairs["Cube"].before is None and pairs["Cube"].difference("triangles") == 12
    assert pairs["Cube"].difference("box_fill") is None


def test_the_same_render_again_changes_nothing(session):
    render()
    bpy.ops.whittle.keep_baseline()
    render()
    assert not session.changes


@pytest.mark.parametrize("change", ["size", "samples"])
def test_another_size_or_number_of_samples_is_refused_with_the_mend(session, scene, change):
    from addon.cost_ui import panels

    render()
    bpy.ops.whittle.keep_baseline()
    if change == "size":
        scene.render.resolution_x = 48
    else:
        scene.whittle.samples = 4
    render()
    assert not session.changes
    said = text_of(panels.draw_compare).replace(" | ", " ")
    assert "keep a new baseline" in said and ("48 x 40" in said or "render with as many" in said)
    with pytest.raises(RuntimeError, match="keep a new baseline"):
        bpy.ops.whittle.difference_map()


# ---- The interface ----


def test_everything_explains_itself(addon):
    from addon.cost_ui import operators, properties

    for group in (*properties.CLASSES, *operators.CLASSES):
        kind = group.bl_rna
        if issubclass(group, bpy.types.Operator):
            kind = getattr(bpy.ops.whittle, group.bl_idname.split(".")[1]).get_rna_type()
            assert len(kind.description) > 10, group
        for row in kind.properties:
            if row.identifier in ("rna_type",) or (row.identifier, kind.base) == ("name", None):
                continue
            if row.identifier == "name" and not row.description:
                continue
            assert len(row.description) > 3, (group, row.identifier)
            for item in getattr(row, "enum_items", ()):
                assert item.description, item.identifier


def test_presets_set_what_they_name(session):
    from addon.cost_ui import preset_menu

    files = sorted((Path(preset_menu.__file__).parent / "presets" / preset_menu.FOLDER).glob("*"))
    assert len([file for file in files if file.suffix == ".py"]) == 4
    for file in files:
        if file.suffix == ".py":
            exec(compile(file.read_text(), file, "exec"), {})
    assert session.sort == "WORK" and session.columns == {"WORK", "NODES", "TESTS"}


def test_both_places_draw_the_same(session):
    from addon.cost_ui import panels

    render()
    for part in ("cost", "quality", "compare"):
        texts = []
        for place in ("RENDER", "VIEW"):
            labels = []
            cls = getattr(panels, f"WHITTLE_{place}_PT_{part}")
            cls.draw(SimpleNamespace(layout=PanelLayout(labels)), bpy.context)
            texts.append(labels)
        assert texts[0] == texts[1] and texts[0]


def test_a_render_lists_itself_by_a_timer_and_only_while_registered(session, addon):
    from addon import results
    from addon.cost_ui import table

    assert results.listeners == [table._rendered]
    addon.unregister()
    try:
        assert not results.listeners and not bpy.app.timers.is_registered(table.refresh)
    finally:
        addon.register()
