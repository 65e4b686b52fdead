# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows of cost by object and by material."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .hints import Hint, hints_of
from .measured import Measured

KINDS = ("primary", "shadow", "reflection", "refraction")


@dataclass(frozen=True)
class Row:
    """What one object with all its instances, or one material, costs; or what several share.

    Shares are of the whole render, in [0, 1]. A number that was not measured is None.
    """

    kind: str  # "object" or "material"
    name: str  # in Blender; "": the material of slots without one
    shared: bool  # this row is the nodes that hold triangles of several
    instances: int
    triangles: int
    node_visits: dict[str, int]  # by kind of ray
    triangle_tests: dict[str, int]
    share: float  # of all visits and tests together
    node_share: float
    test_share: float
    memory: int  # bytes
    memory_share: float
    build_share: float  # of the build's time, judged by the share of triangles
    box_fill: float | None = None  # mean over its triangles; see whittle_part_quality
    slivers: int = 0
    stretch: float = 0.0  # of the surface of shared boxes, what is there for it alone
    overlap: float | None = None  # share of its surface in leaf boxes of others
    sah_cost: float | None = None  # of a tree of its own: of its instances, the mean
    stray_share: float | None = None  # of its own box's surface, the worst of its instances
    stray_triangles: int = 0  # that cause it
    triangles_per_pixel: float | None = None  # of the rectangle around it; None: not in the picture
    stretched_by: str = ""  # of the shared row: who makes those boxes large
    hints: tuple[Hint, ...] = ()

    @property
    def title(self) -> str:
        """What a table calls it."""
        return "shared" if self.shared else self.name or "(no material)"


def make_rows(measured: Measured) -> list[Row]:
    """Rows by object, then rows by material, each with its row of shared nodes, dearest first."""
    names, cost, quality = measured.names, measured.cost, measured.quality
    objects = _rows("object", names.objects, cost["instance"], quality, quality["instance"])
    objects = _with_pixels(objects, names.objects, measured.pixels)
    materials = _rows("material", names.materials, cost["material"], quality, quality["material"])
    return [_finished(row) for part in (objects, materials) for row in part]


def _finished(row: Row) -> Row:
    return replace(row, hints=hints_of(row)) if row.kind == "object" else row


class _Groups:
    """Numbers of parts (instances or materials) brought together by name."""

    def __init__(self, names: Sequence[str]) -> None:
        self.names = list(dict.fromkeys(names))
        place = {name: index for index, name in enumerate(self.names)}
        self.of_part = np.array([place[name] for name in names], dtype=np.intp)

    def sum(self, values: ArrayLike) -> NDArray[Any]:
        """Exact for integers; the last axis is that of the parts."""
        values = np.asarray(values)
        total = np.zeros((*values.shape[:-1], len(self.names)), dtype=values.dtype)
        np.add.at(total, (..., self.of_part), values)
        return total

    def mean(self, values: ArrayLike, weights: ArrayLike) -> NDArray[np.float64]:
        weight = self.sum(np.asarray(weights, dtype=np.float64))
        total = self.sum(np.asarray(values, dtype=np.float64) * weights)
        return np.divide(total, weight, out=np.zeros_like(total), where=weight > 0)

    def worst(self, values: NDArray[np.float64]) -> list[int]:
        """Of each group the part with the largest value."""
        order = np.argsort(values, kind="stable")
        worst = np.zeros(len(self.names), dtype=np.intp)
        worst[self.of_part[order]] = order
        return worst.tolist()


class _Whole:
    """What shares are shares of."""

    def __init__(self, visits: NDArray[Any], tests: NDArray[Any], quality: dict[str, Any]) -> None:
        self._visits, self._tests = int(visits.sum()), int(tests.sum())
        self._bytes, self._triangles = quality["bytes"], quality["triangles"]

    def work(self, visits: NDArray[Any], tests: NDArray[Any]) -> dict[str, Any]:
        """Of one row, from its counts by kind of ray (4,)."""
        nodes, triangles = int(visits.sum()), int(tests.sum())
        return {
            "node_visits": dict(zip(KINDS, visits.tolist(), strict=True)),
            "triangle_tests": dict(zip(KINDS, tests.tolist(), strict=True)),
            "share": _share(nodes + triangles, self._visits + self._tests),
            "node_share": _share(nodes, self._visits),
            "test_share": _share(triangles, self._tests),
        }

    def memory(self, bytes_: int) -> dict[str, Any]:
        return {"memory": bytes_, "memory_share": _share(bytes_, self._bytes)}

    def bytes_beside(self, rows: Sequence[Row]) -> int:
        return max(0, self._bytes - sum(row.memory for row in rows))

    def build_share(self, triangles: int) -> float:
        return _share(triangles, self._triangles)


def _rows(
    kind: str,
    names: Sequence[str],
    cost: dict[str, NDArray[np.uint64]],
    quality: dict[str, Any],
    part: dict[str, NDArray[Any]],
) -> list[Row]:
    """The rows of one kind, with the shared one, dearest first."""
    count = len(part["triangles"])
    if len(names) != count:
        raise ValueError(f"names holds {len(names)} {kind}s, but the render counted {count}")
    # By kind of ray and part; the last column is what was shared.
    visits, tests = np.asarray(cost["nodes"]), np.asarray(cost["triangles"])
    whole = _Whole(visits, tests, quality)
    groups = _Groups(names)
    rows = _own_rows(kind, groups, whole, (visits[:, :count], tests[:, :count]), part)
    rows.append(_shared_row(kind, rows, whole, (visits[:, count], tests[:, count])))
    return sorted(rows, key=lambda row: -row.share)


def _own_rows(
    kind: str,
    groups: _Groups,
    whole: _Whole,
    counts: tuple[NDArray[np.uint64], NDArray[np.uint64]],
    part: dict[str, NDArray[Any]],
) -> list[Row]:
    """The rows of what has a name; counts are visits and tests by kind of ray and part."""
    visits, tests = (groups.sum(values) for values in counts)
    summed = {name: groups.sum(part[name]) for name in ("triangles", "slivers", "bytes", "stretch")}
    columns = _qualities(groups, part)
    instances = np.bincount(groups.of_part, minlength=len(groups.names))
    return [
        Row(
            kind,
            name,
            shared=False,
            instances=int(instances[index]),
            triangles=int(summed["triangles"][index]),
            slivers=int(summed["slivers"][index]),
            stretch=float(summed["stretch"][index]),
            build_share=whole.build_share(summed["triangles"][index]),
            **whole.work(visits[:, index], tests[:, index]),
            **whole.memory(int(summed["bytes"][index])),
            **{key: values[index] for key, values in columns.items()},
        )
        for index, name in enumerate(groups.names)
    ]


def _shared_row(
    kind: str,
    rows: Sequence[Row],
    whole: _Whole,
    counts: tuple[NDArray[np.uint64], NDArray[np.uint64]],
) -> Row:
    """The row of the nodes that belong to none of the rows alone; counts are by kind of ray."""
    longest = max(rows, key=lambda row: row.stretch, default=None)
    return Row(
        kind,
        "",
        shared=True,
        instances=0,
        triangles=0,
        build_share=0.0,
        stretched_by=longest.name if longest is not None and longest.stretch > 0 else "",
        **whole.work(*counts),
        **whole.memory(whole.bytes_beside(rows)),
    )


def _share(part: float, whole: float) -> float:
    return float(part / whole) if whole else 0.0


def _qualities(groups: _Groups, part: dict[str, NDArray[Any]]) -> dict[str, list[Any]]:
    """Columns that are not sums; those of trees of their own only if they were built."""
    columns: dict[str, list[Any]] = {
        "box_fill": groups.mean(part["box_fill"], part["triangles"]).tolist()
    }
    if "sah_cost" in part:
        worst = groups.worst(part["stray_share"])
        columns |= {
            "sah_cost": groups.mean(part["sah_cost"], part["triangles"]).tolist(),
            "overlap": groups.mean(part["overlap"], part["area"]).tolist(),
            "stray_share": part["stray_share"][worst].tolist(),
            "stray_triangles": part["stray_triangles"][worst].tolist(),
        }
    return columns


def _with_pixels(rows: list[Row], names: Sequence[str], pixels: NDArray[np.float64]) -> list[Row]:
    """Adds how dense the triangles lie in the picture."""
    groups = _Groups(names)
    covered = dict(zip(groups.names, groups.sum(pixels).tolist(), strict=True))
    return [
        replace(row, triangles_per_pixel=row.triangles / covered[row.name])
        if not row.shared and covered[row.name] > 0
        else row
        for row in rows
    ]
