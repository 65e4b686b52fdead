# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The report's measures: errors, settings that change no bit, needs left out; on a small demo."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
bpy = pytest.importorskip("bpy")
sys.path.insert(0, str(ROOT / "docs" / "make"))


@pytest.fixture(scope="module")
def shot(addon):
    """The demo with coarse spheres and a coarse Suzanne, 64 x 40."""
    import capture
    import studio

    scene = studio.open_scene()
    coarse = bpy.data.meshes["Bulb"]
    for item in scene.objects:
        if item.type == "MESH" and "Sphere" in item.data.name:
            material = item.material_slots[0].material
            item.data = coarse
            item.material_slots[0].link = "OBJECT"
            item.material_slots[0].material = material
    scene.objects["Suzanne"].modifiers[0].render_levels = 1
    scene.render.resolution_percentage = 5
    return capture.shot(scene)


@pytest.fixture(scope="module")
def needs(shot):
    import leaving_out

    return {row.need: row for row in leaving_out.run(shot, rounds=1)}


def test_each_need_can_be_left_out_without_changing_a_bit(needs):
    import leaving_out

    assert list(needs) == [row[0] for row in leaving_out.NEEDS]
    for name, row in needs.items():
        assert row.same, name
        assert row.off.picture == row.generic.picture, name


def test_kernels_hold_what_is_needed_and_no_more(needs):
    for name, row in needs.items():
        assert name in row.on.kernel
        assert name not in row.off.kernel
    # Counters cost too much to be in any kernel that was not asked to count.
    assert all(name in row.generic.kernel for name, row in needs.items() if name != "counters")


def test_needs_change_the_picture_that_has_them(needs):
    seen = ("mirror", "glass", "smooth normals", "several lights", "highlights", "samples")
    for name in seen:
        assert needs[name].on.picture != needs[name].off.picture, name
    assert needs["counters"].on.picture == needs["counters"].off.picture
    assert needs["smooth normals"].off.bytes < needs["smooth normals"].on.bytes


def test_settings_of_speed_change_no_bit(shot):
    import same_bits

    rows = list(same_bits.run(shot))
    assert len({row.setting for row in rows}) >= 8
    assert {row.digest for row in rows} == {rows[0].digest}


def test_a_changed_bit_changes_the_digest(shot):
    import same_bits

    scene = shot.scene()
    scene.build()
    plain, _ = same_bits.digest(scene, shot, {})
    other, _ = same_bits.digest(scene, shot, {"cutoff": 0.01})
    assert plain != other


def test_errors_fall_with_samples_and_depth(shot, monkeypatch):
    import error

    monkeypatch.setitem(error.REFERENCE, "samples", 64)
    scene = shot.scene()
    scene.build()
    reference = error.make_reference(scene, shot)
    assert reference.samples == 128
    rows = {
        (row.pattern, row.samples, row.depth): row
        for row in error.sweep(scene, shot, reference, (0.0, 0.0), rounds=1)
    }
    assert len(rows) == 20
    # As shown: in so small a picture one sample that hits a bulb outweighs all else in full light.
    shown = {key: row.rmse_shown for key, row in rows.items()}
    assert shown["regular", 64, 8] < shown["regular", 4, 8] < shown["regular", 1, 8]
    assert shown["regular", 64, 8] < shown["regular", 64, 2] < shown["regular", 64, 1]
    assert all(row.seconds == pytest.approx(row.trace + row.shade) for row in rows.values())


def test_rmse_is_what_it_says():
    import error

    flat = np.zeros((4, 5, 3), dtype=np.float32)
    assert error.rmse(flat, flat + 0.5) == pytest.approx(0.5)
    one = flat.copy()
    one[0, 0, 0] = 1
    assert error.rmse(one, flat) == pytest.approx((1 / 60) ** 0.5)


def test_a_setting_that_changes_a_bit_is_named():
    import report
    import same_bits

    rows = [same_bits.Row("bins", "8", "aa", 0.0, 0.0), same_bits.Row("bins", "16", "ab", 0.0, 0.0)]
    found = report.Report(*([None] * 11), identities=rows, needs=[])
    assert found.failures() == ["bins 16"]
    assert replace(found, identities=rows[:1]).failures() == []
