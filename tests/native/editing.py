# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene that is edited, beside what new scenes of the same things show."""

from typing import Any

import identity
import meshes
import numpy as np
from cameras import perspective
from meshes import Mesh
from numpy.typing import NDArray
from trees import check_tree
from whittle_core import CAMERA, Scene

PASSES = ("combined", "depth", "position", "normal", "object_index")
COUNTERS = ("nodes", "triangles")
VIEW = perspective(48, 32, (3.0, -7.0, 2.5), (0, 0, 0), half_width=0.6)

#: Coplanar ones, which tie; some that lose triangles or have none; one of a single leaf.
MESHES: dict[str, Mesh] = {
    "sphere": meshes.icosphere(3),
    "boxes": meshes.boxes(20),
    "sheets": meshes.coplanar_duplicates(2, 6),
    "one": meshes.soup(np.array([[[0, 0, 0], [1, 0.3, 0], [0, 1, 0.2]]])),
    "few": meshes.box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)),
    "none": meshes.pack(np.zeros((0, 3)), np.zeros((0, 3))),
    "broken": meshes.join(
        meshes.icosphere(1, 0.7),
        meshes.soup(np.full((3, 3, 3), np.nan)),
        meshes.soup(np.ones((2, 3, 3))),
    ),
}
NAMES = tuple(MESHES)
PLACES = [meshes.transform(0.8, offset) for offset in np.ndindex(3, 3, 2)]
PLACES += [meshes.transform(0.4, (x, -x, 0.3)) for x in (-2.7, 1.9)]
PLACES += [np.array([[0, -1, 0, 1], [1, 0, 0, 0], [0, 0, -1, 0.5], [0, 0, 0, 1.0]])]
PLACES += [meshes.transform(1.0, (40.0, 0, 0)), meshes.transform(4.0, (1, 1, -6))]


def rays(count: int = 300) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    random = np.random.default_rng(4)
    return random.uniform(-3, 5, (count, 3)), random.standard_normal((count, 3))


class Model:
    """A scene beside the list of what is in it, from which new scenes are made."""

    def __init__(self) -> None:
        self.scene = identity.lit([identity.DIFFUSE, identity.MIRROR])
        self.meshes: list[str] = []
        self.placed: list[tuple[int, int] | None] = []  #: mesh and place; None: removed
        self.known: dict[int, tuple[str, int]] = {}  #: what each instance was last built from
        self.frame: tuple | None = None
        self.bins = 16

    def add_mesh(self, name: str) -> None:
        assert self.scene.add_mesh(*MESHES[name]) == len(self.meshes)
        self.meshes.append(name)

    def add_instance(self, mesh: int, place: int) -> None:
        visible = {} if len(self.placed) % 4 else {"visibility": CAMERA}
        number = self.scene.add_instance(mesh, PLACES[place], len(self.placed), **visible)
        assert number == len(self.placed)
        self.placed.append((mesh, place))

    def set_transform(self, instance: int, place: int) -> None:
        self.scene.set_transform(instance, PLACES[place])
        mesh, _ = self.placed[instance]
        self.placed[instance] = mesh, place

    def replace_mesh(self, mesh: int, name: str) -> None:
        self.scene.replace_mesh(mesh, *MESHES[name])
        self.meshes[mesh] = name

    def remove_instance(self, instance: int) -> None:
        self.scene.remove_instance(instance)
        self.placed[instance] = None

    def live(self) -> list[int]:
        return [i for i, placed in enumerate(self.placed) if placed is not None]

    def fresh(self) -> Scene:
        """The same with nothing removed before; its instances are numbered as in live()."""
        scene = identity.lit([identity.DIFFUSE, identity.MIRROR])
        for name in self.meshes:
            scene.add_mesh(*MESHES[name])
        for i in self.live():
            mesh, place = self.placed[i]
            visible = {} if i % 4 else {"visibility": CAMERA}
            scene.add_instance(mesh, PLACES[place], i, **visible)
        return scene

    def build(self, threads: int = 0) -> dict[str, Any]:
        """Builds by instance and checks how many subtrees it took."""
        stats = self.scene.build(threads=threads, bins=self.bins, by_instance=True)
        wanted = {i: (self.meshes[self.placed[i][0]], self.placed[i][1]) for i in self.live()}
        frame = stats["center"], stats["exponent"], self.bins
        kept = frame == self.frame
        same = [i for i in wanted if kept and self.known.get(i) == wanted[i]]
        assert stats["subtrees"] == stats["instances"] == len(wanted)
        assert stats["subtrees_built"] == len(wanted) - len(same)
        before = self.frame
        assert stats["frame_changed"] == (before is not None and before[:2] != frame[:2])
        self.known, self.frame = wanted, frame
        return stats

    def build_whole(self) -> None:
        assert self.scene.build(bins=self.bins)["subtrees"] == 0
        self.known, self.frame = {}, None


def hits_of(scene: Scene, names: list[int] | None = None) -> dict[str, NDArray]:
    """Hits of rays(), with instances by other names if wanted."""
    hits = scene.intersect(*rays())
    if names is not None:
        hits["instance"] = np.array([*names, -1], np.int32)[hits["instance"]]
    return hits


def assert_equal(got: dict[str, Any], want: dict[str, Any], keys: Any) -> None:
    for key in keys:
        np.testing.assert_array_equal(got[key], want[key], err_msg=key)


def shape_of(scene: Scene) -> list[tuple]:
    """The tree from the root on, wherever its nodes lie: boxes, and the triangles of leaves."""
    nodes, triangles = scene.nodes(), scene.triangles()
    found: list[tuple] = []
    waiting = [0] if len(nodes) else []
    while waiting:
        node = nodes[waiting.pop()]
        first, count = int(node["left_first"]), int(node["count"])
        leaf = slice(first, first + count)
        names = triangles["triangle"][leaf].tobytes(), triangles["vertices"][leaf].tobytes()
        found.append((node["bounds_min"].tobytes(), node["bounds_max"].tobytes(), count, *names))
        if count == 0:
            waiting += [first + 1, first]
    return found


def check_against_new_scenes(model: Model, stats: dict[str, Any]) -> None:
    scene, names = model.scene, model.live()
    check_tree(scene, stats)
    whole, parts = model.fresh(), model.fresh()
    whole_stats = whole.build()
    parts_stats = parts.build(bins=model.bins, by_instance=True)
    for key in ("triangles", "center", "exponent", "dropped", "dropped_zero_area"):
        assert stats[key] == whole_stats[key], key
    for key in ("nodes", "leaves", "depth", "sah_cost", "bytes"):
        assert stats[key] == parts_stats[key], key
    assert shape_of(scene) == shape_of(parts)
    hits = hits_of(scene)
    assert_equal(hits, hits_of(whole, names), hits)
    assert_equal(hits, scene.reference_intersect(*rays()), ("instance", "triangle"))
    image = scene.render(VIEW, {"passes": PASSES + COUNTERS})
    assert_equal(scene.render(VIEW, {"passes": PASSES}), image, PASSES)
    assert_equal(image, whole.render(VIEW, {"passes": PASSES}), PASSES)
    assert_equal(image, parts.render(VIEW, {"passes": COUNTERS}), COUNTERS)


def crowd(count: int = 12, divisions: int = 4) -> Model:
    """Spheres in each other's way, and a frame that moving one of them does not change."""
    model = Model()
    MESHES.setdefault(f"sphere {divisions}", meshes.icosphere(divisions))
    model.add_mesh(f"sphere {divisions}")
    model.add_mesh("boxes")
    model.add_instance(1, len(PLACES) - 1)
    for i in range(count):
        model.add_instance(0, i)
    model.build()
    return model


def heavy() -> Scene:
    scene = Scene()
    kinds = [scene.add_mesh(*mesh) for mesh in (meshes.torus(250, 100), meshes.icosphere(4))]
    for k, place in enumerate(PLACES[:12]):
        scene.add_instance(kinds[k % 3 > 0], place)
    return scene
