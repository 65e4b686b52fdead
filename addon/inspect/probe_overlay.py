# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The probed pixel: its rays as lines in the scene and as rows of a list."""

from typing import Any

import bpy
import numpy as np

from ..notes import plural
from . import draw, legend, source
from .probe import Probe, Ray

COLORS: dict[str, draw.Color] = {
    "primary": (1.0, 0.82, 0.2, 1.0),
    "shadow": (0.78, 0.78, 0.82, 1.0),
    "reflection": (0.3, 0.75, 1.0, 1.0),
    "refraction": (0.35, 1.0, 0.55, 1.0),
}
TESTED: draw.Color = (1.0, 0.35, 0.3, 0.25)
FAINT = 0.45  # opacity of the rays that are not chosen
LONGEST = 4096  # rows of the list

current: Probe | None = None
"""The pixel that was probed last."""

_key: Any = None
_batch: Any = None


def show(probe: Probe | None) -> None:
    """Makes a probe the current one, and fills the list."""
    global current
    current = probe
    session = bpy.context.window_manager.whittle
    session.show_probe = probe is not None
    session.rays.clear()
    for ray in probe.rays[:LONGEST] if probe is not None else ():
        row = session.rays.add()
        row.name, row.kind, row.level = summary(ray), ray.kind, ray.level
        row.nodes, row.triangles = len(ray.nodes), len(ray.triangles)
    session.ray_index = 0


def summary(ray: Ray) -> str:
    """A ray in a few words: its kind, and what it met."""
    if ray.kind == "shadow":
        return f"Shadow: by {ray.target}" if ray.hit else "Shadow: lit"
    return f"{ray.kind.title()}: {ray.target or 'nothing'}"


def chosen(context: bpy.types.Context) -> Ray | None:
    """The ray that is active in the list."""
    index = context.window_manager.whittle.ray_index
    if current is None or not 0 <= index < len(current.rays):
        return None
    return current.rays[index]


def visited(context: bpy.types.Context) -> tuple[int, ...]:
    """The nodes that the active ray visited, if they are nodes of the tree at hand."""
    ray = chosen(context)
    if ray is None or current.generation != source.shared.generation:
        return ()
    return tuple(sorted(set(ray.nodes)))


def paint(context: bpy.types.Context) -> None:
    """Draws the rays, the active one thicker and with the triangles that it tested."""
    global _key, _batch
    active = chosen(context)
    if active is None:
        return
    settings = context.scene.whittle_overlay
    key = (id(current), context.window_manager.whittle.ray_index, settings.probe_all)
    if key != _key:
        others = [ray for ray in current.rays if ray is not active] if settings.probe_all else []
        _batch = (_lines(others, FAINT), _lines([active], 1.0))
        _key = key
    if settings.probe_triangles and len(active.triangles):
        draw.triangles(active.triangles, TESTED)
    if _batch[0] is not None:
        draw.lines(_batch[0], 1.5)
    draw.lines(_batch[1], 3.5)


def _lines(rays: list[Ray], opacity: float) -> Any:
    if not rays:
        return None
    points = np.array([(ray.start, ray.end) for ray in rays], dtype=np.float32)
    colors = np.array([COLORS[ray.kind] for ray in rays], dtype=np.float32)
    colors[:, 3] = opacity
    return draw.line_batch(points.reshape(-1, 3), np.repeat(colors, 2, axis=0), wide=True)


def explain(context: bpy.types.Context) -> legend.Legend | None:
    """The probe's totals, and the colours of the rays."""
    if current is None:
        return None
    counts = current.counts()
    nodes, triangles = (sum(row[place] for row in counts.values()) for place in (1, 2))
    old = current.generation != source.shared.generation or source.shared.stale
    return legend.Legend(
        title="Pixel {}, {}: {}".format(*current.pixel, plural(len(current.rays), "ray")),
        lines=(f"{nodes:,} nodes visited, {triangles:,} triangles tested",),
        warning="The scene has changed since: probe again" if old else "",
        keys=tuple((f"{row[0]} {kind}", COLORS[kind]) for kind, row in counts.items()),
    )


def forget() -> None:
    """Lets go of the probe; the list is the session's."""
    global current, _key, _batch
    current = _key = _batch = None
