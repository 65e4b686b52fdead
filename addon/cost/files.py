# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""cost.json and cost.csv: their schema is in docs/cost-files.md."""

import csv
import io
import json
from dataclasses import asdict, fields
from typing import Any

import numpy as np

from .budgets import Verdict
from .compare import Change, CompareError, Side
from .hints import Hint
from .measured import Measured
from .rows import KINDS, Row

VERSION = 1

COMPARED = ("work", "node_visits", "triangle_tests", "triangles", "memory", "box_fill", "overlap")

COLUMNS = (
    "frame",
    "layer",
    "kind",
    "name",
    "shared",
    "instances",
    "triangles",
    *(f"nodes_{kind}" for kind in KINDS),
    *(f"triangles_{kind}" for kind in KINDS),
    "share",
    "node_share",
    "test_share",
    "memory",
    "memory_share",
    "build_share",
    "box_fill",
    "slivers",
    "stretch",
    "overlap",
    "sah_cost",
    "stray_share",
    "stray_triangles",
    "triangles_per_pixel",
    "stretched_by",
    "hints",
    "work_before",
    "work_difference",
)


def frame_dict(
    place: dict[str, Any],
    measured: Measured,
    rows: list[Row],
    values: dict[str, float],
    packets: dict[str, Any] | None,
) -> dict[str, Any]:
    """One view layer of one frame, not yet judged. `place`: scene, layer, frame and size;
    `packets`: as packets.shares gives them."""
    tree = {
        name: value
        for name, value in measured.quality.items()
        if name not in ("instance", "material", "seconds")
    }
    return place | {
        "samples": measured.samples,
        "metrics": values,
        "tree": tree,
        "packets": packets,
        "objects": [_row_dict(row) for row in rows if row.kind == "object"],
        "materials": [_row_dict(row) for row in rows if row.kind == "material"],
        "budgets": [],
        "baseline": None,
    }


def _row_dict(row: Row) -> dict[str, Any]:
    values = {field.name: getattr(row, field.name) for field in fields(row)}
    return values | {"hints": [asdict(hint) for hint in row.hints]}


def verdict_dict(verdict: Verdict) -> dict[str, Any]:
    """How a budget came out."""
    row = verdict.row
    return {
        "budget": verdict.budget.text,
        "value": verdict.value,
        "limit": verdict.budget.limit,
        "kept": verdict.kept,
        "kind": row.kind if row else None,
        "name": row.name if row else None,
        "shared": row.shared if row else None,
        "part": verdict.part,
    }


class Before:
    """A cost.json that was read again, to compare with."""

    def __init__(self, path: str) -> None:
        """CompareError if it cannot be read, or is none."""
        try:
            with open(path, encoding="utf-8") as file:
                document = json.load(file)
        except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
            raise CompareError(f"'{path}' cannot be read: {error}") from error
        schema = document.get("schema") if isinstance(document, dict) else None
        if schema != "whittle-cost" or document.get("version") != VERSION:
            raise CompareError(
                f"'{path}' is no cost.json of version {VERSION}: write one with whittle heatmap"
            )
        self.path = path
        try:
            self._sides = {(row["frame"], row["layer"]): _side(row) for row in document["frames"]}
        except (KeyError, TypeError) as error:
            raise CompareError(f"'{path}' lacks what a cost.json has: {error}") from error

    def of(self, frame: int, layer: str) -> tuple[int, Side]:
        """The view layer at this frame, or at the only one that there is; and which."""
        found = {f: side for (f, name), side in self._sides.items() if name == layer}
        if frame not in found and len(found) != 1:
            raise CompareError(f"'{self.path}' has no view layer '{layer}' at frame {frame}")
        return (frame, found[frame]) if frame in found else next(iter(found.items()))


def _side(frame: dict[str, Any]) -> Side:
    rows = [_row(row) for row in frame["objects"] + frame["materials"]]
    return Side(frame["layer"], tuple(frame["size"]), frame["samples"], rows)


def _row(values: dict[str, Any]) -> Row:
    """Names that a later version may have gained are left out."""
    known = {field.name: values[field.name] for field in fields(Row) if field.name in values}
    names = [field.name for field in fields(Hint)]
    hints = tuple(Hint(**{name: hint[name] for name in names}) for hint in values["hints"])
    return Row(**known | {"hints": hints})


def baseline_dict(before: Before, frame: int, changed: list[Change]) -> dict[str, Any]:
    """What has changed since; `frame`: that of the baseline."""
    return {"file": before.path, "frame": frame, "changes": [_change_dict(one) for one in changed]}


def _change_dict(change: Change) -> dict[str, Any]:
    row = change.row
    values = {"kind": row.kind, "name": row.name, "shared": row.shared}
    for metric in COMPARED:
        old, new = change.values(metric)
        values |= {
            f"{metric}_before": old,
            f"{metric}_now": new,
            f"{metric}_difference": change.difference(metric),
        }
    return values


def to_json(file: str, frames: list[dict[str, Any]]) -> str:
    """The document of all frames, a row of it on a line."""
    head = {"schema": "whittle-cost", "version": VERSION, "file": file}
    texts = ",\n".join(_frame_json(frame) for frame in frames)
    return f'{_json(head)[:-1]}, "frames": [\n{texts}\n]}}\n'


def _frame_json(frame: dict[str, Any]) -> str:
    parts = []
    for name, value in frame.items():
        rows = isinstance(value, list) and value and isinstance(value[0], dict)
        text = "[\n  {}\n ]".format(",\n  ".join(map(_json, value))) if rows else _json(value)
        parts.append(f" {_json(name)}: {text}")
    return "{\n" + ",\n".join(parts) + "\n}"


def _json(value: Any) -> str:
    return json.dumps(value, default=_plain, allow_nan=False)


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no place in cost.json")


def to_csv(frames: list[dict[str, Any]]) -> str:
    """A line for each row of each frame; a number that was not measured is empty."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    for frame in frames:
        for row in frame["objects"] + frame["materials"]:
            writer.writerow(_csv_row(frame, row) | _csv_change(frame, row))
    return text.getvalue()


def _csv_row(frame: dict[str, Any], row: dict[str, Any]) -> dict[str, Any]:
    return (
        row
        | {"frame": frame["frame"], "layer": frame["layer"], "shared": int(row["shared"])}
        | {f"nodes_{kind}": row["node_visits"][kind] for kind in KINDS}
        | {f"triangles_{kind}": row["triangle_tests"][kind] for kind in KINDS}
        | {"hints": "; ".join(hint["text"] for hint in row["hints"])}
    )


def _csv_change(frame: dict[str, Any], row: dict[str, Any]) -> dict[str, Any]:
    """Of a row that is as it was, the difference is 0."""
    if frame["baseline"] is None:
        return {}
    names = ("kind", "name", "shared")
    work = sum(row["node_visits"].values()) + sum(row["triangle_tests"].values())
    for change in frame["baseline"]["changes"]:
        if all(change[name] == row[name] for name in names):
            return {name: change[name] for name in ("work_before", "work_difference")}
    return {"work_before": work, "work_difference": 0}
