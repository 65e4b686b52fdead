# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Who pays for rays: owners of nodes, and cost by instance and by material."""

from typing import Any

import counting
import identity
import isa
import meshes
import numpy as np
import pytest
import whittle_core
from cameras import perspective
from numpy.typing import NDArray

KINDS = ("primary", "shadow", "reflection", "refraction")
WHATS = ("nodes", "triangles")
COUNTERS = [f"{what}_{kind}" for what in WHATS for kind in KINDS]


def forest() -> identity.Placed:
    """One mesh of two materials as many instances that overlap, above a mirror without any."""
    scene = identity.lit([identity.DIFFUSE, identity.MIRROR, identity.GLASS])
    ball = meshes.icosphere(2, 0.5)
    halves = np.where(np.arange(len(ball[1])) % 3 == 0, 2, 1).astype(np.uint32)
    mesh = scene.add_mesh(*ball, materials=halves)
    random = np.random.default_rng(4)
    for _ in range(25):
        place = np.eye(4)
        place[:3, :3] *= random.uniform(0.3, 1.0)
        place[:3, 3] = random.uniform(-1.2, 1.2, 3)
        scene.add_instance(mesh, place)
    scene.add_instance(scene.add_mesh(*meshes.box((-3, -3, -2), (3, 3, -1.8))), np.eye(4))
    return scene, {"eye": (2.6, -3.2, 1.6), "target": (0, 0, -0.1)}


SCENES = {"forest": forest, "spheres": identity.spheres, "boxes": identity.boxes}
LAYOUTS = [{}, {"max_leaf": 1}, {"max_leaf": 32, "traversal_cost": 50.0}]


def labels_of(scene: whittle_core.Scene, materials: list[NDArray]) -> dict[str, NDArray]:
    """Instance and material of each triangle in leaf order; `materials`: by instance."""
    order = scene.triangles()
    pairs = zip(order["instance"], order["triangle"], strict=True)
    return {
        "instance": order["instance"].astype(np.int64),
        "material": np.array([materials[i][t] for i, t in pairs], np.int64),
    }


def forest_materials() -> list[NDArray]:
    count = len(meshes.icosphere(2)[1])
    ball = np.where(np.arange(count) % 3 == 0, 2, 1)
    return [ball] * 25 + [np.zeros(12, int)]


def rendered(name: str, build: dict[str, Any] | None = None, **settings: Any) -> dict[str, Any]:
    scene, view = SCENES[name]()
    scene.build(**build or {})
    camera = perspective(120, 75, **view)
    passes = (*identity.PASSES, *COUNTERS)
    return scene.render(camera, {"passes": passes, "samples": 4, "cost": True, **settings})


@pytest.mark.parametrize("layout", LAYOUTS)
def test_owners_agree_with_python(layout: dict) -> None:
    scene, _ = forest()
    scene.build(**layout)
    labels, found = labels_of(scene, forest_materials()), scene.owners()
    for what, wanted in labels.items():
        naive = counting.owners(scene.nodes(), wanted)
        assert found[what].dtype == np.int32
        np.testing.assert_array_equal(found[what], naive)
        assert (naive == -1).any() and (naive >= 0).any()


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("name", SCENES)
def test_tables_add_up_to_statistics_and_pixels(name: str, layout: dict) -> None:
    image = rendered(name, layout)
    for by in ("instance", "material"):
        for what in WHATS:
            table = image["cost"][by][what]
            assert table.dtype == np.uint64
            for row, kind in zip(table, KINDS, strict=True):
                assert row.sum() == image["stats"][what][kind]
                assert row.sum() == image[f"{what}_{kind}"].sum(dtype=np.float64)
        assert image["cost"][by]["nodes"][0, -1] > 0, "at least the root is shared"
        assert not image["cost"][by]["triangles"][:, -1].any()


def by_owner(
    scene: whittle_core.Scene, rays: list[dict], labels: NDArray, columns: int
) -> tuple[NDArray, NDArray]:
    """Both tables, from lists of what rays visited."""
    owners = counting.owners(scene.nodes(), labels)
    tables = np.zeros((2, 4, columns + 1), np.uint64)
    for ray in rays:
        kind = KINDS.index(ray["kind"])
        np.add.at(tables[0, kind], owners[ray["nodes"]], 1)  # -1 is the last column
        np.add.at(tables[1, kind], labels[ray["triangles"]], 1)
    return tables[0], tables[1]


def test_tables_hold_what_each_ray_visited() -> None:
    """Column by column, summed in Python over every ray of a small picture."""
    scene, view = forest()
    scene.build()
    camera = perspective(14, 9, **view)
    settings = {"samples": 4, "cost": True, "max_depth": 3}
    cost = scene.render(camera, settings)["cost"]
    rays = [r for x in range(14) for y in range(9) for r in scene.probe(camera, settings, x, y)]
    assert {ray["kind"] for ray in rays} == set(KINDS)
    for by, labels in labels_of(scene, forest_materials()).items():
        columns = {"instance": 26, "material": 3}[by]
        nodes, triangles = by_owner(scene, rays, labels, columns)
        np.testing.assert_array_equal(cost[by]["nodes"], nodes)
        np.testing.assert_array_equal(cost[by]["triangles"], triangles)


def test_the_cost_alone_makes_a_render_count() -> None:
    scene, view = forest()
    scene.build()
    camera = perspective(40, 30, **view)
    image = scene.render(camera, {"cost": True})
    assert list(image) == ["combined", "cost", "stats"]
    assert "counters" in image["stats"]["needs"]
    assert image["cost"]["instance"]["nodes"][0].sum() == image["stats"]["nodes"]["primary"] > 0
    plain = scene.render(camera, {"cost": False})
    assert "cost" not in plain and "counters" not in plain["stats"]["needs"]
    np.testing.assert_array_equal(plain["combined"], image["combined"])
    assert plain["stats"]["bytes"] < image["stats"]["bytes"]
    job = scene.start(camera, {"cost": True})
    for by, tables in job.result()["cost"].items():
        for what, table in tables.items():
            np.testing.assert_array_equal(table, image["cost"][by][what])


def test_tables_never_meet_a_scene_that_has_grown() -> None:
    """Materials set right after the start: the job has the old columns, or says what is wrong."""
    scene, view = forest()
    scene.build()
    camera = perspective(8, 8, **view)
    seen = set()
    for more in range(1, 120):
        columns = 2 + more
        job = scene.start(camera, {"cost": True})
        try:
            scene.set_materials([identity.DIFFUSE] * (3 + more))
        except RuntimeError:
            job.result()
            scene.set_materials([identity.DIFFUSE] * (3 + more))
            seen.add("busy")
            continue
        try:
            table = job.result()["cost"]["material"]["nodes"]
            assert table.shape == (4, columns + 1) and table[0].sum() > 0
            seen.add("before")
        except ValueError as error:
            assert "ask for the columns again" in str(error)
            seen.add("after")
        except RuntimeError as error:
            assert "being changed" in str(error)
            seen.add("meanwhile")
    assert seen


def table_bytes(threads: int, **settings: Any) -> bytes:
    cost = rendered("forest", threads=threads, **settings)["cost"]
    return b"".join(cost[by][what].tobytes() for by in ("instance", "material") for what in WHATS)


def test_tables_depend_on_the_scene_alone() -> None:
    found = {table_bytes(1), table_bytes(3, packet=1024), table_bytes(2, mode="lecture")}
    for name in isa.ISAS:
        with isa.process(name) as run:
            found.add(run(table_bytes, 2))
    assert len(found) == 1


@pytest.mark.parametrize("name", SCENES)
def test_the_image_keeps_its_bits(name: str) -> None:
    scene, view = SCENES[name]()
    scene.build()
    settings = {"passes": identity.PASSES, "samples": 4}
    plain = scene.render(perspective(120, 75, **view), settings)
    assert identity.digest(plain) == identity.digest(rendered(name))


def beside(stray: bool) -> tuple[whittle_core.Scene, int]:
    """Two spheres well apart; `stray`: one triangle of the second lies by the first."""
    scene = identity.lit([identity.DIFFUSE])
    first, second = meshes.icosphere(3, 1.0, (-3, 0, 0)), meshes.icosphere(3, 1.0, (3, 0, 0))
    lost = meshes.soup(np.float32([[[-3, -1.1, 0], [-2.9, -1.1, 0], [-3, -1.1, 0.1]]]))
    for mesh in (first, meshes.join(second, lost) if stray else second):
        scene.add_instance(scene.add_mesh(*mesh), np.eye(4))
    return scene, scene.build(max_leaf=1)["depth"]


def test_a_stray_triangle_makes_what_it_stretches_shared() -> None:
    view = perspective(60, 60, (-3, -9, 0.4), (-3, 0, 0), half_width=0.12)
    shares = {}
    for stray in (False, True):
        scene, _ = beside(stray)
        nodes, owners = scene.nodes(), scene.owners()["instance"]
        if not stray:
            assert (np.flatnonzero(owners == -1) == [0]).all(), "only the root is shared"
        else:
            rows = scene.triangles()
            row = np.flatnonzero((rows["instance"] == 1) & (rows["triangle"] == 1280))[0]
            leaf = np.flatnonzero((nodes["count"] > 0) & (nodes["left_first"] == row))[0]
            assert owners[leaf] == 1
            assert (owners == -1).sum() == counting.node_depths(nodes)[leaf], "all above it"
        paid = scene.render(view, {"cost": True, "max_depth": 0})["cost"]["instance"]["nodes"][0]
        shares[stray] = paid[-1] / paid.sum()
        assert (paid[1] > 0) == stray, "the second sphere is out of sight, its triangle is not"
    assert shares[True] > 3 * shares[False]


def test_empty_and_hidden_instances_pay_nothing() -> None:
    scene = identity.lit([identity.DIFFUSE, identity.BLUE])
    empty = scene.add_mesh(np.zeros((0, 3)), np.zeros((0, 3), np.uint32))
    scene.add_instance(empty, np.eye(4))
    scene.add_instance(scene.add_mesh(*meshes.icosphere(2)), np.eye(4))
    scene.build()
    cost = scene.render(perspective(30, 20, (0, -4, 0), (0, 0, 0)), {"cost": True})["cost"]
    assert cost["instance"]["nodes"].shape == (4, 3)
    assert cost["material"]["nodes"].shape == (4, 3)
    assert not cost["instance"]["nodes"][:, [0, 2]].any()
    assert not cost["material"]["nodes"][:, [1, 2]].any()
    assert (scene.owners()["instance"] == 1).all()
    nothing = identity.lit([identity.DIFFUSE])
    nothing.build()
    assert len(nothing.owners()["instance"]) == len(nothing.owners()["material"]) == 0
    cost = nothing.render(perspective(8, 8, (0, -4, 0), (0, 0, 0)), {"cost": True})["cost"]
    assert cost["instance"]["nodes"].tolist() == [[0]] * 4


def test_a_scene_that_was_edited_pays_in_the_same_columns() -> None:
    """Instances keep their columns when others go, in a tree of subtrees too."""
    scene, view = forest()
    scene.build(by_instance=True)
    scene.remove_instance(7)
    scene.build(by_instance=True)
    labels = labels_of(scene, forest_materials())
    for what, wanted in labels.items():
        found = scene.owners()[what]
        np.testing.assert_array_equal(found, counting.owners(scene.nodes(), wanted))
    image = scene.render(perspective(60, 40, **view), {"cost": True, "samples": 4})
    nodes = image["cost"]["instance"]["nodes"]
    assert nodes.shape == (4, 27) and not nodes[:, 7].any() and nodes[0, 25] > 0
    for row, kind in zip(nodes, KINDS, strict=True):
        assert row.sum() == image["stats"]["nodes"][kind]


def test_what_is_refused() -> None:
    scene = whittle_core.Scene()
    scene.add_instance(scene.add_mesh(*meshes.icosphere(1), materials=[2] * 80), np.eye(4))
    camera = perspective(8, 8, (0, -4, 0), (0, 0, 0))
    for call in (scene.owners, lambda: scene.render(camera, {"cost": True})):
        with pytest.raises(RuntimeError, match="build"):
            call()
    scene.build()
    for call in (scene.owners, lambda: scene.render(camera, {"cost": True})):
        with pytest.raises(ValueError, match="material 2 of 1 does not exist"):
            call()
    with pytest.raises(ValueError, match=r"settings\['cost'\]"):
        scene.render(camera, {"cost": "yes"})
