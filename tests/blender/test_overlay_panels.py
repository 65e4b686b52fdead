# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Whittle tab of the 3D viewport: tooltips, panels, presets, the legend's numbers."""

from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from viewing import probed


def test_every_property_operator_and_panel_explains_itself(addon):
    from addon.inspect import operators, panels, probe_operator, properties

    for group in properties.CLASSES:
        for row in group.bl_rna.properties:
            if row.identifier not in ("rna_type", "name"):
                assert len(row.description) > 10, row.identifier
                for item in getattr(row, "enum_items", ()):
                    assert item.description, item.identifier
    for operator in (*operators.CLASSES, probe_operator.WHITTLE_OT_probe):
        action = getattr(bpy.ops.whittle, operator.bl_idname.split(".")[1])
        assert len(action.get_rna_type().description) > 10
        for row in action.get_rna_type().properties:
            assert row.identifier == "rna_type" or row.description, row.identifier
    shown = [cls for cls in panels.CLASSES if issubclass(cls, bpy.types.Panel)]
    assert len(shown) >= 6 and all(panel.bl_category == "Whittle" for panel in shown)


class Layout:
    """Takes any call of a layout; keeps labels, and checks that properties and operators exist."""

    def __init__(self, labels):
        self._labels = labels

    def label(self, text="", **_):
        self._labels.append(text)

    def prop(self, data, name, **_):
        assert hasattr(data, name), name

    def operator(self, name, **_):
        family, action = name.split(".")
        assert action in dir(getattr(bpy.ops, family))
        return SimpleNamespace()

    def template_list(self, kind, _, data, items, active, index, **__):
        assert hasattr(bpy.types, kind) and hasattr(data, items) and hasattr(active, index)

    def popover(self, panel="", **_):
        assert hasattr(bpy.types, panel)

    def separator(self, **_):
        pass

    def __getattr__(self, name):
        if name in ("row", "column", "box", "split", "grid_flow"):
            return lambda **_: Layout(self._labels)
        raise AttributeError(name)


def drawn(panel):
    labels = []
    panel.draw(SimpleNamespace(layout=Layout(labels)), bpy.context)
    for header in ("draw_header", "draw_header_preset"):
        if hasattr(panel, header):
            getattr(panel, header)(SimpleNamespace(layout=Layout(labels)), bpy.context)
    return " | ".join(labels)


def test_every_panel_can_be_drawn(scene, glass):
    from addon.inspect import panels, probe_overlay

    shown = [cls for cls in panels.CLASSES if issubclass(cls, bpy.types.Panel)]
    made = probed(scene, glass)
    for probe in (None, made):
        probe_overlay.show(probe)
        texts = {panel.__name__: drawn(panel) for panel in shown}
    triangles = f"{glass.build['triangles']:,} triangles"
    assert triangles in texts["WHITTLE_VIEW_PT_scene"]
    for name in ("WHITTLE_VIEW_PT_probe", "WHITTLE_IMAGE_PT_probe"):
        assert "Hits Cube after 9" in texts[name] and "material Of Cube" in texts[name]
        assert "Shared by several" in texts[name]
    scene.whittle_overlay.metric = "BOTH"
    scene.whittle_overlay.range = "FIXED"
    for panel in shown:
        drawn(panel)
    probe_overlay.show(None)
    glass.source.error = "the reason"
    assert "the reason" in drawn(panels.WHITTLE_VIEW_PT_scene)


def test_a_row_of_the_list_tells_what_the_ray_met_and_its_work(scene, glass):
    from addon.inspect import panels, probe_overlay

    probe_overlay.show(probed(scene, glass))
    for row in bpy.context.window_manager.whittle.rays:
        labels = []
        panels.WHITTLE_UL_rays.draw_item(
            SimpleNamespace(), bpy.context, Layout(labels), None, row, 0, None, ""
        )
        assert labels == [row.name, f"{row.nodes} / {row.triangles}"]
    probe_overlay.show(None)


def test_presets_set_what_they_name(scene, addon):
    from addon.inspect import preset_menu

    folder = Path(preset_menu.__file__).parent / "presets" / preset_menu.FOLDER
    files = sorted(folder.glob("*.py"))
    assert len(files) >= 5
    if hasattr(bpy.utils, "register_preset_path"):
        assert str(folder) in bpy.utils.preset_paths(preset_menu.FOLDER)
    for file in files:
        exec(compile(file.read_text(), file, "exec"), {})
    settings = scene.whittle_overlay
    assert (settings.metric, settings.kinds) == ("NODES", {"shadow"})
    assert all(hasattr(settings, name) for name in preset_menu.NAMES)


def test_fit_needs_a_heatmap(scene, stage):
    assert not bpy.ops.whittle.fit_range.poll()
    bpy.data.objects["Cube"].location.z = 0.5
    assert bpy.ops.whittle.update() == {"FINISHED"} and stage.building


@pytest.mark.parametrize(
    "low, high, marks",
    [(0, 100, [0, 20, 40, 60, 80, 100]), (5, 150, [5, 50, 100, 150]), (0, 0.0123, None)],
)
def test_ticks_are_round_between_the_ends(addon, low, high, marks):
    from addon.inspect import legend

    found = legend.ticks(low, high)
    assert found[0] == low and found[-1] == high and 3 <= len(found) <= 7
    assert (np.diff(found) > 0).all() and (marks is None or found == marks)
    assert all(float(f"{mark:.2g}") == mark for mark in found[1:-1])


def test_numbers_are_short(addon):
    from addon.inspect.legend import number

    texts = [number(value) for value in (0, 0.01234, 3.25, 48, 1203.6, 1234567)]
    assert texts == ["0", "0.0123", "3.25", "48", "1,204", "1.23M"]
