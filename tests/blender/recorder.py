# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A stand-in for the native module that keeps what the exporter hands it, arguments checked."""

from types import SimpleNamespace

import numpy as np

CAMERA, SHADOW, REFLECTION, REFRACTION, ALL = 1, 2, 4, 8, 15


class Cancelled(Exception):
    """As the native module's."""


class Scene:
    """Keeps meshes, instances, materials, lights and world in plain lists."""

    def __init__(self) -> None:
        self.meshes: list[SimpleNamespace] = []
        self.instances: list[SimpleNamespace] = []

    def add_mesh(
        self,
        positions,
        triangles,
        normals=None,
        uvs=None,
        materials=None,
        *,
        corners=None,
        keep=False,
    ) -> int:
        if keep:
            given = (positions, triangles, normals, materials)
            assert not any(values.flags.writeable for values in given if values is not None)
        assert positions.dtype == np.float32 and positions.shape[1:] == (3,)
        assert triangles.dtype == np.uint32 and triangles.shape[1:] == (3,)
        if corners is not None:
            assert corners.dtype == np.uint32 and corners.ndim == 1
            if normals is not None:
                assert normals.shape == (len(corners), 3)
                normals = normals[triangles]
            triangles = corners[triangles]
        assert triangles.max() < len(positions)
        if normals is not None:
            assert normals.dtype == np.float32
            assert normals.shape in ((len(positions), 3), (len(triangles), 3, 3))
        if materials is None:
            materials = np.zeros(len(triangles), np.uint32)
        assert materials.dtype == np.uint32 and materials.shape == (len(triangles),)
        self.meshes.append(
            SimpleNamespace(
                positions=positions, triangles=triangles, normals=normals, materials=materials
            )
        )
        return len(self.meshes) - 1

    def add_instance(self, mesh, transform, object_id=0, visibility=ALL) -> int:
        assert np.linalg.det(transform) != 0
        self.instances.append(
            SimpleNamespace(mesh=mesh, matrix=transform, id=object_id, visibility=visibility)
        )
        return len(self.instances) - 1

    def set_materials(self, materials) -> None:
        self.materials = materials

    def set_lights(self, lights) -> None:
        self.lights = lights

    def set_world(self, color, ambient=(0, 0, 0)) -> None:
        self.world = SimpleNamespace(color=color, ambient=ambient)

    def placed(self, index: int) -> np.ndarray:
        """World positions (n, 3) of an instance's vertices."""
        instance = self.instances[index]
        points = self.meshes[instance.mesh].positions
        return points @ instance.matrix[:3, :3].T + instance.matrix[:3, 3]
