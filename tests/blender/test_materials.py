# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes as lobes of the core, and what is said of nodes that are not understood."""

from math import sqrt

import bpy
import pytest


def read(material):
    """The row of a material and the notes."""
    from addon.export.materials import Table
    from addon.notes import Notes

    notes = Notes()
    table = Table(notes, None)
    row = table.rows[table.index(material)]
    table.note_models()
    return row, notes.lines()


@pytest.fixture
def tree(scene):
    """A node tree with an output and nothing else."""
    material = bpy.data.materials.new("Stuff")
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    tree = material.node_tree
    for node in list(tree.nodes):
        if node.type != "OUTPUT_MATERIAL":
            tree.nodes.remove(node)
    return tree


def shade(tree, kind, into=None, **inputs):
    """A shader node with the given inputs, linked to the output or another input."""
    node = tree.nodes.new(kind)
    for name, value in inputs.items():
        node.inputs[name.replace("_", " ")].default_value = value
    target = tree.get_output_node("CYCLES").inputs["Surface"] if into is None else into
    tree.links.new(node.outputs[0], target)
    return node


def stuff():
    return read(bpy.data.materials["Stuff"])


RED = (0.75, 0.5, 0.25, 1.0)


def test_diffuse(tree):
    shade(tree, "ShaderNodeBsdfDiffuse", Color=RED)
    assert stuff() == ({"diffuse": RED[:3]}, [])


@pytest.mark.parametrize("roughness, kept", [(0.0, 0.0), (0.0625, 0.0), (0.25, 0.25), (1.0, 1.0)])
def test_glossy(tree, roughness, kept):
    shade(tree, "ShaderNodeBsdfAnisotropic", Color=RED, Roughness=roughness)
    row, notes = stuff()
    assert row == {"mirror": RED[:3], "roughness": kept}
    assert bool(notes) == (kept > 0)


def test_glass(tree):
    shade(tree, "ShaderNodeBsdfGlass", Color=RED, Roughness=0.0, IOR=1.25)
    row, notes = stuff()
    assert row == {"specular": RED[:3], "transmission": RED[:3], "ior": 1.25, "roughness": 0.0}
    assert notes == []


def test_rough_glass_is_named(tree):
    shade(tree, "ShaderNodeBsdfGlass", Roughness=0.5)
    assert any("refraction is drawn sharp" in line for line in stuff()[1])


def test_emission(tree):
    shade(tree, "ShaderNodeEmission", Color=RED, Strength=4.0)
    glow = "Glowing surfaces are seen, but light nothing: 1 material (Stuff)"
    assert stuff() == ({"emission": (3.0, 2.0, 1.0)}, [glow])


def test_principled_plastic(tree):
    shade(tree, "ShaderNodeBsdfPrincipled", Base_Color=RED, Roughness=0.0, IOR=1.5)
    row, notes = stuff()
    assert row["diffuse"] == RED[:3]
    assert row["specular"] == (1, 1, 1) and row["ior"] == 1.5
    assert row["transmission"] == (0, 0, 0) and row["metal_weight"] == 0
    assert row["emission"] == (0, 0, 0) and row["roughness"] == 0 and notes == []


def test_principled_metal(tree):
    shade(tree, "ShaderNodeBsdfPrincipled", Base_Color=RED, Metallic=0.75, Roughness=0.0)
    row, _ = stuff()
    assert row["metal"] == RED[:3] and row["metal_weight"] == 0.75
    assert row["diffuse"] == tuple(0.25 * c for c in RED[:3])
    assert row["specular"] == (0.25, 0.25, 0.25)


def test_principled_glass(tree):
    shade(tree, "ShaderNodeBsdfPrincipled", Base_Color=RED, Transmission_Weight=0.75, Roughness=0.0)
    row, _ = stuff()
    assert row["transmission"] == pytest.approx([0.75 * sqrt(c) for c in RED[:3]])
    assert row["diffuse"] == tuple(0.25 * c for c in RED[:3])


@pytest.mark.parametrize("level", [0.25, 0.5, 1.0])
def test_principled_specular_level_scales_the_reflectance(tree, level):
    shade(tree, "ShaderNodeBsdfPrincipled", Specular_IOR_Level=level, IOR=1.5)
    ior = stuff()[0]["ior"]
    assert ((ior - 1) / (ior + 1)) ** 2 == pytest.approx(2 * level * 0.04)


def test_principled_without_specular_level_is_diffuse(tree):
    shade(tree, "ShaderNodeBsdfPrincipled", Specular_IOR_Level=0.0)
    row, notes = stuff()
    assert row["specular"] == (0, 0, 0) and notes == []


def test_principled_approximations_are_named(tree):
    shade(
        tree,
        "ShaderNodeBsdfPrincipled",
        Specular_Tint=RED,
        Specular_IOR_Level=1.0,
        Transmission_Weight=1.0,
        Roughness=0.0,
    )
    text = "\n".join(stuff()[1])
    assert "Specular Tint" in text and "Specular IOR Level" in text


def test_principled_emission(tree):
    shade(tree, "ShaderNodeBsdfPrincipled", Emission_Color=RED, Emission_Strength=4.0)
    assert stuff()[0]["emission"] == (3.0, 2.0, 1.0)


def test_inputs_left_out_are_named(tree):
    shade(tree, "ShaderNodeBsdfPrincipled", Coat_Weight=1.0, Alpha=0.5, Roughness=0.0)
    _, notes = stuff()
    assert notes == [
        "Material 'Stuff': Principled BSDF: Alpha is left out",
        "Material 'Stuff': Principled BSDF: Coat Weight is left out",
    ]


def test_constant_nodes_are_read_through_reroutes_groups_and_muted_nodes(tree):
    inner = bpy.data.node_groups.new("Inner", "ShaderNodeTree")
    inner.interface.new_socket("Tint", in_out="INPUT", socket_type="NodeSocketColor")
    inner.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    start, end = inner.nodes.new("NodeGroupInput"), inner.nodes.new("NodeGroupOutput")
    diffuse = inner.nodes.new("ShaderNodeBsdfDiffuse")
    muted = inner.nodes.new("ShaderNodeGamma")
    muted.mute = True
    inner.links.new(start.outputs["Tint"], muted.inputs["Color"])
    inner.links.new(muted.outputs["Color"], diffuse.inputs["Color"])
    inner.links.new(diffuse.outputs[0], end.inputs["Shader"])
    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree = inner
    reroute, color = tree.nodes.new("NodeReroute"), tree.nodes.new("ShaderNodeRGB")
    color.outputs[0].default_value = RED
    tree.links.new(color.outputs[0], reroute.inputs[0])
    tree.links.new(reroute.outputs[0], group.inputs["Tint"])
    tree.links.new(group.outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])
    assert stuff() == ({"diffuse": RED[:3]}, [])
    tree.links.remove(group.inputs["Tint"].links[0])
    group.inputs["Tint"].default_value = (0.5, 0.5, 0.5, 1)
    assert stuff() == ({"diffuse": (0.5, 0.5, 0.5)}, [])


def test_a_texture_falls_back_to_the_sockets_value_and_is_named(tree):
    node = shade(tree, "ShaderNodeBsdfDiffuse", Color=RED)
    noise = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(noise.outputs["Color"], node.inputs["Color"])
    row, notes = stuff()
    assert row == {"diffuse": RED[:3]}
    assert len(notes) == 1 and "'Noise Texture'" in notes[0] and "'Stuff'" in notes[0]


def test_a_mixture_is_its_first_shader_that_is_understood(tree):
    mix = shade(tree, "ShaderNodeMixShader")
    shade(tree, "ShaderNodeBsdfToon", into=mix.inputs[1])
    shade(tree, "ShaderNodeBsdfDiffuse", into=mix.inputs[2], Color=RED)
    row, notes = stuff()
    assert row == {"diffuse": RED[:3]}
    assert len(notes) == 1 and "'Mix Shader'" in notes[0] and "'Diffuse BSDF'" in notes[0]


def test_a_mixture_of_mixtures(tree):
    outer = shade(tree, "ShaderNodeAddShader")
    inner = shade(tree, "ShaderNodeMixShader", into=outer.inputs[0])
    shade(tree, "ShaderNodeEmission", into=inner.inputs[1], Color=RED)
    row, notes = stuff()
    assert row == {"emission": RED[:3]}
    assert len([line for line in notes if "not understood" in line]) == 2


def test_other_shaders_are_diffuse_and_named(tree):
    shade(tree, "ShaderNodeBsdfToon", Color=RED)
    row, notes = stuff()
    assert row == {"diffuse": RED[:3]}
    assert len(notes) == 1 and "'Toon BSDF'" in notes[0]


def test_a_number_that_is_none_is_an_error_that_names_the_material(tree):
    shade(tree, "ShaderNodeEmission", Color=RED, Strength=float("nan"))
    with pytest.raises(ValueError, match="Material 'Stuff': its emission"):
        stuff()


def test_nothing_on_the_surface_is_black_and_named(tree):
    row, notes = stuff()
    assert row == {} and len(notes) == 1


def test_volume_and_displacement_are_named(tree):
    shade(tree, "ShaderNodeBsdfDiffuse")
    output = tree.get_output_node("CYCLES")
    shade(tree, "ShaderNodeVolumeAbsorption", into=output.inputs["Volume"])
    shade(tree, "ShaderNodeDisplacement", into=output.inputs["Displacement"])
    assert [line[18:] for line in stuff()[1]] == ["Volume is left out", "Displacement is left out"]


@pytest.mark.skipif(bpy.app.version >= (5, 0), reason="materials always have nodes from 5.0 on")
def test_a_material_without_nodes_has_its_viewport_colour(scene):
    material = bpy.data.materials.new("Plain")
    material.diffuse_color = RED
    material.roughness = 0.0
    assert read(material)[0]["diffuse"] == RED[:3]
