# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the demo scene, or a .blend file, as triangles in an OBJ file, its view beside it."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import bpy
import studio


def view(scene: bpy.types.Scene) -> dict[str, object]:
    """Camera matrices (row-major, as the core takes them), image size, point lights (m, W)."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    camera = scene.camera.evaluated_get(depsgraph)
    width, height = scene.render.resolution_x, scene.render.resolution_y
    projection = camera.calc_matrix_camera(depsgraph, x=width, y=height)
    lights = [item for item in scene.objects if item.type == "LIGHT" and item.data.type == "POINT"]
    return {
        "width": width,
        "height": height,
        "to_world": [list(row) for row in camera.matrix_world.normalized()],
        "projection": [list(row) for row in projection],
        "lights": [{"position": list(i.location), "power": i.data.energy} for i in lights],
    }


def main() -> None:
    """OUT.obj has world-space triangles; OUT.json has the camera and the point lights."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path, help="the .obj file to write")
    parser.add_argument("--scene", type=Path, help="a .blend file; default: the demo scene")
    arguments = parser.parse_args()
    scene = studio.open_scene(arguments.scene)
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    for item in scene.objects:  # one mesh cannot hide a lamp's bulb from shadow rays alone
        item.hide_render = item.hide_render or not item.visible_shadow
    bpy.ops.wm.obj_export(
        filepath=str(arguments.out.resolve()),
        export_eval_mode="DAG_EVAL_RENDER",
        export_triangulated_mesh=True,
        export_materials=False,
        export_normals=False,
        export_uv=False,
        forward_axis="Y",
        up_axis="Z",
    )
    arguments.out.with_suffix(".json").write_text(json.dumps(view(scene), indent=1) + "\n")


if __name__ == "__main__":
    main()
