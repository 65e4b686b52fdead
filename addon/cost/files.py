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
from .measured import Measured
from .rows import KINDS, Row

VERSION = 1

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
)


def frame_dict(
    place: dict[str, Any],
    measured: Measured,
    rows: list[Row],
    values: dict[str, float],
) -> dict[str, Any]:
    """One view layer of one frame, not yet judged. `place`: scene, layer, frame and size."""
    tree = {
        name: value
        for name, value in measured.quality.items()
        if name not in ("instance", "material", "seconds")
    }
    return place | {
        "samples": measured.samples,
        "metrics": values,
        "tree": tree,
        "objects": [_row_dict(row) for row in rows if row.kind == "object"],
        "materials": [_row_dict(row) for row in rows if row.kind == "material"],
        "budgets": [],
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
            writer.writerow(_csv_row(frame, row))
    return text.getvalue()


def _csv_row(frame: dict[str, Any], row: dict[str, Any]) -> dict[str, Any]:
    return (
        row
        | {"frame": frame["frame"], "layer": frame["layer"], "shared": int(row["shared"])}
        | {f"nodes_{kind}": row["node_visits"][kind] for kind in KINDS}
        | {f"triangles_{kind}": row["triangle_tests"][kind] for kind in KINDS}
        | {"hints": "; ".join(hint["text"] for hint in row["hints"])}
    )
