# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo scene: Whitted's picture of 1980, with a mirror, glass, gold and Suzanne."""

from __future__ import annotations

from math import radians

import bmesh
import bpy
from mathutils import Matrix, Vector

Color = tuple[float, float, float]

SKY: Color = (0.19, 0.36, 0.72)
CHECKS: tuple[Color, Color] = (0.62, 0.035, 0.018), (0.80, 0.56, 0.12)

#: Where the camera stands and looks (metres), and its focal length (mm).
CAMERA, TARGET, LENS = (-0.5, -11.5, 4.2), (0.1, 0.0, 1.2), 45.0

#: Point lights: name, position (m), power (W), colour.
LAMPS: tuple[tuple[str, Vector, float, Color], ...] = (
    ("Key", Vector((-5.2, -6.0, 6.4)), 1500.0, (1.0, 0.93, 0.82)),
    ("Fill", Vector((6.0, -5.0, 4.2)), 620.0, (0.72, 0.84, 1.0)),
    ("Back", Vector((1.5, 5.5, 6.0)), 700.0, (1.0, 0.86, 0.7)),
)
SUN_STRENGTH = 0.9  #: W/m^2

#: Small spheres on the floor: material, x, y, radius (m).
BALLS: tuple[tuple[str, float, float, float], ...] = (
    ("blue", -3.7, -2.2, 0.42),
    ("ruby", -2.35, -3.3, 0.50),
    ("white", -1.3, -3.7, 0.27),
    ("green", 1.75, -3.6, 0.40),
    ("copper", 3.0, -2.9, 0.40),
    ("white", 2.35, -1.6, 0.34),
    ("blue", 4.3, -1.0, 0.55),
    ("ruby", -4.6, 3.2, 0.60),
    ("white", 0.2, 4.6, 0.75),
    ("blue", -1.2, 7.5, 0.9),
    ("copper", 5.2, 4.4, 0.8),
)

#: Glowing panels behind the camera, for mirrors to show: name, centre (m), width and height (m).
PANELS: tuple[tuple[str, Vector, float, float], ...] = (
    ("Left Panel", Vector((-9.0, -13.0, 9.5)), 7.0, 4.5),
    ("Right Panel", Vector((11.0, -8.0, 7.5)), 3.0, 6.0),
)


def build(scene: bpy.types.Scene) -> None:
    """Fill a scene, best an empty one, with the demo: objects, lights, camera, world, settings."""
    before = set(scene.collection.objects)
    materials = _materials()
    _floor(scene, materials, tiles=40, size=1.0)
    _suzanne(scene, materials)
    _spheres(scene, materials)
    _lights(scene)
    _panels(scene)
    _camera(scene)
    _world(scene)
    added = [item for item in scene.collection.objects if item not in before]
    for index, item in enumerate(added, start=1):
        item.pass_index = index
    scene.render.resolution_x, scene.render.resolution_y = 1280, 800
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Standard"
    if hasattr(scene, "whittle"):
        scene.render.engine = "WHITTLE"
        scene.whittle.samples = 16


def _materials() -> dict[str, bpy.types.Material]:
    return {
        "red": _material("Check Red", "ShaderNodeBsdfDiffuse", color=CHECKS[0]),
        "yellow": _material("Check Yellow", "ShaderNodeBsdfDiffuse", color=CHECKS[1]),
        "blue": _material("Blue", "ShaderNodeBsdfDiffuse", color=(0.03, 0.11, 0.42)),
        "white": _material("White", "ShaderNodeBsdfDiffuse", color=(0.78, 0.76, 0.72)),
        "mirror": _mirror("Mirror", (0.80, 0.82, 0.86)),
        "ruby": _mirror("Ruby Mirror", (0.85, 0.10, 0.14)),
        "glass": _glass("Glass", (0.97, 0.99, 0.98), 1.5),
        "green": _glass("Green Glass", (0.62, 0.96, 0.74), 1.5),
        "gold": _metal("Gold", (1.0, 0.72, 0.30)),
        "copper": _metal("Copper", (0.95, 0.52, 0.36)),
    }


def _material(name: str, node: str, color: Color) -> bpy.types.Material:
    """A material of one shader whose first socket is its colour, unconnected sockets at default."""
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new(node)
    shader.inputs[0].default_value = (*color, 1.0)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    output.location.x = 300.0
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    material.diffuse_color = (*color, 1.0)
    return material


def _shader(material: bpy.types.Material) -> bpy.types.ShaderNode:
    return material.node_tree.nodes[0]


def _mirror(name: str, color: Color) -> bpy.types.Material:
    material = _material(name, "ShaderNodeBsdfAnisotropic", color)
    _shader(material).inputs["Roughness"].default_value = 0.0
    return material


def _glass(name: str, color: Color, ior: float) -> bpy.types.Material:
    material = _material(name, "ShaderNodeBsdfGlass", color)
    _shader(material).inputs["Roughness"].default_value = 0.0
    _shader(material).inputs["IOR"].default_value = ior
    return material


def _metal(name: str, color: Color) -> bpy.types.Material:
    material = _material(name, "ShaderNodeBsdfPrincipled", color)
    _shader(material).inputs["Metallic"].default_value = 1.0
    _shader(material).inputs["Roughness"].default_value = 0.0
    return material


def _glow(name: str, color: Color, strength: float) -> bpy.types.Material:
    material = _material(name, "ShaderNodeEmission", color)
    _shader(material).inputs["Strength"].default_value = strength
    return material


def _add(scene: bpy.types.Scene, name: str, data: bpy.types.ID | None) -> bpy.types.Object:
    item = bpy.data.objects.new(name, data)
    scene.collection.objects.link(item)
    return item


def _floor(scene, materials, tiles: int, size: float) -> None:
    """A checkered square: one quad a check, two materials, no texture."""
    half = tiles * size / 2
    row = tiles + 1
    points = [(x * size - half, y * size - half, 0.0) for y in range(row) for x in range(row)]
    corners = [(y * row + x) for y in range(tiles) for x in range(tiles)]
    mesh = bpy.data.meshes.new("Floor")
    mesh.from_pydata(points, [], [(c, c + 1, c + row + 1, c + row) for c in corners])
    mesh.materials.append(materials["red"])
    mesh.materials.append(materials["yellow"])
    mesh.polygons.foreach_set("material_index", [(c % row + c // row) % 2 for c in corners])
    _add(scene, "Floor", mesh)


def _suzanne(scene, materials) -> None:
    """Suzanne in gold: four levels of subdivision in the render, two in the viewport."""
    mesh = _mesh("Suzanne", lambda bm: bmesh.ops.create_monkey(bm))
    mesh.materials.append(materials["gold"])
    item = _add(scene, "Suzanne", mesh)
    item.matrix_world = (
        Matrix.Translation((-2.3, 0.5, 1.36))
        @ Matrix.Rotation(radians(14), 4, "Z")
        @ Matrix.Rotation(radians(-22), 4, "X")
        @ Matrix.Diagonal((1.55, 1.55, 1.55, 1.0))
    )
    subdivide = item.modifiers.new("Subdivision", "SUBSURF")
    subdivide.levels, subdivide.render_levels = 2, 4


def _mesh(name: str, fill) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new(name)
    work = bmesh.new()
    fill(work)
    for face in work.faces:
        face.smooth = True
    work.to_mesh(mesh)
    work.free()
    return mesh


def _sphere(name: str, subdivisions: int) -> bpy.types.Mesh:
    """A smooth sphere of radius 1: 20 x 4^(subdivisions - 1) triangles."""
    return _mesh(
        name,
        lambda bm: bmesh.ops.create_icosphere(bm, subdivisions=subdivisions, radius=1.0),
    )


def _spheres(scene, materials) -> None:
    """Two great spheres share one mesh, the small ones another: their materials are their own."""
    great, small = _sphere("Great Sphere", 8), _sphere("Small Sphere", 6)
    _ball(scene, "Mirror Sphere", great, materials["mirror"], (2.1, 1.3, 1.8), 1.8)
    _ball(scene, "Glass Sphere", great, materials["glass"], (0.15, -2.6, 1.45), 1.15)
    for index, (key, x, y, radius) in enumerate(BALLS, start=1):
        _ball(scene, f"Ball {index}", small, materials[key], (x, y, radius), radius)


def _ball(scene, name, mesh, material, place, radius: float) -> bpy.types.Object:
    if not mesh.materials:
        mesh.materials.append(None)
    item = _add(scene, name, mesh)
    item.matrix_world = Matrix.Translation(place) @ Matrix.Diagonal((radius,) * 3 + (1.0,))
    item.material_slots[0].link = "OBJECT"
    item.material_slots[0].material = material
    return item


def _lights(scene) -> None:
    """Point lights, each below a glowing bulb that mirrors show and shadows ignore; and a sun."""
    bulb = _sphere("Bulb", 4)
    for name, place, power, color in LAMPS:
        light = bpy.data.lights.new(name, "POINT")
        light.energy, light.color, light.shadow_soft_size = power, color, 0.0
        _add(scene, name, light).location = place
        above = place + Vector((0.0, 0.0, 0.25))
        glow = _glow(f"{name} Glow", color, 18.0)
        _only_seen(_ball(scene, f"{name} Bulb", bulb, glow, above, 0.22))
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.color, sun.angle = SUN_STRENGTH, (1.0, 0.95, 0.88), 0.0
    _add(scene, "Sun", sun).rotation_euler = (radians(38), radians(-30), 0.0)


def _panels(scene) -> None:
    """Windows to reflect, each turned to the middle of the floor."""
    glow = _glow("Panel Glow", (1.0, 0.97, 0.92), 1.6)
    for name, place, width, height in PANELS:
        x, y = width / 2, height / 2
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata([(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)], [], [(0, 1, 2, 3)])
        mesh.materials.append(glow)
        item = _add(scene, name, mesh)
        item.location = place
        item.rotation_euler = (-place).to_track_quat("Z", "Y").to_euler()
        _only_seen(item)


def _only_seen(item: bpy.types.Object) -> None:
    """Let an emitter be seen without lighting or shading anything: point lights do that."""
    item.visible_shadow = item.visible_diffuse = False


def _camera(scene) -> None:
    data = bpy.data.cameras.new("Camera")
    data.lens = LENS
    item = _add(scene, "Camera", data)
    look = Vector(TARGET) - Vector(CAMERA)
    item.location = CAMERA
    item.rotation_euler = look.to_track_quat("-Z", "Y").to_euler()
    scene.camera = item


def _world(scene) -> None:
    """One colour for the sky: seen by the camera, mirrors and glass, no light on diffuse things."""
    world = bpy.data.worlds.new("Sky")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    nodes = world.node_tree.nodes
    background = next((n for n in nodes if n.type == "BACKGROUND"), None)
    if background is None:
        background = nodes.new("ShaderNodeBackground")
        output = nodes.new("ShaderNodeOutputWorld")
        world.node_tree.links.new(background.outputs[0], output.inputs["Surface"])
    background.inputs["Color"].default_value = (*SKY, 1.0)
    background.inputs["Strength"].default_value = 1.0
    world.color = SKY
    scene.world = world
    if hasattr(world, "cycles_visibility"):
        world.cycles_visibility.diffuse = False
