# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which panels show while the engine is chosen, and that the add-on's own can be drawn."""

from types import SimpleNamespace

import bpy
import pytest

# Tabs of the Properties editor, and a built-in panel of each that must show.
MUST_SHOW = [
    "DATA_PT_EEVEE_light",
    "DATA_PT_camera",
    "DATA_PT_context_light",
    "DATA_PT_lens",
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_surface",
    "OBJECT_PT_visibility",
    "RENDER_PT_color_management",
    "RENDER_PT_format",
    "RENDER_PT_frame_range",
    "RENDER_PT_output",
    "VIEWLAYER_PT_layer",
    "WORLD_PT_context_world",
]
MUST_NOT_SHOW = ["RENDER_PT_stereoscopy", "RENDER_PT_freestyle", "MATERIAL_PT_preview"]


def panel(name):
    return next(cls for cls in bpy.types.Panel.__subclasses__() if cls.__name__ == name)


def context(scene, **values):
    """What the panels' polls look at, for an object with a material, a light, a camera, a world."""
    return SimpleNamespace(engine=scene.render.engine, scene=scene, **values)


@pytest.fixture
def contexts(scene):
    """A context for each tab."""
    ob = bpy.data.objects.new("Cube", bpy.data.meshes.new("Cube"))
    material = bpy.data.materials.new("Material")
    ob.data.materials.append(material)
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    world = bpy.data.worlds.new("World")
    none = dict.fromkeys(
        ("object", "material", "material_slot", "light", "camera", "world", "view_layer")
    )
    both = dict(space_data=SimpleNamespace(pin_id=None, use_pin_id=False))
    return {
        "DATA_PT_c": none | both | {"camera": scene.camera.data, "object": scene.camera},
        "DATA_PT_l": none | both | {"camera": scene.camera.data, "object": scene.camera},
        "DATA_PT_EEVEE": none | both | {"light": lamp.data, "object": lamp},
        "DATA_PT_context_light": none | both | {"light": lamp.data, "object": lamp},
        "EEVEE_MATERIAL": none
        | both
        | {"material": material, "object": ob, "material_slot": ob.material_slots[0]},
        "EEVEE_WORLD": none | both | {"world": world},
        "WORLD": none | both | {"world": world},
        "OBJECT": none | both | {"object": ob},
        "": none | both,
    }


def shows(name, scene, contexts):
    """Whether a panel's own poll says yes; a panel without one shows by its tab alone."""
    cls = panel(name)
    longest = max((key for key in contexts if name.startswith(key)), key=len)
    poll = getattr(cls, "poll", None)
    return poll is None or bool(poll(context(scene, **contexts[longest])))


@pytest.mark.parametrize("name", MUST_SHOW)
def test_blenders_panels_show(scene, contexts, name):
    assert shows(name, scene, contexts)


@pytest.mark.parametrize("name", MUST_NOT_SHOW)
def test_panels_that_do_not_apply_stay_away(name):
    engines = getattr(panel(name), "COMPAT_ENGINES", set())
    assert "WHITTLE" not in engines


def test_blender_gets_its_panels_back(scene, addon):
    addon.unregister()
    try:
        for cls in bpy.types.Panel.__subclasses__():
            if not cls.__name__.startswith("WHITTLE_"):
                assert "WHITTLE" not in getattr(cls, "COMPAT_ENGINES", ())
    finally:
        addon.register()
    assert "WHITTLE" in panel("EEVEE_MATERIAL_PT_surface").COMPAT_ENGINES


def test_the_add_ons_panels_show_for_its_engine_only(scene, addon):
    from addon import panels

    for cls in panels.CLASSES:
        values = {"object": scene.camera, "light": bpy.data.lights.new("Lamp", "POINT")}
        assert cls.poll(context(scene, **values))
        scene.render.engine = "CYCLES"
        assert not cls.poll(context(scene, **values))
        scene.render.engine = "WHITTLE"


def test_the_engine_says_what_blender_may_do_for_it(addon):
    engine = addon.engine.WhittleEngine
    assert not engine.bl_use_shading_nodes_custom  # Cycles' nodes stay in the menus
    assert engine.bl_use_postprocess  # the compositor runs
    assert engine.bl_use_eevee_viewport  # Material Preview works


class Layout:
    """Takes any call of a layout and keeps the labels."""

    def __init__(self, labels):
        self._labels = labels

    def label(self, text="", **_):
        self._labels.append(text)

    def prop(self, data, name, **_):
        assert hasattr(data, name), name

    def operator(self, name, **_):
        family, action = name.split(".")
        assert action in dir(getattr(bpy.ops, family))

    def __getattr__(self, name):
        if name in ("row", "column", "box", "split"):
            return lambda **_: Layout(self._labels)
        raise AttributeError(name)


def drawn(cls, scene):
    labels = []
    fake = SimpleNamespace(layout=Layout(labels))
    light = bpy.data.lights.new("Lamp", "POINT")
    where = context(scene, view_layer=scene.view_layers[0], object=scene.camera, light=light)
    cls.draw(fake, where)
    return labels


def test_every_panel_can_be_drawn(scene, addon):
    from addon import panels

    for cls in panels.CLASSES:
        drawn(cls, scene)


def test_samples_that_are_not_square_are_marked(scene, addon):
    from addon import panels

    scene.whittle.samples = 5
    assert any("square" in text for text in drawn(panels.WHITTLE_RENDER_PT_sampling, scene))
    scene.whittle.samples = 9
    assert drawn(panels.WHITTLE_RENDER_PT_sampling, scene) == []


def test_a_native_module_that_does_not_load_is_explained(scene, addon, monkeypatch):
    import sys

    from addon import native, panels

    monkeypatch.setattr(native, "_checked", False)
    monkeypatch.setattr(native, "_problem", None)
    monkeypatch.setitem(sys.modules, "whittle_core", None)
    text = " ".join(drawn(panels.WHITTLE_RENDER_PT_render, scene))
    assert "cannot render" in text and "whittle_core" in text and "not installed" in text
