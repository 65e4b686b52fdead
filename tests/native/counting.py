# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The counted traversal once more, in numpy floats over Scene.nodes(): one ray at a time."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

PAD = np.float32(2.0**-20)
F = np.float32


@dataclass
class Ray:
    """A ray in scene space; a hit has t_min < t <= t_max."""

    origin: NDArray[np.float32]
    direction: NDArray[np.float32]
    inverse: NDArray[np.float32]
    t_min: np.float32 = F(0)
    t_max: np.float32 = F(np.inf)


def make_ray(origin: NDArray, direction: NDArray, t_min: float = 0, t_max: float = np.inf) -> Ray:
    with np.errstate(divide="ignore"):
        return Ray(origin, direction, F(1) / direction, F(t_min), F(t_max))


def slab(ray: Ray, low: NDArray, high: NDArray) -> tuple[np.float32, np.float32]:
    """The padded interval of t inside a box."""
    below, above = ray.origin - low, high - ray.origin
    room = np.maximum(below, above).max() * PAD
    to_low, to_high = F(0) - (below + room), above + room
    turned = ray.inverse < 0
    with np.errstate(invalid="ignore", over="ignore"):
        near = np.where(turned, to_high, to_low) * ray.inverse
        far = np.where(turned, to_low, to_high) * ray.inverse
    return np.nanmax(np.append(near, F(-np.inf))), np.nanmin(np.append(far, F(np.inf)))


def edge_functions(ray: Ray, corners: NDArray) -> tuple[NDArray, NDArray, int] | None:
    """(U, V, W), vertices from the origin and the dominant axis; None if the line misses."""
    z = int(np.argmax(np.abs(ray.direction)))
    x, y = (z + 1) % 3, (z + 2) % 3
    offset = corners - ray.origin
    shear = ray.direction[[x, y]] / ray.direction[z]
    px = offset[:, x] - shear[0] * offset[:, z]
    py = offset[:, y] - shear[1] * offset[:, z]
    a, b = [2, 0, 1], [1, 2, 0]
    edges = px[a] * py[b] - py[a] * px[b]
    if (edges == 0).any() and not ((edges < 0).any() and (edges > 0).any()):
        wide = px.astype(float)[a] * py.astype(float)[b] - py.astype(float)[a] * px.astype(float)[b]
        scale = np.exp2(-np.floor(np.log2(np.abs(wide).max()))) if wide.any() else 1.0
        edges = (wide * scale).astype(np.float32)
    if ((edges < 0).any() and (edges > 0).any()) or (edges[0] + edges[1]) + edges[2] == 0:
        return None
    return edges, offset, z


def hit_distance(ray: Ray, corners: NDArray) -> np.float32 | None:
    """t of one triangle by the exact test, or None."""
    met = edge_functions(ray, corners)
    if met is None:
        return None
    _, offset, z = met
    x, y = (z + 1) % 3, (z + 2) % 3
    wide = corners.astype(float)
    normal = np.cross(wide[1] - wide[0], wide[2] - wide[0])
    normal = (normal * np.exp2(-np.floor(np.log2(np.abs(normal).max())))).astype(np.float32)
    above = (normal[x] * offset[0, x] + normal[y] * offset[0, y]) + normal[z] * offset[0, z]
    shear = ray.direction[[x, y]] / ray.direction[z]
    along = (normal[x] * shear[0] + normal[y] * shear[1]) + normal[z]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = above / along * ray.inverse[z]
    near, far = slab(ray, corners.min(axis=0), corners.max(axis=0))
    if not near <= far:
        return None
    t = near if not t > near else t
    t = far if not t < far else t
    return t if t > ray.t_min else None


@dataclass
class Walk:
    """What a ray visited and tested, in order, and the nearest hit: row -1, t infinite if none."""

    nodes: list[int]
    triangles: list[int]
    t: np.float32 = F(np.inf)
    row: int = -1


def walk(nodes: NDArray, corners: NDArray, ray: Ray, skip: int = -1, any_hit: bool = False) -> Walk:
    """One ray through the tree; the triangle in row `skip` is not hit, `any_hit` stops at one."""
    found, best = Walk([], []), ray.t_max
    stack: list[tuple[int, np.float32]] = [(0, ray.t_min)] if len(nodes) else []
    while stack:
        index, entry = stack.pop()
        if entry > best:
            continue
        found.nodes.append(index)
        node = nodes[index]
        first, count = int(node["left_first"]), int(node["count"])
        for row in range(first, first + count):
            found.triangles.append(row)
            t = None if row == skip else hit_distance(ray, corners[row])
            if t is not None and (t < best or (found.row < 0 and t == best)):
                found.t, found.row, best = t, row, t
                if any_hit:
                    return found
        if count:
            continue
        entered = []
        for child in (first, first + 1):
            near, far = slab(ray, nodes[child]["bounds_min"], nodes[child]["bounds_max"])
            if near <= far and near <= best and far >= ray.t_min:
                entered.append((child, max(near, ray.t_min)))
        if len(entered) == 2 and entered[1][1] < entered[0][1]:
            entered.reverse()
        stack += reversed(entered)
    return found


def trace(nodes: NDArray, corners: NDArray, ray: Ray) -> tuple[int, int, np.float32]:
    """Nodes visited, triangles tested and t of the nearest hit (infinity: none)."""
    found = walk(nodes, corners, ray)
    return len(found.nodes), len(found.triangles), found.t


def owners(nodes: NDArray, labels: NDArray) -> NDArray[np.int64]:
    """For each node the label of all triangles under it, or -1; labels are in leaf order."""
    spans = np.zeros((len(nodes), 2), np.int64)

    def span(index: int) -> tuple[int, int]:
        first, count = int(nodes[index]["left_first"]), int(nodes[index]["count"])
        if count:
            spans[index] = first, first + count
        else:
            left, right = span(first), span(first + 1)
            spans[index] = min(left[0], right[0]), max(left[1], right[1])
        return tuple(spans[index])

    if len(nodes):
        span(0)
    low, high = (np.array([pick(labels[a:b]) for a, b in spans]) for pick in (np.min, np.max))
    return np.where(low == high, low, -1)


def node_depths(nodes: NDArray) -> NDArray[np.int64]:
    """Edges from the root, by node."""
    depths = np.zeros(len(nodes), np.int64)
    waiting = [0] if len(nodes) else []
    while waiting:
        index = waiting.pop()
        first = int(nodes[index]["left_first"])
        if not nodes[index]["count"]:
            depths[first : first + 2] = depths[index] + 1
            waiting += [first, first + 1]
    return depths
