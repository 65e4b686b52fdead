# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene that is dear to trace for known reasons, each the fault of an object named after it."""

import bpy
import numpy as np

CULPRITS = ("Fan", "Firs", "Pines")
STRAY = "Rock"


def build(scene: bpy.types.Scene, slivers: int = 3_000, leaves: int = 1_500) -> None:
    """A fan of slivers, two forests that stand in each other, and a rock with one far triangle;
    beside them a floor and a ball, which are in order."""
    _add(scene, "Fan", _fan(slivers), (-2.2, 0, 0))
    _add(scene, "Firs", _forest(leaves, 1), (1.6, 0, 0))
    _add(scene, "Pines", _forest(leaves, 2), (1.7, 0.1, 0))
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.5, location=(0, 2.2, 0))
    bpy.context.object.name = "Ball"
    bpy.ops.mesh.primitive_plane_add(size=12, location=(0, 0, -1.2))
    bpy.context.object.name = "Floor"
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=0.5)
    rock = bpy.context.object
    corners = np.empty(3 * len(rock.data.vertices), np.float32)
    rock.data.vertices.foreach_get("co", corners)
    faces = [tuple(face.vertices) for face in rock.data.polygons]
    far = np.float32([[40, 30, 25], [40.2, 30, 25], [40, 30.2, 25]])
    points = np.concatenate([corners.reshape(-1, 3), far])
    last = len(points)
    bpy.data.objects.remove(rock)
    _add(scene, STRAY, (points, [*faces, (last - 3, last - 2, last - 1)]), (0, -2.2, 0))
    bpy.ops.object.light_add(type="POINT", location=(3, -2, 6))


def _add(scene: bpy.types.Scene, name: str, shape: tuple, place: tuple) -> None:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(p) for p in shape[0].tolist()], [], shape[1])
    ob = bpy.data.objects.new(name, mesh)
    ob.location = place
    scene.collection.objects.link(ob)


def _fan(count: int) -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """Slivers from one point to a half circle that leans towards all axes."""
    angle = np.linspace(0, np.pi, count + 1)
    rim = np.stack([np.cos(angle), np.sin(angle), 0.5 * np.cos(angle)], axis=1) * 1.4
    points = np.concatenate([[[0, -0.4, 0.3]], rim])
    return points, [(0, i, i + 1) for i in range(1, count + 1)]


def _forest(count: int, seed: int) -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """Leaves anywhere in one box."""
    random = np.random.default_rng(seed)
    middle = random.uniform(-1, 1, (count, 1, 3))
    corners = middle + random.normal(0, 0.12, (count, 3, 3))
    return corners.reshape(-1, 3), [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(count)]
