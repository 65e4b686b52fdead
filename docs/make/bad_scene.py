# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene that is dear to trace for known reasons, each the fault of an object; and its mend."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

import bpy
import numpy as np

Shape = tuple[np.ndarray, list[tuple[int, ...]]]

PARASOL, PINE, FIR, ROCK, BALL, FLOOR = "Parasol", "Pine", "Fir", "Rock", "Ball", "Floor"


@dataclass(frozen=True)
class Size:
    """How large the faults are."""

    slivers: int = 200_000
    trees: int = 60  # of each kind
    layers: int = 20  # of twigs on a tree


def build(scene: bpy.types.Scene, size: Size, mended: bool = False) -> None:
    """A parasol that is one fan of slivers, two kinds of trees planted in each other, and a rock
    that has lost a triangle far away; a floor and a ball are in order. Mended, it looks the same
    but for the trees, which stand apart."""
    _add(scene, PARASOL, _cone(96, 40) if mended else _cone(size.slivers, 1), (-2.7, 0.6, 2.2))
    bpy.data.objects[PARASOL].rotation_euler = (radians(24), radians(-30), 0)
    places = _apart(2 * size.trees) if mended else _anywhere(2 * size.trees)
    _grove(scene, PINE, _tree(size.layers, 1), places[::2])
    _grove(scene, FIR, _tree(size.layers, 2), places[1::2])
    _add(scene, ROCK, _rock(stray=not mended), (-0.4, -2.6, 0.45))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, location=(-2.4, -2.9, 0.6))
    ball = bpy.context.object
    ball.name, ball.scale = BALL, (0.6, 0.6, 0.6)
    bpy.ops.object.shade_smooth()
    bpy.ops.mesh.primitive_plane_add(size=30)
    bpy.context.object.name = FLOOR
    _colours()
    _view(scene)


def _add(scene: bpy.types.Scene, name: str, shape: Shape, place: tuple) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(point) for point in shape[0].tolist()], [], shape[1])
    ob = bpy.data.objects.new(name, mesh)
    ob.location = place
    scene.collection.objects.link(ob)
    return ob


def _cone(sides: int, rings: int) -> Shape:
    """A shallow cone: with one ring a fan of slivers, with more of them quads below its tip."""
    angle = np.arange(sides) * 2 * np.pi / sides
    circle = np.stack([1.9 * np.cos(angle), 1.9 * np.sin(angle), np.full(sides, -0.8)], axis=1)
    points = np.concatenate([[[0, 0, 0]], *(circle * (k + 1) / rings for k in range(rings))])
    at = np.arange(sides)
    after = (at + 1) % sides
    faces = [(0, 1 + int(i), 1 + int(j)) for i, j in zip(at, after, strict=True)]
    for k in range(rings - 1):
        inner, outer = 1 + k * sides, 1 + (k + 1) * sides
        quads = np.stack([inner + at, outer + at, outer + after, inner + after], axis=1)
        faces += [tuple(quad) for quad in quads.tolist()]
    return points, faces


def _tree(layers: int, seed: int) -> Shape:
    """Twigs: triangles that hang outwards around a stem, shorter towards the top."""
    random = np.random.default_rng(seed)
    count = 14 * layers
    angle = random.uniform(0, 2 * np.pi, count)
    height = random.uniform(0.15, 1.0, count)
    reach = 0.55 * (1.05 - height)
    out = np.stack([np.cos(angle), np.sin(angle), np.full(count, -0.35)], axis=1)
    side = np.stack([-np.sin(angle), np.cos(angle), np.zeros(count)], axis=1)
    stem = np.stack([np.zeros(count), np.zeros(count), 1.9 * height], axis=1)
    tip = stem + out * reach[:, None]
    corners = np.stack([stem, tip + 0.09 * side, tip - 0.09 * side], axis=1)
    return corners.reshape(-1, 3), [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(count)]


def _anywhere(count: int) -> np.ndarray:
    """Places in a clearing that is far too small for so many trees."""
    spread = np.random.default_rng(5).uniform(-1, 1, (count, 2)) * (1.7, 1.6)
    return spread + (2.6, 1.0)


def _apart(count: int) -> np.ndarray:
    """Rows of places, from the clearing backwards, as far apart as the trees are wide."""
    index = np.arange(count)
    row = index // 7
    grid = np.stack([0.9 + 1.2 * (index % 7) + 0.5 * (row % 2), 1.25 * row], axis=1)
    return grid + np.random.default_rng(6).uniform(-0.1, 0.1, (count, 2))


def _grove(scene: bpy.types.Scene, name: str, shape: Shape, places: np.ndarray) -> None:
    """Instances of one tree, wherever an empty stands."""
    collection = bpy.data.collections.new(name)
    tree = _add(scene, name, shape, (0, 0, 0))
    scene.collection.objects.unlink(tree)
    collection.objects.link(tree)
    for index, (x, y) in enumerate(places):
        empty = bpy.data.objects.new(f"{name} Place", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        empty.location, empty.rotation_euler = (x, y, 0), (0, 0, 2.4 * index)
        scene.collection.objects.link(empty)


def _rock(stray: bool) -> Shape:
    """A boulder, and a triangle that was forgotten far above it."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=0.6)
    ball = bpy.context.object
    points = np.empty(3 * len(ball.data.vertices), np.float32)
    ball.data.vertices.foreach_get("co", points)
    faces = [tuple(face.vertices) for face in ball.data.polygons]
    bpy.data.objects.remove(ball)
    points = points.reshape(-1, 3) * (1, 0.9, 0.75)
    wave = 0.05 * np.sin(7 * points[:, :1]) * np.cos(9 * points[:, 1:2])
    points = points * (1 + wave)
    if stray:
        last = len(points)
        points = np.concatenate([points, [[40, 30, 60], [40.2, 30, 60], [40, 30.2, 60]]])
        faces.append((last, last + 1, last + 2))
    return points, faces


def _colours() -> None:
    """A diffuse material for each object, by its name; the ball is a mirror."""
    for name, color in (
        (PARASOL, (0.72, 0.16, 0.10)),
        (PINE, (0.05, 0.22, 0.09)),
        (FIR, (0.20, 0.32, 0.06)),
        (ROCK, (0.34, 0.32, 0.30)),
        (BALL, (0.85, 0.87, 0.9)),
        (FLOOR, (0.55, 0.50, 0.42)),
    ):
        material = bpy.data.materials.new(name)
        if bpy.app.version < (5, 0, 0):
            material.use_nodes = True
        shader = material.node_tree.nodes["Principled BSDF"]
        shader.inputs["Base Color"].default_value = (*color, 1.0)
        shader.inputs["Specular IOR Level"].default_value = 0.0
        if name == BALL:
            shader.inputs["Metallic"].default_value = 1.0
            shader.inputs["Roughness"].default_value = 0.0
        bpy.data.objects[name].data.materials.append(material)


def _view(scene: bpy.types.Scene) -> None:
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.4, -12.0, 5.6), (radians(68), 0, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    bpy.ops.object.light_add(type="SUN", rotation=(radians(38), radians(24), 0))
    bpy.context.object.data.energy = 2.4
    world = bpy.data.worlds.new("World")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.30, 0.40, 0.55, 1.0)
    scene.world = world
    scene.view_settings.view_transform = "Standard"
