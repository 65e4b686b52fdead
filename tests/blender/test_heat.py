# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Heatmaps: colours, ranges, legends, images inside Blender and files."""

import bpy
import numpy as np
import pytest


@pytest.fixture
def result(addon):
    """A result whose node counts rise from 0 at the left to 1,000 at the right."""
    from addon.results import Result

    counts = np.tile(np.linspace(0, 1000, 640, dtype=np.float32), (200, 1))
    return Result(
        scene="Scene",
        layer="ViewLayer",
        frame=1,
        size=(640, 200),
        seconds={"export": 0.1, "build": 0.1, "trace": 0.1},
        build={},
        render={},
        notes=[],
        counters={"nodes": counts},
    )


def test_colormaps_end_in_their_colours_and_rise_in_lightness(addon):
    from addon.heat import colormaps

    for name in colormaps.STOPS.keys() - {"TURBO"}:
        colors = colormaps.apply(name, np.linspace(0, 1, 400))
        light = colors @ (0.2126, 0.7152, 0.0722)
        assert (np.diff(light) > -1e-4).all() and light[-1] - light[0] > 0.5
    ends = colormaps.apply("VIRIDIS", np.array([-1.0, 0.0, 1.0, 2.0])) * 255
    assert np.allclose(ends, [(68, 1, 84), (68, 1, 84), (253, 231, 37), (253, 231, 37)])
    assert [row[0] for row in colormaps.ITEMS][0] == "VIRIDIS"
    assert {row[0] for row in colormaps.ITEMS} == set(colormaps.STOPS)


def test_colours_are_those_of_the_published_map(addon):
    from addon.heat import colormaps

    matplotlib = pytest.importorskip("matplotlib")
    values = np.arange(256) / 255
    for name in colormaps.STOPS:
        published = np.array([matplotlib.colormaps[name.lower()](value)[:3] for value in values])
        assert abs(colormaps.apply(name, values) - published).max() < 5.5 / 255


def test_a_picture_shows_the_counts_above_its_legend(addon, result):
    from addon import heat
    from addon.heat import colormaps

    picture = heat.draw(result, "nodes", top=1000)
    band = picture.shape[0] - 200
    assert picture.shape[1:] == (640, 3) and band >= 40
    expected = colormaps.apply("VIRIDIS", result.counters["nodes"] / 1000)
    assert np.allclose(picture[band:], expected)


def test_the_automatic_range_leaves_out_the_highest_half_percent(addon, result):
    from addon import heat

    result.counters["nodes"][0, 0] = 1e6
    picture = heat.draw(result, "nodes")
    top = float(np.percentile(result.counters["nodes"], 99.5))
    assert top < 1100
    column = np.searchsorted(result.counters["nodes"][5], top)
    assert np.allclose(picture[-1, column + 1] * 255, (253, 231, 37))


def test_small_pictures_are_enlarged(addon, result):
    from addon import heat

    result.counters["nodes"] = result.counters["nodes"][:20, :64]
    assert heat.draw(result, "nodes").shape[1] == 512


def test_counts_of_zero_make_a_picture(addon, result):
    from addon import heat

    result.counters["nodes"][:] = 0
    picture = heat.draw(result, "nodes")
    assert np.allclose(picture[-1, 0] * 255, (68, 1, 84))


def test_shares_and_times_have_scales_of_their_own(addon, result):
    """Coherence spans 0 to 100 % whatever is asked for; time is shown in microseconds."""
    from addon import heat
    from addon.heat import colormaps

    share = result.counters["nodes"] / 1000
    result.counters = {"coherence": share, "seconds": share * np.float32(3e-7)}
    band = heat.draw(result, "coherence").shape[0] - 200
    for picture, values in (
        (heat.draw(result, "coherence", top=1000), share),
        (heat.draw(result, "seconds", top=0.5), share * 0.6),
        (heat.draw(result, "seconds", top=3), share * 0.1),
    ):
        assert np.allclose(picture[band:], colormaps.apply("VIRIDIS", values), atol=1e-5)
    automatic = heat.draw(result, "seconds")[band:]
    assert np.allclose(automatic[0, -1] * 255, (253, 231, 37)), "it spans less than 1"


def test_a_counter_of_another_traversal_says_so(addon, result):
    from addon import heat

    with pytest.raises(heat.HeatError, match="Packets with Statistics"):
        heat.draw(result, "coherence")


@pytest.mark.parametrize("top", [0.004, 0.37, 1, 3, 7.25, 100, 115, 1132, 98765, 1e7])
def test_ticks_are_round_rising_and_within_the_range(addon, top):
    from addon.heat import legend

    ticks = legend.ticks(top)
    assert ticks[0] == 0 and 3 <= len(ticks) <= 9 and ticks[-1] <= top
    assert (np.diff(ticks) > 0).all()
    assert all(float(f"{tick:.2g}") == tick for tick in ticks)


def test_the_legend_holds_its_texts(addon):
    """Each text covers pixels where it stands, and different texts differ."""
    from addon.heat import text

    def cover(word, align):
        return text.cover([text.Label(word, 100, 10, align)], 16, 200, 40)

    left, right = cover("1,234", "LEFT"), cover("1,234", "RIGHT")
    assert left[:, :99].max() < 0.05 and left[:, 100:].max() > 0.9
    assert right[:, 101:].max() < 0.05 and right[:, :100].max() > 0.9
    assert abs(left - cover("1,284", "LEFT")).max() > 0.5


def test_images_in_blender_and_files_hold_the_same_bytes(addon, result, scene, tmp_path):
    from addon import heat

    picture = heat.draw(result, "nodes")
    height, width = picture.shape[:2]
    image = heat.show("Whittle Nodes", picture)
    assert heat.show("Whittle Nodes", picture) == image
    path = tmp_path / "heat.png"
    heat.write(str(path), picture)
    assert [item.name for item in tmp_path.iterdir()] == ["heat.png"]
    saved = bpy.data.images.load(str(path))
    for found in (image, saved):
        assert tuple(found.size) == (width, height)
        values = np.empty(width * height * 4, dtype=np.float32)
        found.pixels.foreach_get(values)
        assert abs(values.reshape(height, width, 4)[..., :3] - picture).max() <= 0.51 / 255


def test_a_render_that_did_not_count_has_no_heatmap(addon, result):
    from addon import heat

    result.counters = {}
    with pytest.raises(heat.HeatError, match="did not count"):
        heat.draw(result, "nodes")


def test_the_button_makes_an_image_of_each_counter(addon, result, scene):
    from addon import results

    assert not bpy.ops.whittle.heatmaps.poll()
    result.counters["triangles_shadow"] = result.counters["nodes"] / 7
    result.counters["nodes_refraction"] = 0 * result.counters["nodes"]
    results.store(result)
    assert bpy.ops.whittle.heatmaps() == {"FINISHED"}
    names = {image.name for image in bpy.data.images if image.name.startswith("Whittle ")}
    assert names == {"Whittle Nodes", "Whittle Triangles Shadow"}


# ---- Text ----

WORDS = ("Nodes visited per pixel", "mean 35.21   highest 1,204", "437+")


def labels(dx=0.0):
    from addon.heat.labels import Label

    places = ((20 + dx, 60, "LEFT"), (380 + dx, 35, "RIGHT"), (200 + dx, 5, "CENTER"))
    return [Label(words, *place) for words, place in zip(WORDS, places, strict=True)]


def spans(cover):
    """First and last column with ink in each third, from the bottom."""
    thirds = np.split(cover, 3)
    return np.array([np.flatnonzero(third.max(axis=0) > 0.3)[[0, -1]] for third in thirds])


def test_text_stands_where_it_should(addon):
    from addon.heat import outlines, text

    for cover in (text.cover, outlines.cover):
        ink = cover(labels(), 16, 400, 84)
        assert ink.shape == (84, 400) and ink.dtype == np.float32
        assert 0 <= ink.min() and 0.9 < ink.max() <= 1 + 1e-6 and 0.02 < ink.mean() < 0.2
        middle, right, left = spans(ink)
        assert abs(left[0] - 20) <= 3 and abs(right[1] - 380) <= 3 and abs(middle.mean() - 200) <= 2
        assert not np.array_equal(spans(cover(labels(9.0), 16, 400, 84)), spans(ink))
        rows = np.flatnonzero(cover([labels()[2]], 16, 400, 84).max(axis=1) > 0.5)
        assert abs(len(rows) - 0.72 * 16) <= 2.5, "digits are as high as the font's size asks for"


def test_text_leaves_nothing_behind(addon):
    from addon.heat import outlines

    def held():
        return [len(getattr(bpy.data, name)) for name in ("curves", "objects", "meshes")]

    before = held()
    outlines.cover(labels(), 16, 400, 84)
    assert held() == before
