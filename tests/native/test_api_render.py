# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras, settings, materials and lights of whittle_core, and the shape of what render gives."""

from math import inf, nan
from types import MappingProxyType

import numpy as np
import pytest
import whittle_core
from small_scenes import ONE, TRIANGLE, built, camera, changed
from whittle_core import Scene

KINDS = ("primary", "shadow", "reflection", "refraction")
SQUARE = np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A white triangle in the lower left half of the unit square, lit from above."""
    scene = built(TRIANGLE, ONE)
    scene.set_lights([{"kind": "sun", "direction": (0, 0, -1), "intensity": (1, 1, 1)}])
    return scene


# ---- Images --------------------------------------------------------------------------------------


def test_every_pass_has_its_shape(scene):
    settings = {"passes": list(whittle_core.PASSES), "mode": "lecture"}
    result = scene.render(camera(), settings)
    stats = result.pop("stats")
    assert list(result) == list(whittle_core.PASSES)
    for name, channels in whittle_core.PASSES.items():
        assert result[name].shape == (24, 32, channels)
        assert result[name].dtype == np.float32
    assert set(stats) > {"rays", "seconds", "own_box_misses", "threads", "bytes"}
    assert all(set(stats[name]) == set(KINDS) for name in ("rays", "nodes", "triangles"))
    assert stats["rays"]["primary"] == 24 * 32


def test_combined_is_the_default_and_doubles_are_one(scene):
    assert list(scene.render(camera())) == ["combined", "stats"]
    result = scene.render(camera(), {"passes": ("depth", "normal", "depth")})
    assert list(result) == ["depth", "normal", "stats"]


def test_row_0_is_at_the_bottom(scene):
    hit = scene.render(camera(), {"passes": ["depth"]})["depth"][..., 0] < 1e10
    assert hit[:6].sum() > 2 * hit[-6:].sum() > 0
    assert hit[:, 16:].sum() < hit[:, :16].sum()


def test_a_region_is_a_part_of_the_whole(scene):
    settings = {"passes": ["combined", "nodes"], "samples": 4, "pattern": "stratified", "seed": 7}
    whole = scene.render(camera(), settings)
    for x0, y0, x1, y1 in ((3, 5, 20, 17), (0, 0, 32, 24), (31, 23, 32, 24)):
        part = scene.render(camera(region=(x0, y0, x1, y1)), settings)
        for name in ("combined", "nodes"):
            np.testing.assert_array_equal(part[name], whole[name][y0:y1, x0:x1])


def test_zero_means_zero(scene):
    scene = built(SQUARE, [[0, 1, 2], [0, 2, 3]], [np.eye(4), changed(2, 3, 4)])
    scene.set_materials([{"mirror": (0.5, 0.5, 0.5)}])
    bounces = {
        depth: scene.render(camera(), {"max_depth": depth})["stats"]["rays"]["reflection"]
        for depth in (0, 1, 2)
    }
    assert bounces[0] == 0 < bounces[1] < bounces[2]
    deep = {"max_depth": 60, "samples": 1}
    kept = scene.render(camera(), deep | {"cutoff": 0})["stats"]
    cut = scene.render(camera(), deep)["stats"]
    assert kept["secondary_rays_left_out"] < cut["secondary_rays_left_out"]
    assert kept["rays"]["reflection"] > cut["rays"]["reflection"]


def test_the_modes_give_the_same_image(scene):
    wanted = scene.render(camera())["combined"]
    for mode in ({"mode": "lecture"}, {"mode": "single"}, {"generic": True}, {"packet": 16}):
        np.testing.assert_array_equal(scene.render(camera(), mode)["combined"], wanted)
    lecture = scene.render(camera(), {"mode": "lecture"})["stats"]
    assert lecture["packets"] > 0
    assert scene.render(camera())["stats"]["packets"] == 0


def test_what_is_left_out_is_told(scene):
    stats = scene.render(camera(), {"passes": ["combined"]})["stats"]
    names = [name for name, _ in stats["left_out"]]
    assert not set(names) & set(stats["kernel_needs"])
    assert "counters" in names and all(reason for _, reason in stats["left_out"])
    counted = scene.render(camera(), {"passes": ["nodes"]})["stats"]
    assert "counters" in counted["needs"]
    generic = scene.render(camera(), {"generic": True})["stats"]["left_out"]
    assert {name for name, _ in generic} <= {"counters"}, "no arrays to count into"


def test_transparency_leaves_the_background_empty(scene):
    scene.set_world((1, 2, 3))
    empty = scene.render(camera(), {"passes": ["depth"]})["depth"][..., 0] == 1e10
    for transparent, pixel in ((False, (1, 2, 3, 1)), (True, (0, 0, 0, 0))):
        image = scene.render(camera(), {"transparent": transparent})["combined"]
        np.testing.assert_array_equal(image[empty], np.broadcast_to(pixel, (empty.sum(), 4)))
    scene.set_world((0, 0, 0))


# ---- What is refused -----------------------------------------------------------------------------

BAD_CAMERAS = {
    "to_world": [np.zeros((4, 4)), changed(1, 2, nan), np.eye(3), None, "M"],
    "projection": [np.zeros((4, 4)), changed(0, 0, inf), np.eye(4)[:3], [1]],
    "width": [0, -1, 1.5, None, 2**32],
    "height": [0, "24"],
    "clip_start": [nan, "near"],
    "clip_end": [nan, None],
    "region": [(0, 0, 33, 24), (5, 0, 5, 24), (0, 9, 9, 3), (0, 0, 1), "0011", 3, (0, 0, 1, -1)],
}
BAD_SETTINGS = {
    "passes": ["combined", [], ["beauty"], [3], None, {"combined": 1}],
    "samples": [0, 2, 3, 4097, -1, 1.5, "4"],
    "pattern": ["random", 1, None],
    "seed": [-1, 2**32, 0.5],
    "max_depth": [-1, 65, 1.5],
    "cutoff": [-0.1, nan, inf, "low"],
    "transparent": ["yes", None, []],
    "mode": ["slow", 0],
    "packet": [2, 5, -1, 2048],
    "threads": [-1, 0.5],
    "generic": ["no"],
}


def each(table: dict) -> list[tuple]:
    return [(name, value) for name, values in table.items() for value in values]


@pytest.mark.parametrize(("name", "value"), each(BAD_CAMERAS))
def test_bad_cameras_name_the_key(scene, name, value):
    with pytest.raises(ValueError, match=rf"\b{name}\b"):
        scene.render(camera() | {name: value})


@pytest.mark.parametrize(("name", "value"), each(BAD_SETTINGS))
def test_bad_settings_name_the_key(scene, name, value):
    for call in (scene.render, lambda *given: scene.start(*given).result()):
        with pytest.raises(ValueError, match=rf"\b{name}\b"):
            call(camera(), {name: value})


def test_keys_are_needed_and_known(scene):
    for key in ("to_world", "projection", "width", "height"):
        view = camera()
        del view[key]
        with pytest.raises(ValueError, match=rf"{key}.* is missing"):
            scene.render(view)
    with pytest.raises(ValueError, match=r"^camera may hold .*not 'fov'"):
        scene.render(camera(fov=1))
    with pytest.raises(ValueError, match=r"^settings may hold .*not 'sample'"):
        scene.render(camera(), {"sample": 4})
    for nothing in (3, "camera", [1], None):
        with pytest.raises(ValueError, match="^camera must be a mapping"):
            scene.render(nothing)
    scene.render(MappingProxyType(camera()), MappingProxyType({"samples": 4}))


# ---- Materials, lights and world -----------------------------------------------------------------


@pytest.mark.parametrize("key", ["diffuse", "mirror", "metal", "specular"])
@pytest.mark.parametrize("value", [(1, 1), 0.5, "red", (1, nan, 1), (0, 0, 1e39), None])
def test_bad_colors_name_the_material(key, value):
    with pytest.raises(ValueError, match=rf"materials\[1\].*{key}|{key}.*material 1"):
        Scene().set_materials([{}, {key: value}])


@pytest.mark.parametrize(
    ("key", "value"),
    [("ior", 0), ("ior", -1), ("ior", nan), ("roughness", -0.1), ("roughness", "rough")]
    + [("metal_weight", 1.5), ("metal_weight", None), ("color", (1, 1, 1))],
)
def test_bad_numbers_name_the_material(key, value):
    with pytest.raises(
        ValueError, match=rf"(?i)(materials\[0\]|material 0).*{key}|{key}.*material 0"
    ):
        Scene().set_materials([{key: value}])


POINT = {"kind": "point", "intensity": (1, 1, 1), "position": (0, 0, 1)}
SUN = {"kind": "sun", "intensity": (1, 1, 1), "direction": (0, 0, -1)}


@pytest.mark.parametrize(
    ("light", "key", "value"),
    [(POINT, "kind", "spot"), (POINT, "intensity", (1, 1)), (POINT, "intensity", (inf, 0, 0))]
    + [(POINT, "position", (nan, 0, 0)), (POINT, "shadow", "yes"), (POINT, "power", 3)]
    + [(SUN, "direction", (0, 0, 0)), (SUN, "direction", None), (SUN, "kind", 1)],
)
def test_bad_lights_name_the_key(light, key, value):
    with pytest.raises(ValueError, match=rf"lights?\b.*{key}|{key}.*light"):
        Scene().set_lights([light, {**light, key: value}])


@pytest.mark.parametrize("light", [POINT, SUN])
def test_lights_need_their_keys(light):
    for key in light:
        less = {name: value for name, value in light.items() if name != key}
        with pytest.raises(ValueError, match=rf"lights\[0\]\['{key}'\] is missing"):
            Scene().set_lights([less])


@pytest.mark.parametrize("bad", [3, "abc", None, {"diffuse": (1, 1, 1)}, [3]])
def test_lists_of_mappings_are_needed(bad):
    for name in ("materials", "lights"):
        with pytest.raises(ValueError, match=rf"^{name}"):
            getattr(Scene(), f"set_{name}")(bad)


@pytest.mark.parametrize("color", [(1, 1), (nan, 0, 0), "sky", 1])
def test_bad_worlds_name_the_argument(color):
    with pytest.raises(ValueError, match=r"\bcolor\b"):
        Scene().set_world(color)
    with pytest.raises(ValueError, match=r"\bambient\b"):
        Scene().set_world((0, 0, 0), color)


def test_appearance_needs_no_new_build(scene):
    dark = built(TRIANGLE, ONE)
    assert not dark.render(camera())["combined"][..., :3].any()
    dark.set_lights([SUN | {"shadow": False}])
    dark.set_materials([{"diffuse": np.float64([0.5, 0.25, 0])}])
    lit = dark.render(camera())["combined"]
    np.testing.assert_allclose(lit[2, 12], [0.5 / np.pi, 0.25 / np.pi, 0, 1], rtol=1e-5)


def test_a_material_that_is_missing_is_an_error():
    scene = Scene()
    scene.add_instance(scene.add_mesh(TRIANGLE, ONE, materials=[3]), np.eye(4))
    scene.build()
    with pytest.raises(ValueError, match="material"):
        scene.render(camera())
    scene.set_materials([{}] * 4)
    scene.render(camera())
