# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lecture's packets once more, in numpy floats: what they share, and the lanes they take."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import counting
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Tests:
    """Tests of one node or triangle: by which rays of the packet they are made, in whole groups of
    lanes, and by which they are needed."""

    made: Sequence[int]
    needed: frozenset[int]

    def lanes(self, width: int) -> tuple[int, int]:
        """Lanes that vectors of a width take for them, and those that are needed."""
        groups = {ray // width for ray in self.made}
        return len(groups) * width, len(self.needed)


class Packet:
    """Rays that go down the tree together, as the lecture has it."""

    def __init__(
        self,
        nodes: NDArray,
        corners: NDArray,
        rays: list[counting.Ray],
        skips: Sequence[int] = (),
        any_hit: bool = False,
    ) -> None:
        """Ray i does not hit the triangle in row skips[i]; with any_hit its first hit ends it."""
        self.nodes, self.corners, self.rays = nodes, corners, rays
        self.skips, self.any_hit = skips or [-1] * len(rays), any_hit
        self.best = [ray.t_max for ray in rays]
        self.active = self.visited = 0
        self.node_tests: list[Tests] = []
        self.triangle_tests: list[Tests] = []

    def entering(self, index: int, first: int) -> list[int]:
        """The rays from `first` on that enter a node before their nearest hit."""
        node, found = self.nodes[index], []
        for i in range(first, len(self.rays)):
            near, far = counting.slab(self.rays[i], node["bounds_min"], node["bounds_max"])
            if max(near, self.rays[i].t_min) <= min(far, self.best[i]):
                found.append(i)
        return found

    def open(self, rays: Iterable[int]) -> frozenset[int]:
        """Those of the rays that still look for a hit."""
        return frozenset(i for i in rays if self.best[i] > self.rays[i].t_min)

    def walk(self) -> float:
        """The share of active rays."""
        everyone = range(len(self.rays))
        stack: list[tuple[int, int, Sequence[int]]] = [(0, 0, everyone)]
        while stack and self.open(everyone):
            index, first, asking = stack.pop()
            self.node_tests.append(Tests(everyone[first:], self.open(asking)))
            entering = self.entering(index, first)
            if not entering:
                continue
            self.active += len(entering)
            self.visited += len(self.rays)
            node = self.nodes[index]
            child, count = int(node["left_first"]), int(node["count"])
            if count:
                self.meet(range(child, child + count), entering)
                continue
            pair = self.nodes[child], self.nodes[child + 1]
            middles = [node["bounds_min"] + node["bounds_max"] for node in pair]
            along = (middles[1] - middles[0]) @ self.rays[entering[0]].direction
            near = child if along >= 0 else child + 1
            stack += [(row, entering[0], entering) for row in (2 * child + 1 - near, near)]
        return self.active / self.visited

    def meet(self, rows: range, entering: list[int]) -> None:
        """A leaf's triangles, with the rays that enter it."""
        for row in rows:
            needed = self.open(entering)
            self.triangle_tests.append(Tests(entering, needed))
            for i in needed:
                t = counting.hit_distance(self.rays[i], self.corners[row])
                if t is not None and t <= self.best[i] and row != self.skips[i]:
                    self.best[i] = -np.inf if self.any_hit else t


def from_probe(ray: dict[str, Any], stats: dict[str, Any]) -> counting.Ray:
    """A ray of Scene.probe in the space of the tree; `stats`: of its build."""
    scale = 2.0 ** stats["exponent"]
    return counting.make_ray(
        np.float32((ray["origin"] - stats["center"]) / scale),
        np.float32(ray["direction"] / scale),
        ray["t_min"],
        ray["t_max"],
    )


#: The sixteen pixels of a square in the order in which their rays are traced.
SQUARE = [(i & 1 | i >> 1 & 2, i >> 1 & 1 | i >> 2 & 2) for i in range(16)]
