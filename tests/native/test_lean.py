# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lean builds: less memory, the same bits, and an error from all that needs the binary tree."""

import gc
from typing import Any

import identity
import meshes
import numpy as np
import pytest
from cameras import perspective
from editing import PASSES, VIEW, assert_equal, crowd, hits_of
from trees import resident, scene_of
from whittle_core import Scene

NODE, WIDE_LEAF = 32, 8
MOST = 60  #: bytes a triangle, nodes and triangles together
CAMERA = perspective(48, 32, (2.6, -3.2, 1.6), (0, 0, -0.1))
SCENES = {
    "terrain": lambda: meshes.terrain(150),
    "sphere": lambda: meshes.icosphere(5),
    "boxes": lambda: meshes.boxes(2000),
}


def structures(stats: dict[str, Any]) -> int:
    return stats["bytes_nodes"] + stats["bytes_triangles"]


@pytest.mark.parametrize("by_instance", [False, True])
@pytest.mark.parametrize("name", SCENES)
def test_bytes(name: str, by_instance: bool) -> None:
    scene = scene_of(SCENES[name]())
    full = scene.build(by_instance=by_instance)
    assert full["bytes_binary"] == NODE * full["nodes"] == scene.nodes().nbytes
    lean = scene.build(by_instance=by_instance, lean=True)
    assert lean["bytes_binary"] == 0
    assert structures(lean) == structures(full) - full["bytes_binary"], "the same eightfold tree"
    assert lean["bytes"] == full["bytes"] - full["bytes_binary"]
    assert structures(lean) <= MOST * lean["triangles"] < structures(full)
    assert lean["nodes"] < full["nodes"] and lean["largest_leaf"] == WIDE_LEAF


@pytest.mark.parametrize("by_instance", [False, True])
def test_the_memory_is_given_back(by_instance: bool) -> None:
    """What the process holds, not what the statistics say."""
    held, stats = {}, {}
    for lean in (False, True):
        scene = scene_of(meshes.terrain(500))
        gc.collect()
        before = resident()
        stats[lean] = scene.build(lean=lean, by_instance=by_instance)
        held[lean] = resident() - before
    assert held[False] - held[True] > 0.8 * stats[False]["bytes_binary"]
    assert held[True] < 1.2 * MOST * stats[True]["triangles"]


def forbidden(scene: Scene) -> dict[str, Any]:
    settings = {"passes": ["nodes"]}
    return {
        "nodes": scene.nodes,
        "triangles": scene.triangles,
        "owners": scene.owners,
        "quality": scene.quality,
        "hits": lambda: scene.intersect([[0, 0, 9]], [[0, 0, -1]], counters=True),
        "heatmap": lambda: scene.render(CAMERA, settings),
        "job": lambda: scene.start(CAMERA, settings).result(),
        "depth": lambda: scene.render(CAMERA, {"passes": ["leaf_depth"]}),
        "cost": lambda: scene.render(CAMERA, {"cost": True}),
        "lecture": lambda: scene.render(CAMERA, {"mode": "lecture"}),
        "probe": lambda: scene.probe(CAMERA, {}, 20, 20),
    }


def test_what_needs_the_binary_tree_says_so() -> None:
    scene = identity.spheres()[0]
    for by_instance in (False, True):
        scene.build(lean=True, by_instance=by_instance)
        for name, call in forbidden(scene).items():
            with pytest.raises(RuntimeError, match="without lean"):
                call()
                pytest.fail(name)
        scene.build(by_instance=by_instance)
        for call in forbidden(scene).values():
            call()


@pytest.mark.parametrize("name", ["spheres", "duplicates", "grazed_sheets"])
def test_the_same_bits(name: str) -> None:
    scene, view = getattr(identity, name)()
    camera = perspective(96, 60, **view)
    images = {}
    for lean in (False, True):
        scene.build(lean=lean)
        for mode in ("fast", "single"):
            settings = {"passes": PASSES, "mode": mode, "samples": 4}
            images[lean, mode] = scene.render(camera, settings)
    for image in images.values():
        assert_equal(image, images[False, "fast"], PASSES)


def test_edits_build_only_what_changed() -> None:
    model = crowd(12, 2)
    scene = model.scene
    for lean in (True, False, True):
        assert scene.build(by_instance=True, lean=lean)["subtrees_built"] == 13, "another kind"
        for instance, place in ((3, 14), (3, 15), (9, 16), (1, 17), (3, 3), (9, 2), (1, 1)):
            model.set_transform(instance, place)
            stats = scene.build(by_instance=True, lean=lean)
            assert stats["subtrees_built"] == 1
            fresh = model.fresh()
            want = fresh.build(by_instance=True, lean=lean)
            same = ("nodes", "leaves", "depth", "sah_cost", "bytes", "bytes_binary")
            assert [stats[key] for key in same] == [want[key] for key in same]
            hits = hits_of(scene)
            assert_equal(hits, hits_of(fresh), hits)
            fresh.build()
            image = fresh.render(VIEW, {"passes": PASSES})
            assert_equal(scene.render(VIEW, {"passes": PASSES}), image, PASSES)
    assert len(np.unique(image["combined"])) > 100, "there is something to see"


def test_an_empty_scene() -> None:
    scene = Scene()
    assert scene.build(lean=True)["bytes_binary"] == 0
    assert np.isinf(scene.intersect([[0, 0, 9]], [[0, 0, -1]])["t"]).all()
