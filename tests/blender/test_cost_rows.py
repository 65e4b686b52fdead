# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows of cost, their hints, budgets and files, from numbers made up here."""

import csv
import io
import json
import re
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from addon import cost
from addon.cost import files, metrics, pixels
from addon.results import Result

DOCS = Path(__file__).resolve().parents[2] / "docs"
COUNTERS = ["nodes", "nodes_shadow", "triangles", "triangles_primary"]


def part(count: int, seed: int, own_trees: bool = True) -> dict[str, np.ndarray]:
    """Qualities of as many parts, as Scene.quality gives them."""
    random = np.random.default_rng(seed)
    found = {
        "triangles": random.integers(10, 1000, count, dtype=np.uint64),
        "slivers": random.integers(0, 10, count, dtype=np.uint64),
        "bytes": random.integers(1000, 9000, count, dtype=np.uint64),
        "box_fill": random.uniform(0.3, 1, count),
        "area": random.uniform(1, 2, count),
        "stretch": random.uniform(0, 0.2, count),
    }
    if own_trees:
        found |= {
            "sah_cost": random.uniform(5, 50, count),
            "overlap": random.uniform(0, 0.2, count),
            "stray_share": random.uniform(0, 0.4, count),
            "stray_triangles": random.integers(0, 5, count, dtype=np.uint64),
        }
    return found


def counts(parts: int, seed: int) -> dict[str, np.ndarray]:
    random = np.random.default_rng(seed)
    found = {
        name: random.integers(0, 2**40, (4, parts + 1), dtype=np.uint64)
        for name in ("nodes", "triangles")
    }
    found["triangles"][:, -1] = 0
    return found


def measured(objects: list[str], materials: list[str], own_trees: bool = True) -> cost.Measured:
    instance = part(len(objects), 1, own_trees)
    material = part(len(materials), 2, own_trees=False)
    quality = {
        "triangles": int(instance["triangles"].sum()),
        "slivers": int(instance["slivers"].sum()),
        "bytes": int(instance["bytes"].sum() + material["bytes"].sum()),
        "sah_cost": 30.5,
        "box_fill": 0.5,
        "depth": 17,
        "depth_histogram": np.arange(18, dtype=np.uint64),
        "instance": instance,
        "material": material,
    }
    return cost.Measured(
        cost={"instance": counts(len(objects), 3), "material": counts(len(materials), 4)},
        quality=quality,
        names=cost.Names(objects, materials),
        pixels=np.full(len(objects), 1e6),
        samples=4,
    )


NAMES = ["Tree", "Floor", "Tree", "Rock", "Tree"]


def of(rows: list[cost.Row], name: str, kind: str = "object") -> cost.Row:
    (row,) = (row for row in rows if row.kind == kind and row.title == name)
    return row


def test_rows_add_up_to_the_whole():
    known = measured(NAMES, ["Bark", ""])
    rows = cost.make_rows(known)
    for kind, source in (("object", "instance"), ("material", "material")):
        mine = [row for row in rows if row.kind == kind]
        for index, ray in enumerate(cost.KINDS):
            total = int(known.cost[source]["nodes"][index].sum())
            assert sum(row.node_visits[ray] for row in mine) == total
            total = int(known.cost[source]["triangles"][index].sum())
            assert sum(row.triangle_tests[ray] for row in mine) == total
        assert sum(row.memory for row in mine) == known.quality["bytes"]
        for name in ("share", "node_share", "test_share", "memory_share"):
            assert sum(getattr(row, name) for row in mine) == pytest.approx(1), name
        assert [row.share for row in mine] == sorted((row.share for row in mine), reverse=True)
    assert sum(row.build_share for row in rows if row.kind == "object") == pytest.approx(1)


def test_instances_of_one_object_are_one_row():
    known = measured(NAMES, [""])
    rows = cost.make_rows(known)
    assert {row.title for row in rows if row.kind == "object"} == {
        "Tree",
        "Floor",
        "Rock",
        "shared",
    }
    tree, mine = of(rows, "Tree"), np.array([0, 2, 4])
    quality = known.quality["instance"]
    assert tree.instances == 3 and of(rows, "Floor").instances == 1
    assert tree.triangles == quality["triangles"][mine].sum()
    assert tree.node_visits["shadow"] == known.cost["instance"]["nodes"][1, mine].sum()
    weights = quality["triangles"][mine]
    assert tree.box_fill == pytest.approx(np.average(quality["box_fill"][mine], weights=weights))
    assert tree.sah_cost == pytest.approx(np.average(quality["sah_cost"][mine], weights=weights))
    overlap = np.average(quality["overlap"][mine], weights=quality["area"][mine])
    assert tree.overlap == pytest.approx(overlap)
    worst = mine[quality["stray_share"][mine].argmax()]
    assert tree.stray_share == quality["stray_share"][worst]
    assert tree.stray_triangles == quality["stray_triangles"][worst]
    assert tree.triangles_per_pixel == pytest.approx(tree.triangles / 3e6)


def test_the_shared_row_names_who_stretches_the_boxes():
    known = measured(NAMES, [""])
    known.quality["instance"]["stretch"][:] = [0.1, 0.25, 0.1, 0.05, 0.1]
    rows = cost.make_rows(known)
    shared = of(rows, "shared")
    assert shared.stretched_by == "Tree", "three instances together stretch more than the floor"
    assert shared.node_visits["primary"] == known.cost["instance"]["nodes"][0, -1]
    assert sum(shared.triangle_tests.values()) == 0 and shared.hints == ()
    known.quality["instance"]["stretch"][:] = 0
    assert of(cost.make_rows(known), "shared").stretched_by == ""


def test_what_was_not_measured_is_none():
    rows = cost.make_rows(measured(NAMES, [""], own_trees=False))
    floor = of(rows, "Floor")
    assert floor.sah_cost is floor.overlap is floor.stray_share is None
    material = of(rows, "(no material)", "material")
    assert material.sah_cost is None and material.box_fill > 0


def test_a_scene_without_work_has_shares_of_0():
    known = measured(["Cube"], [""])
    for table in known.cost.values():
        for values in table.values():
            values[:] = 0
    assert {row.share for row in cost.make_rows(known)} == {0.0}


def test_names_that_do_not_fit_the_counts_are_an_error():
    known = measured(NAMES, [""])
    broken = replace(known, names=cost.Names(NAMES[:-1], [""]))
    with pytest.raises(ValueError, match="holds 4 objects, but the render counted 5"):
        cost.make_rows(broken)


# ---- Hints ----

PLAIN = {
    "slivers": 0,
    "box_fill": 0.5,
    "stray_share": 0.1,
    "stretch": 0.1,
    "overlap": 0.1,
    "triangles_per_pixel": 0.5,
}
WORST = {
    "slivers": ({"slivers": 900, "box_fill": 0.01}, "90 % of its 1,000 triangles are slivers"),
    "stray": ({"stray_share": 0.97, "stray_triangles": 2}, "97 % .* 2 of its 1,000 triangles"),
    "stretch": ({"stretch": 0.4}, "40 % of the surface of shared boxes"),
    "overlap": ({"overlap": 0.6}, "60 % of its surface"),
    "dense": ({"triangles_per_pixel": 14.2}, "14.2 triangles for each pixel"),
}


@pytest.fixture
def row() -> cost.Row:
    one = of(cost.make_rows(measured(["Cube"], [""])), "Cube")
    return replace(one, triangles=1000, share=0.5, **PLAIN)


@pytest.mark.parametrize("kind", WORST)
def test_each_cause_has_its_hint_with_its_number(row, kind):
    change, text = WORST[kind]
    assert cost.hints.hints_of(row) == ()
    (hint,) = cost.hints.hints_of(replace(row, **change))
    assert hint.kind == kind and hint.mend
    assert re.search(text, hint.text)
    assert cost.hints.hints_of(replace(row, shared=True, **change)) == ()
    assert cost.hints.hints_of(replace(row, share=0.0, **change)) == ()


# ---- Pixels ----


def camera(width: int = 200, height: int = 100) -> dict:
    """10 above the origin, looking down; at the origin 10 pixels to a unit."""
    to_world = np.eye(4)
    to_world[2, 3] = 10
    projection = np.zeros((4, 4))
    projection[0, 0], projection[1, 1] = 1.0, 2.0
    projection[2, 2:] = -1.002, -0.2
    projection[3, 2] = -1
    return {"to_world": to_world, "projection": projection, "width": width, "height": height}


@pytest.mark.parametrize(
    "low, high, expected",
    [
        ((-1, -2, 0), (1, 2, 0), 20 * 40),
        ((-1, -1, 0), (1, 1, 5), 40 * 40),  # the nearer side is twice as large
        ((9, 0, 0), (11, 1, 0), 20 * 10),  # hangs over the edge
        ((20, 0, 0), (22, 1, 0), 0),  # beside the picture
        ((0, 0, 11), (1, 1, 12), 0),  # behind the camera
        ((-1, -1, 0), (1, 1, 20), 200 * 100),  # around the camera
    ],
)
def test_pixels_around_a_box(low, high, expected):
    assert pixels.covered(camera(), np.float64([low]), np.float64([high])) == pytest.approx(
        expected
    )


# ---- Budgets ----


def budget(text: str) -> cost.Budget:
    return cost.Budget.parse(text, COUNTERS)


@pytest.mark.parametrize(
    "text, metric, pattern, kind, relation, limit",
    [
        ("nodes_p95<=120", "nodes_p95", None, "object", "<=", 120),
        (" nodes_shadow_max < 1e3 ", "nodes_shadow_max", None, "object", "<", 1000),
        ("triangles(Tree.001)<=2e6", "triangles", "Tree.001", "object", "<=", 2e6),
        ("box_fill(Leaf (old) <= x)>=0.2", "box_fill", "Leaf (old) <= x", "object", ">=", 0.2),
        ("share(material:Glass) > .5", "share", "Glass", "material", ">", 0.5),
        ("overlap<=3", "overlap", None, "object", "<=", 3),
    ],
)
def test_budgets_that_can_be_read(text, metric, pattern, kind, relation, limit):
    read = budget(text)
    assert (read.metric, read.pattern, read.kind) == (metric, pattern, kind)
    assert (read.relation, read.limit) == (relation, limit)


@pytest.mark.parametrize(
    "text, says",
    [
        ("", "METRIC<=NUMBER"),
        ("nodes_p95", "METRIC<=NUMBER"),
        ("nodes_p95=120", "METRIC<=NUMBER"),
        ("nodes_p95==120", "METRIC<=NUMBER"),
        ("nodes_p95<=", "METRIC<=NUMBER"),
        ("nodes_p95<=many", "not a finite number"),
        ("nodes_p95<=nan", "not a finite number"),
        ("nodes_p95<=inf", "not a finite number"),
        ("node_p95<=120", "nodes_p95"),
        ("nodes_p97<=120", "nodes_p95"),
        ("nodes_refraction_p95<=1", "there is no"),
        ("nodes_p95(Tree)<=120", "of one object"),
        ("depth(Tree)<=12", "of one object"),
        ("share<=1", "of the whole render"),
    ],
)
def test_budgets_that_cannot_be_read_say_how_to_write_them(text, says):
    with pytest.raises(cost.BudgetError, match=says):
        budget(text)


@pytest.fixture
def render() -> tuple[dict[str, float], list[cost.Row]]:
    """The numbers of a render in which half of the pixels have 100 nodes a sample, half 300."""
    known = measured(NAMES, ["Bark", "Leaf"])
    work = known.cost["instance"]
    work["nodes"][:] = [10, 20, 30, 40, 50, 50]
    work["triangles"][:, :5] = [1, 2, 3, 90, 4]
    known.quality["instance"]["stretch"][:] = [0, 0.5, 0, 0, 0]
    known.quality["instance"]["triangles"][:] = [10, 20, 30, 40, 50]
    half = np.repeat(np.float32([400, 1200]), 50).reshape(10, 10)
    images = {"nodes": half, "nodes_shadow": half, "triangles": half, "triangles_primary": half}
    return metrics.scene_values(known, images, rays=777), cost.make_rows(known)


@pytest.mark.parametrize(
    "text, value, kept, name, part",
    [
        ("nodes_mean<=200", 200, True, "Tree", 0.45),
        ("nodes_mean<200", 200, False, "Tree", 0.45),
        ("nodes_p95<=120", 300, False, "Tree", 0.45),
        ("triangles_p50<=200", 200, True, "Rock", 0.9),
        ("triangles_primary_max<=1", 300, False, "Rock", 0.9),
        ("triangle_tests<=1", 400, False, "Rock", 0.9),
        ("node_visits<=800", 800, True, "Tree", 0.45),
        ("rays>=778", 777, False, "Rock", None),
        ("triangles(Tree)<=90", 90, True, "Tree", None),
        ("triangles(Tree)<=89", 90, False, "Tree", None),
        ("triangles(*o*)<=39", 40, False, "Rock", None),
        ("triangles(*o*)>=20", 20, True, "Floor", None),
        ("instances(Tree)<=2", 3, False, "Tree", None),
    ],
)
def test_verdicts_name_the_number_and_the_row(render, text, value, kept, name, part):
    verdict = budget(text).judge(*render)
    assert verdict.value == pytest.approx(value) and verdict.kept == kept
    assert verdict.row.title == name
    if part is not None:
        assert verdict.part == pytest.approx(part)
    sentence = verdict.sentence()
    assert text in sentence and name in sentence and f"{value:g}" in sentence
    assert ("broken" in sentence) == (not kept)


def test_a_shared_row_is_blamed_with_the_name_of_who_stretches_it(render):
    values, rows = render
    rows = [
        replace(row, node_visits=dict.fromkeys(cost.KINDS, 10_000)) if row.shared else row
        for row in rows
    ]
    verdict = budget("nodes_p95<=1").judge(values, rows)
    assert verdict.row.shared and "'Floor' stretches most" in verdict.sentence()


@pytest.mark.parametrize(
    "text, says",
    [
        ("triangles(Bush)<=1", "no object of this render is called 'Bush'"),
        ("triangles(material:Tree)<=1", "no material"),
        ("sah_cost(material:Bark)<=1", "not measured of a material"),
        ("overlap<=1", "does not measure overlap"),
    ],
)
def test_budgets_of_what_the_render_does_not_hold(render, text, says):
    with pytest.raises(cost.BudgetError, match=says):
        budget(text).judge(*render)


def test_the_help_names_every_metric():
    said = cost.budgets.help_text(COUNTERS)
    for name in [
        *metrics.ROW_METRICS,
        *metrics.SCENE_METRICS,
        *metrics.PIXEL_STATISTICS,
        *COUNTERS,
    ]:
        assert name in said, name


# ---- Files ----


@pytest.fixture
def result() -> Result:
    images = {name: np.full((4, 6), 8, np.float32) for name in COUNTERS}
    return Result(
        scene="Scene",
        layer="ViewLayer",
        frame=7,
        size=(6, 4),
        seconds={},
        build={},
        render={"rays": {"primary": 96}, "packets": 0},
        notes=[],
        counters=images,
        cost=measured(NAMES, ["Bark", ""]),
    )


def test_the_files_hold_every_row(result, tmp_path):
    from addon.cost.report import Report

    report = Report("/tree.blend", [budget("nodes_p95<=1"), budget("triangles(Tree)<=1e9")])
    verdicts = report.add(result)
    assert [verdict.kept for verdict in verdicts] == [False, True]
    report.add(replace(result, frame=8))
    paths = report.write(str(tmp_path))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["cost.csv", "cost.json"]
    document = json.loads(Path(paths[0]).read_text())
    assert (document["schema"], document["version"]) == ("whittle-cost", files.VERSION)
    frame, other = document["frames"]
    assert (frame["frame"], other["frame"], frame["samples"]) == (7, 8, 4)
    assert frame["metrics"]["nodes_p95"] == 2 and frame["metrics"]["rays"] == 96
    assert frame["tree"]["depth_histogram"] == list(range(18))
    rows = cost.make_rows(result.cost)
    assert [row["name"] for row in frame["objects"]] == [r.name for r in rows if r.kind == "object"]
    assert set(frame["objects"][0]) == {field.name for field in fields(cost.Row)}
    assert [(b["budget"], b["value"], b["kept"]) for b in frame["budgets"]] == [
        ("nodes_p95<=1", 2, False),
        ("triangles(Tree)<=1e9", of(rows, "Tree").triangles, True),
    ]
    lines = list(csv.DictReader(io.StringIO(Path(paths[1]).read_text())))
    assert len(lines) == 2 * len(rows)
    assert [line["name"] for line in lines[: len(rows)]] == [row.name for row in rows]
    assert int(lines[0]["nodes_shadow"]) == rows[0].node_visits["shadow"]
    assert {line["sah_cost"] for line in lines if line["kind"] == "material"} == {""}


PACKETS = {
    "packets": 3,
    "active_rays": 6,
    "visited_rays": 8,
    "lanes": 4,
    "node_lanes": 40,
    "node_lanes_used": 30,
    "triangle_lanes": 0,
    "triangle_lanes_used": 0,
    "decided_first": 5,
    "decided_frustum": 2,
    "decided_brute_force": 3,
}


def test_packets_are_told_of_where_they_were_counted(result, tmp_path):
    from addon.cost.report import Report

    report = Report("/tree.blend", [])
    report.add(result)
    report.add(replace(result, render=result.render | PACKETS))
    frames = json.loads(Path(report.write(str(tmp_path))[0]).read_text())["frames"]
    assert frames[0]["packets"] is None
    assert frames[1]["packets"] == {
        "packets": 3,
        "coherence": 0.75,
        "lanes": 4,
        "node_lane_use": 0.75,
        "triangle_lane_use": None,
        "decided": {"first": 0.5, "frustum": 0.2, "brute_force": 0.3},
    }
    page = (DOCS / "cost-files.md").read_text()
    assert all(f"`{name}`" in page for name in frames[1]["packets"])


def test_the_schema_is_written_down():
    page = (DOCS / "cost-files.md").read_text()
    for name in (*files.COLUMNS, *(field.name for field in fields(cost.Row))):
        assert f"`{name}`" in page, name
    for name in (*metrics.SCENE_METRICS, *metrics.ROW_METRICS, *metrics.PIXEL_STATISTICS):
        assert f"`{name}`" in page, name
    assert f"version {files.VERSION}" in page
