# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the triangles that the add-on exports, and their view, into one binary .ply file."""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import Any

import capture
import numpy as np
import studio
from numpy.typing import NDArray

FACE = np.dtype([("corners", "u1"), ("vertices", "<u4", 3)])


def placed(shot: capture.Shot) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """World-space vertices (n, 3) and triangles (m, 3) of all instances that all rays see.

    One mesh cannot hide a lamp's bulb from shadow rays alone: such instances are left out.
    """
    everything = shot.core.CAMERA | shot.core.SHADOW | shot.core.REFLECTION | shot.core.REFRACTION
    vertices, triangles, count = [], [], 0
    for (mesh, matrix), placed_as in shot.recording.instances:
        if placed_as["visibility"] != everything:
            continue
        data = shot.recording.meshes[mesh][1]
        points = data["positions"].astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        vertices.append(points.astype("<f4"))
        corners = data["triangles"]
        named = corners if data["corners"] is None else data["corners"][corners]
        triangles.append(named.astype(np.uint32) + np.uint32(count))
        count += len(points)
    if not triangles:
        raise ValueError("the scene shows no mesh to trace")
    return np.concatenate(vertices), np.concatenate(triangles)


def view_comments(camera: dict[str, Any], lights: list[dict[str, Any]]) -> list[str]:
    """The camera and the strongest point light, as comments that the benchmark reads."""
    matrix, projection = np.asarray(camera["to_world"]), np.asarray(camera["projection"])
    eye = matrix[:3, 3]
    fov = math.degrees(2 * math.atan(1 / projection[1][1]))
    numbers = [*eye, *(eye - matrix[:3, 2]), *matrix[:3, 1], fov]
    comments = ["comment camera: " + " ".join(f"{x:.9g}" for x in numbers)]
    points = [row for row in lights if row["kind"] == "point"]
    if points:
        light = max(points, key=lambda row: sum(row["intensity"]))
        comments.append("comment light: " + " ".join(f"{x:.9g}" for x in light["position"]))
    return comments


def write(path: Path, shot: capture.Shot) -> None:
    """The frame's triangles as a .ply file."""
    vertices, triangles = placed(shot)
    faces = np.empty(len(triangles), dtype=FACE)
    faces["corners"], faces["vertices"] = 3, triangles
    header = ["ply", "format binary_little_endian 1.0"]
    header += view_comments(shot.camera, shot.recording.lights)
    header += [f"element vertex {len(vertices)}", *(f"property float {axis}" for axis in "xyz")]
    header += [f"element face {len(faces)}", "property list uchar uint vertex_indices"]
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as file:
        file.write(("\n".join([*header, "end_header"]) + "\n").encode("ascii"))
        file.write(vertices.tobytes())
        file.write(faces.tobytes())


def main() -> int:
    """Exit codes: 0 written, 1 something went wrong and stderr says what."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path, help="the .ply file to write")
    parser.add_argument("--scene", type=Path, help="a .blend file; default: the demo scene")
    arguments = parser.parse_args()
    try:
        studio.register()
        write(arguments.out, capture.shot(studio.open_scene(arguments.scene)))
    except (RuntimeError, ValueError, OSError) as error:
        print(f"whittle: {str(error).strip()}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
