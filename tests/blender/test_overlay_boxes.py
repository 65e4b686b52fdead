# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The boxes of the BVH: the tree in the world, which are chosen, colours and edges."""

import bpy
import numpy as np
import pytest
from viewing import ready


def walk(nodes):
    """Each node with its depth, its box and its triangles, by plain recursion."""
    found, waiting = {}, [(0, 0)]
    while waiting:
        index, depth = waiting.pop()
        row = nodes[index]
        found[index] = (depth, row["bounds_min"], row["bounds_max"], int(row["count"]))
        if row["count"] == 0:
            waiting += [(int(row["left_first"]) + side, depth + 1) for side in (0, 1)]
    return found


@pytest.fixture
def grown(stage):
    from addon.inspect import tree

    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, location=(3, 0, 0))
    ready(stage)
    return tree.read(stage.scene, stage.build)


def test_the_tree_in_the_world(stage, grown):
    from addon.inspect import tree

    nodes = stage.scene.nodes()
    found = walk(nodes)
    assert sorted(found) == list(range(len(nodes)))
    scale, center = 2.0 ** stage.build["exponent"], np.array(stage.build["center"])
    for index, (depth, low, high, count) in found.items():
        assert (grown.depth[index], grown.count[index]) == (depth, count)
        corners = tree.corners(grown, np.array([index]))[0]
        assert np.allclose(corners.min(axis=0), center + scale * low)
        assert np.allclose(corners.max(axis=0), center + scale * high)
    assert grown.deepest == stage.build["depth"]
    assert np.isclose(grown.cost.sum(), stage.build["sah_cost"])
    root = tree.corners(grown, np.array([0]))[0]
    assert np.allclose(root.min(axis=0), (-4, -4, -2)) and np.allclose(root.max(axis=0), (4, 4, 1))


def test_boxes_are_chosen_as_asked(stage, grown):
    from addon.inspect import boxes

    found = walk(stage.scene.nodes())

    def chosen(**asked):
        return set(boxes.choose(grown, boxes.Filter(**asked)).chosen.tolist())

    assert chosen() == set(found)
    assert chosen(depth=(2, 4)) == {i for i, row in found.items() if 2 <= row[0] <= 4}
    leaves = {i for i, row in found.items() if row[3]}
    assert chosen(leaves=True) == chosen(color="LEAF") == leaves
    assert chosen(nodes=(0, 2, 5)) == {0, 2, 5}
    assert chosen(nodes=()) == chosen(depth=(5, 4)) == chosen(instances=frozenset()) == set()
    owners = stage.scene.owners()["instance"]
    sphere = boxes.instances_of(stage.places, {"Icosphere"})
    assert len(sphere) == 1
    assert chosen(instances=sphere) == set(np.flatnonzero(owners == min(sphere)).tolist())


def test_beyond_the_limit_boxes_near_the_root_are_drawn_and_it_is_said(grown):
    from addon.inspect import boxes

    made = boxes.choose(grown, boxes.Filter(limit=10))
    assert len(made.chosen) == 10 and made.asked == len(grown.depth)
    order = np.argsort(grown.depth, kind="stable")
    assert made.chosen.tolist() == sorted(order[:10].tolist())
    assert f"10 of {made.asked:,} boxes" in boxes.caption(made)
    assert boxes.caption(boxes.choose(grown, boxes.Filter(nodes=(0,)))) == "1 box"


@pytest.mark.parametrize("color", ["DEPTH", "COST", "LEAF"])
def test_box_colours_rise_with_what_they_stand_for(grown, color):
    from addon.inspect import boxes

    made = boxes.choose(grown, boxes.Filter(color=color))
    value = {"DEPTH": grown.depth, "COST": grown.cost, "LEAF": grown.count}[color][made.chosen]
    assert made.shade.min() >= 0 and made.shade.max() == 1 and np.ptp(made.shade) > 0.5
    order = np.argsort(value, kind="stable")
    assert (np.diff(made.shade[order]) >= 0).all()
    assert np.isclose(made.span[1], min(value.max(), 64))
    assert boxes.colors(made, "VIRIDIS", 0.5).shape == (8 * len(made.chosen), 4)


def test_each_box_has_its_twelve_edges(grown):
    from addon.inspect import tree

    solid = np.flatnonzero((grown.high > grown.low).all(axis=1))[[0, 3]]
    corners = tree.corners(grown, solid).reshape(-1, 3)
    pairs = tree.edges(2)
    assert pairs.shape == (24, 2) and len(corners) == 16
    for index, node in enumerate(solid):
        mine = corners[pairs[12 * index : 12 * index + 12]]
        along = abs(mine[:, 0] - mine[:, 1])
        assert ((along > 0).sum(axis=1) == 1).all()
        assert np.allclose(
            along.sum(axis=0), 4 * grown.scale * (grown.high[node] - grown.low[node])
        )
        assert len(np.unique(mine.reshape(-1, 3), axis=0)) == 8
