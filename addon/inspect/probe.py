# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One pixel's rays: what each met on its way, as a tree in the order of their descent."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..export.meshes import Place
from .source import Shared

SHARED = "shared"
"""What nodes are charged to that hold triangles of several objects."""


@dataclass(frozen=True)
class Work:
    """What a ray did at one object."""

    name: str
    selects: str  # the object of the scene to select for it; "": none
    nodes: int
    triangles: int


@dataclass(frozen=True)
class Ray:
    """A ray from `start` to `end` (world space): its hit, its light, or far enough to be seen."""

    kind: str
    sample: int
    parent: int  # index among the rays of the probe; -1: the camera
    level: int  # how many rays lie between it and the camera
    start: NDArray[np.float64]
    end: NDArray[np.float64]
    distance: float  # to the hit, in world units; inf: it met nothing
    target: str  # the object that it hit; "": none
    material: str
    triangle: int  # of the object's mesh, as exported; -1: none
    light: int
    nodes: tuple[int, ...]
    triangles: NDArray[np.float32]  # (k, 3, 3) in world space
    work: tuple[Work, ...]  # by object, most first

    @property
    def hit(self) -> bool:
        return bool(np.isfinite(self.distance))


@dataclass(frozen=True)
class Probe:
    """All rays of a pixel, each after the one that it descends from."""

    pixel: tuple[int, int]  # from the lower left corner
    size: tuple[int, int]  # of the picture
    rays: tuple[Ray, ...]
    generation: int  # of the source

    def counts(self) -> dict[str, tuple[int, int, int]]:
        """By kind of ray: how many, the nodes that they visited, the triangles they tested."""
        totals: dict[str, list[int]] = {}
        for ray in self.rays:
            row = totals.setdefault(ray.kind, [0, 0, 0])
            for place, amount in enumerate((1, len(ray.nodes), len(ray.triangles))):
                row[place] += amount
        return {kind: tuple(row) for kind, row in totals.items()}


def take(
    source: Shared, camera: Mapping[str, Any], settings: Mapping[str, Any], pixel: tuple[int, int]
) -> Probe:
    """Traces one pixel of a picture as a render at these settings does, and keeps every step."""
    found = source.scene.probe(camera, settings, *pixel)
    world = _World(source)
    order, levels = _descent([row["parent"] for row in found])
    place_of = {index: place for place, index in enumerate(order)}
    rays = tuple(
        world.ray(found[index], place_of.get(found[index]["parent"], -1), level)
        for index, level in zip(order, levels, strict=True)
    )
    size = (int(camera["width"]), int(camera["height"]))
    return Probe(pixel, size, rays, source.generation)


def _descent(parents: list[int]) -> tuple[list[int], list[int]]:
    """The order in which each ray is followed by its descendants, and the level of each."""
    children: dict[int, list[int]] = {}
    for index, parent in enumerate(parents):
        children.setdefault(parent, []).append(index)
    order, levels = [], []
    waiting = [(index, 0) for index in reversed(children.get(-1, []))]
    while waiting:
        index, level = waiting.pop()
        order.append(index)
        levels.append(level)
        waiting += [(child, level + 1) for child in reversed(children.get(index, []))]
    return order, levels


class _World:
    """Turns the core's indices into names and world positions."""

    def __init__(self, source: Shared) -> None:
        self._source = source
        self._owner = source.scene.owners()["instance"]
        leaves = source.scene.triangles()
        self._vertices, self._instance = leaves["vertices"], leaves["instance"]
        self._center = np.array(source.build["center"])
        self._scale = np.ldexp(1.0, int(source.build["exponent"]))
        root = source.scene.nodes()[:1]
        size = root["bounds_max"].astype(np.float64) - root["bounds_min"]
        self._far = float(np.linalg.norm(size)) * self._scale

    def ray(self, row: Mapping[str, Any], parent: int, level: int) -> Ray:
        tested = np.asarray(row["triangles"], dtype=np.int64)
        nodes = np.asarray(row["nodes"], dtype=np.int64)
        material, instance = int(row["material"]), int(row["instance"])
        return Ray(
            kind=row["kind"],
            sample=int(row["sample"]),
            parent=parent,
            level=level,
            start=np.array(row["origin"]),
            end=self._end(row),
            distance=float(row["distance"]),
            target=label(self._source.places[instance]) if instance >= 0 else "",
            material=(self._source.materials[material] or "default") if material >= 0 else "",
            triangle=int(row["triangle"]),
            light=int(row["light"]),
            nodes=tuple(nodes.tolist()),
            triangles=self._placed(self._vertices[tested]),
            work=self._work(self._owner[nodes], self._instance[tested]),
        )

    def _end(self, row: Mapping[str, Any]) -> NDArray[np.float64]:
        """Where the ray is drawn to."""
        direction = np.array(row["direction"])
        reach = min(float(row["t"]), float(row["t_max"]))
        far = self._far / max(float(np.linalg.norm(direction)), 1e-300)
        bounded = np.isfinite(row["t"]) or row["kind"] == "shadow"
        return np.array(row["origin"]) + direction * (reach if bounded and reach < 1e9 else far)

    def _placed(self, vertices: NDArray[np.float32]) -> NDArray[np.float32]:
        return (self._center + self._scale * vertices.astype(np.float64)).astype(np.float32)

    def _work(self, owners: NDArray[np.integer], tested: NDArray[np.integer]) -> tuple[Work, ...]:
        nodes, triangles = self._by_place(owners), self._by_place(tested)
        rows = [
            Work(
                name=SHARED if place is None else label(place),
                selects="" if place is None else place.instancer or place.object,
                nodes=nodes[place],
                triangles=triangles[place],
            )
            for place in nodes | triangles
        ]
        return tuple(sorted(rows, key=lambda row: (-row.nodes - row.triangles, row.name)))

    def _by_place(self, indices: NDArray[np.integer]) -> Counter[Place | None]:
        totals: Counter[Place | None] = Counter()
        for index, count in zip(*np.unique(indices, return_counts=True), strict=True):
            totals[self._source.places[index] if index >= 0 else None] += int(count)
        return totals


def label(place: Place) -> str:
    """An object's name; of one that another placed, both."""
    return f"{place.object} ({place.instancer})" if place.instancer else place.object
