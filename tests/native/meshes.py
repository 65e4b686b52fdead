# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that the tests share: positions float32 (n, 3) and triangles uint32 (m, 3)."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Mesh = tuple[NDArray[np.float32], NDArray[np.uint32]]

SHARED = Path(__file__).parents[3] / "shared" / "scenes"


def pack(positions: NDArray, triangles: NDArray) -> Mesh:
    """The arrays in the types that `add_mesh` reads."""
    return (
        np.ascontiguousarray(positions, np.float32).reshape(-1, 3),
        np.ascontiguousarray(triangles, np.uint32).reshape(-1, 3),
    )


def join(*meshes: Mesh) -> Mesh:
    """All meshes as one."""
    offsets = np.cumsum([0] + [len(p) for p, _ in meshes[:-1]])
    triangles = [t + np.uint32(offset) for (_, t), offset in zip(meshes, offsets, strict=True)]
    return pack(np.concatenate([p for p, _ in meshes]), np.concatenate(triangles))


def soup(corners: NDArray) -> Mesh:
    """Triangles (m, 3, 3) that share no vertices."""
    return pack(corners, np.arange(corners.size // 3))


def corners(mesh: Mesh) -> NDArray[np.float32]:
    """Vertices of each triangle, (m, 3, 3)."""
    positions, triangles = mesh
    return positions[triangles]


def icosphere(divisions: int = 3, radius: float = 1.0, center=(0.0, 0.0, 0.0)) -> Mesh:
    """A closed sphere of 20 * 4^divisions triangles with shared vertices, rounded to float last."""
    phi = (1 + 5**0.5) / 2
    points = [(s, t * phi, 0) for t in (-1, 1) for s in (-1, 1)]
    points = np.array(
        points + [(0, a, b) for a, b, _ in points] + [(b, 0, a) for a, b, _ in points]
    )
    length = np.linalg.norm(points[:, None] - points[None], axis=2)
    near = (length > 0) & (length < 2.1)
    faces = [
        (a, b, c)
        for a in range(12)
        for b in range(a + 1, 12)
        for c in range(b + 1, 12)
        if near[a, b] and near[b, c] and near[a, c]
    ]
    points = list(points / np.linalg.norm(points[0]))
    faces = [
        f if np.dot(np.cross(points[f[1]], points[f[2]]), points[f[0]]) > 0 else (f[0], f[2], f[1])
        for f in faces
    ]
    for _ in range(divisions):
        middle: dict[tuple[int, int], int] = {}
        halves = []
        for a, b, c in faces:
            ids = []
            for p, q in ((a, b), (b, c), (c, a)):
                key = (min(p, q), max(p, q))
                if key not in middle:
                    point = points[p] + points[q]
                    middle[key] = len(points)
                    points.append(point / np.linalg.norm(point))
                ids.append(middle[key])
            halves += [(a, ids[0], ids[2]), (b, ids[1], ids[0]), (c, ids[2], ids[1]), tuple(ids)]
        faces = halves
    return pack(np.array(points) * radius + np.array(center), np.array(faces))


def torus(around: int = 48, across: int = 20, minor: float = 0.35) -> Mesh:
    """A closed ring about z: 2 * around * across triangles."""
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    a, b = 2 * np.pi * u / around, 2 * np.pi * v / across
    ring = 1 + minor * np.cos(b)
    positions = np.stack([ring * np.cos(a), ring * np.sin(a), minor * np.sin(b)], axis=-1)

    def vertex(i: NDArray, j: NDArray) -> NDArray:
        return (i % around) * across + j % across

    quads = [vertex(u, v), vertex(u + 1, v), vertex(u + 1, v + 1), vertex(u, v + 1)]
    p, q, r, s = (corner.ravel() for corner in quads)
    return pack(positions, np.stack([p, q, r, p, r, s], axis=1))


def box(low, high) -> Mesh:
    """A closed axis-aligned box of 12 triangles."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    corner = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)])
    quads = np.array(
        [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    )
    return pack(low + corner * (high - low), np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]]))


def boxes(count: int = 60, seed: int = 60) -> Mesh:
    """Axis-aligned boxes that stand in and on each other."""
    random = np.random.default_rng(seed)
    low = random.uniform(-1, 0.7, (count, 3))
    size = random.uniform(0.05, 0.6, (count, 3))
    return join(*(box(a, a + b) for a, b in zip(low, size, strict=True)))


def random_triangles(count: int, size: float, seed: int) -> Mesh:
    """Triangles of about one size, anywhere in the cube of side 2."""
    random = np.random.default_rng(seed)
    middle = random.uniform(-1, 1, (count, 1, 3))
    return soup(middle + random.normal(0, size, (count, 3, 3)))


def needles(count: int, length: float, width: float, seed: int) -> Mesh:
    """Thin triangles at random places and angles."""
    random = np.random.default_rng(seed)
    axis = random.normal(size=(count, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    side = np.cross(axis, random.normal(size=(count, 3)))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    foot = random.uniform(-1, 1, (count, 3)) - 0.5 * length * axis
    tip = foot + length * axis
    return soup(np.stack([foot, foot + width * side, tip], axis=1))


def needle_fan(count: int = 400, width: float = 1e-6) -> Mesh:
    """Needles that meet at one point, crossing each other's boxes at grazing angles."""
    angle = np.linspace(0, np.pi, count, endpoint=False)
    lift = np.linspace(-0.3, 0.3, count)
    tip = np.stack([np.cos(angle), np.sin(angle), lift], axis=1)
    side = width * np.stack([-np.sin(angle), np.cos(angle), 0 * angle], axis=1)
    return soup(np.stack([-tip, tip, tip + side], axis=1))


def coplanar_duplicates(copies: int = 3, cells: int = 12) -> Mesh:
    """One flat grid several times over, in another order of triangles each time."""
    random = np.random.default_rng(27)
    i, j = np.meshgrid(np.arange(cells), np.arange(cells), indexing="ij")
    a = (i * (cells + 1) + j).ravel()
    quad = np.stack([a, a + cells + 1, a + cells + 2, a, a + cells + 2, a + 1], axis=1).reshape(
        -1, 3
    )
    x, y = np.meshgrid(*[np.linspace(-1, 1, cells + 1)] * 2, indexing="ij")
    plane = np.stack([x, y, 0.25 * x + 0.5 * y], axis=-1)
    return join(*(pack(plane, random.permutation(quad)) for _ in range(copies)))


def terrain(cells: int) -> Mesh:
    """A hilly square of 2 * cells^2 triangles."""
    x, y = np.meshgrid(np.linspace(0, 9, cells + 1), np.linspace(0, 9, cells + 1), indexing="ij")
    z = np.sin(x) * np.cos(1.3 * y) + 0.1 * np.sin(17 * x + 11 * y)
    corner = np.arange(cells * (cells + 1)).reshape(cells, cells + 1)[:, :-1].ravel()
    right, up = corner + cells + 1, corner + 1
    triangles = np.stack([corner, right, right + 1, corner, right + 1, up], axis=1)
    return pack(np.stack([x, y, z], axis=-1), triangles)


def concentric(count: int) -> Mesh:
    """Triangles around the same point, one inside another."""
    one = np.array([[[-1, -1, 0.1], [1, -1, 0.2], [0, 1, -0.3]]])
    pair = np.concatenate([one, -one])
    return soup((pair * np.linspace(1, 3, count // 2)[:, None, None, None]).reshape(-1, 3, 3))


def geometric(copies: int = 1) -> Mesh:
    """A row of triangles each twice as large and as far as the one before, 120 sizes of them."""
    size = np.repeat(2.0 ** np.arange(-60, 60), copies)[:, None, None]
    one = np.array([[1, 0, 0], [1.3, 0.5, 0], [1.3, 0, 0.5]])
    return soup(one * size)


def nested(count: int = 250) -> Mesh:
    """Triangles that share a corner, each a third larger than the one before."""
    one = np.array([[0, 0, 0], [1, 0.1, 0], [0.1, 1, 0.3]])
    return soup(one * 2.0 ** (0.4 * np.arange(count))[:, None, None])


def transform(scale: float = 1.0, offset=(0.0, 0.0, 0.0)) -> NDArray[np.float64]:
    """Uniform scale, then translation."""
    matrix = np.diag([scale, scale, scale, 1.0])
    matrix[:3, 3] = offset
    return matrix


def load_obj(path: Path) -> Mesh:
    """Positions and polygons (as fans) of a Wavefront file."""
    positions, triangles = [], []
    for line in path.read_text().splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            positions.append([float(x) for x in rest[:3]])
        elif word == "f":
            ids = [int(x.split("/")[0]) for x in rest]
            ids = [i - 1 if i > 0 else len(positions) + i for i in ids]
            triangles += [(ids[0], ids[k], ids[k + 1]) for k in range(1, len(ids) - 1)]
    return pack(np.array(positions), np.array(triangles))


def shared(name: str) -> Mesh | None:
    """A mesh of the folder of measuring models beside the checkout, or None without it."""
    path = SHARED / f"{name}.obj"
    return load_obj(path) if path.exists() else None
