# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stability cases of packets: frusta far away, mixed signs, odd image sizes, equal distances."""

import aim
import meshes
import naive
import numpy as np
import whittle_core
from aim import Rays
from cameras import perspective
from numpy.typing import NDArray
from stability_tools import Case, Result, differing, scene_of
from stability_triangles import ASIDE

PACKETS = (4, 16, 64, 256)
NAIVE_RAYS = 20_000


def packet_differences(scene: whittle_core.Scene, rays: Rays) -> int:
    """Rays whose answer depends on the packet size, in any bit; counted for each size."""
    single = scene.intersect(*rays, packet=1)
    dark = scene.occluded(*rays, packet=1)
    bad = 0
    for packet in PACKETS:
        bad += differing(scene.intersect(*rays, packet=packet), single)
        bad += int((scene.occluded(*rays, packet=packet) != dark).sum())
    return bad


def strewn_boxes(count: int, shift: float, seed: int = 16) -> NDArray[np.float64]:
    """Small boxes as rows of low and high corners, (count, 6), about a point far away."""
    random = np.random.default_rng(seed)
    low = random.uniform(-1, 1, (count, 3)) + shift * ASIDE
    return np.concatenate([low, low + random.uniform(0.002, 0.05, (count, 3))], axis=1)


def box_scene(shift: float) -> meshes.Mesh:
    return meshes.join(*(meshes.box(row[:3], row[3:]) for row in strewn_boxes(1500, shift)))


def jittered(rays: Rays, amount: float) -> Rays:
    """Directions moved at random, so that the corner rays do not bound the packet."""
    random = np.random.default_rng(17)
    return rays[0], (rays[1] + random.uniform(-amount, amount, rays[1].shape)).astype(np.float32)


def far_packets(count: int) -> Result:
    """Scenes far from the world's origin, and cameras far from the scene."""
    side = int((count / 6) ** 0.5) // 16 * 16 or 16
    bad = tried = 0
    for shift in (1e3, 1e4, 1e5):
        moved, _ = scene_of(box_scene(shift))
        eye = np.array([3.0, 2.0, 1.5])
        views = [(moved, aim.pinhole(side, side, shift * ASIDE + eye, shift * ASIDE, 35))]
        at_origin, _ = scene_of(box_scene(0.0))
        narrow = np.degrees(2 / shift)
        views.append((at_origin, aim.pinhole(side, side, shift * ASIDE, (0, 0, 0), narrow)))
        for scene, rays in views:
            rays = aim.tiled(jittered(rays, 0.3 / side / shift), side, side)
            bad += packet_differences(scene, rays)
            tried += len(rays[0])
    return Result(bad, tried)


def far_packets_naive(count: int) -> Result:
    """Planes through the corner rays' points in world space, as the boxes move away."""
    culled = hit = 0
    for shift in (1e3, 1e4, 1e5):
        eye = shift * ASIDE + np.array([3.0, 2.0, 1.5])
        origins, directions = aim.pinhole(512, 512, eye, shift * ASIDE, 35)
        image = directions.reshape(512, 512, 3)
        boxes = strewn_boxes(min(count // 10, 5000), shift)
        for y in range(64, 512, 128):
            for x in range(64, 512, 128):
                packet = image[y : y + 16, x : x + 16].reshape(-1, 3)
                bad, seen = naive.frustum_culls(origins[0], packet, [0, 15, 255, 240], boxes)
                culled += bad
                hit += seen
    return Result(culled, hit)


def fisheye(side: int, eye) -> Rays:
    """A whole sphere of directions in one image, so that packets span every axis."""
    lon, lat = np.meshgrid(
        np.linspace(-np.pi, np.pi, side, endpoint=False), np.linspace(-1.57, 1.57, side)
    )
    direction = np.stack(
        [np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], axis=-1
    )
    direction = direction.reshape(-1, 3).astype(np.float32)
    direction[np.abs(direction) < 1e-6] = 0.0
    return np.tile(np.asarray(eye, np.float32), (len(direction), 1)), direction


def wide_views(count: int) -> list[tuple[Rays, int]]:
    side = int((count / 4) ** 0.5) // 16 * 16 or 16
    eye = (0.02, -0.01, 0.03)
    return [
        (fisheye(side, eye), side),
        (aim.pinhole(side, side, eye, (1.0, 0.0, 0.0), 179.9), side),
        (aim.pinhole(side, side, eye, (0.0, 0.0, 1.0), 90.0), side),
        (aim.pinhole(side, side, (0.0, -900.0, 0.0), (0.5, 0.0, 0.1), 0.001), side),
    ]


def mixed_signs(count: int) -> Result:
    scene, _ = scene_of(meshes.boxes())
    bad = tried = 0
    for rays, side in wide_views(count):
        bad += packet_differences(scene, aim.tiled(rays, side, side))
        tried += len(rays[0])
    return Result(bad, tried)


def mixed_signs_naive(count: int) -> Result:
    """Packets whose box test takes near and far from the signs of their first ray."""
    corners = meshes.corners(meshes.boxes())
    lost = tried = 0
    for rays, side in wide_views(min(count, NAIVE_RAYS))[:3]:
        origins, directions = aim.tiled(rays, side, side)
        for first in range(0, len(origins), 256):
            part = origins[first : first + 256], directions[first : first + 256]
            right, _ = naive.trace(corners, *part, naive.WOOP)
            wrong, _ = naive.trace(corners, *part, naive.WOOP, naive.FIRST_SIGNS)
            lost += int((right != wrong).sum())
            tried += len(right)
    return Result(lost, tried)


def sixty_boxes(count: int) -> Result:
    side = int((count / 2) ** 0.5) // 32 * 32 or 32
    mesh = meshes.boxes()
    scene, _ = scene_of(mesh)
    camera = aim.tiled(aim.pinhole(side, side, (2.5, -3, 1.8), (0, 0, 0), 40), side, side)
    edges = aim.from_point(mesh, "edges", side * side, (2.5, -3, 1.8))
    bad = packet_differences(scene, camera) + packet_differences(scene, edges)
    return Result(bad, 2 * side * side)


def sixty_boxes_naive(count: int) -> Result:
    """Hits at the boxes' edges that an unpadded test loses on some triangle's own box, so that
    they depend on which boxes a packet lets a ray skip."""
    mesh = meshes.boxes()
    origins, directions = aim.from_point(mesh, "edges", min(count, NAIVE_RAYS), (2.5, -3, 1.8))
    right = naive.trace(meshes.corners(mesh), origins, directions, naive.WOOP)
    wrong = naive.trace(meshes.corners(mesh), origins, directions, naive.WOOP, naive.UNPADDED)
    return Result(int(((right[0] != wrong[0]) | (right[1] != wrong[1])).sum()), len(origins))


SIZES = ((1, 1), (7, 5), (17, 1), (16384, 1))


def image_sizes(count: int) -> Result:
    """Renders of odd sizes; every packet size and mode against single rays, all bits."""
    scene, _ = scene_of(meshes.boxes())
    scene.set_lights([{"kind": "sun", "direction": (0.3, 0.5, -1), "intensity": (3, 3, 3)}])
    scene.set_materials([{"diffuse": (0.6, 0.6, 0.6), "mirror": (0.3, 0.3, 0.3)}])
    bad = tried = 0
    for width, height in SIZES:
        camera = perspective(width, height, (2.5, -3.0, 1.8), (0, 0, 0))
        passes = ("combined", "depth", "normal")
        single = scene.render(camera, {"passes": passes, "mode": "single"})
        for mode in ("fast", "lecture"):
            for packet in (0, 16, 64, 256, 1024):
                settings = {"passes": passes, "mode": mode, "packet": packet}
                image = scene.render(camera, settings)
                for name in passes:
                    assert image[name].shape == single[name].shape
                    bad += int((image[name].view(np.uint32) != single[name].view(np.uint32)).sum())
                tried += width * height
    return Result(bad, tried, "all pixels of 4 images, 10 ways")


def image_sizes_naive(count: int) -> Result:
    """Pixels that a loop over whole tiles writes outside the images' memory."""
    outside = [naive.tiles(width, height, 16) for width, height in SIZES]
    return Result(sum(outside), sum(w * h for w, h in SIZES))


def lowest_copy(mesh: meshes.Mesh) -> NDArray[np.int64]:
    """For each triangle the lowest one with the same corners in the same order."""
    corners = meshes.corners(mesh).reshape(len(mesh[1]), 9)
    _, first, inverse = np.unique(corners, axis=0, return_index=True, return_inverse=True)
    return first[inverse.ravel()]


def duplicate_rays(count: int) -> tuple[meshes.Mesh, Rays]:
    mesh = meshes.coplanar_duplicates()
    parts = [
        aim.from_around(mesh, kind, count // 2, seed) for seed, kind in enumerate(aim.KINDS[1:])
    ]
    return mesh, (np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts]))


def duplicates(count: int) -> Result:
    """Winners that are not the lowest copy, or that depend on builder, threads or packets."""
    mesh, rays = duplicate_rays(min(count, 300_000))
    lowest = lowest_copy(mesh)
    bad, first = 0, None
    for bins, leaf, threads, packet in (
        (16, 8, 0, 0),
        (8, 1, 1, 1),
        (32, 4, 2, 16),
        (2, 64, 3, 256),
        (64, 2, 7, 100),
    ):
        scene, _ = scene_of(mesh, bins=bins, max_leaf=leaf, threads=threads)
        hits = scene.intersect(*rays, threads=threads, packet=packet)
        first = first or hits
        hit = hits["triangle"][hits["triangle"] >= 0]
        bad += differing(hits, first) + int((lowest[hit] != hit).sum())
    return Result(bad, len(rays[0]))


def duplicates_naive(count: int) -> Result:
    mesh, rays = duplicate_rays(min(count, NAIVE_RAYS))
    corners = meshes.corners(mesh)
    order = np.random.default_rng(3).permutation(len(corners))
    _, one = naive.trace(corners, *rays, naive.WOOP, lowest=False)
    _, other = naive.trace(corners[order], *rays, naive.WOOP, lowest=False)
    other = np.where(other >= 0, order[other], -1)
    return Result(int((one != other).sum()), len(one))


CASES = [
    Case(
        "16",
        "packets at boxes moved by 1e3 to 1e5, and seen from so far away, with jitter",
        "packets give the bits of single rays",
        far_packets,
        far_packets_naive,
        "planes through the corner rays' points",
    ),
    Case(
        "18",
        "fisheye, 179.9 and 0.001 degrees: packets of mixed signs",
        "packets give the bits of single rays",
        mixed_signs,
        mixed_signs_naive,
        "near and far by the first ray's signs",
    ),
    Case(
        "19",
        "60 boxes, camera rays and rays at edges, packets of 4 to 256",
        "packets give the bits of single rays",
        sixty_boxes,
        sixty_boxes_naive,
        "box test without padding",
    ),
    Case(
        "20",
        "images of 1x1, 7x5, 17x1 and 16384x1 pixels, packets larger than they are",
        "packets give the bits of single rays",
        image_sizes,
        image_sizes_naive,
        "loop over whole tiles",
    ),
    Case(
        "27",
        "a flat grid three times in the same place, in another order",
        "the lowest copy wins, for every builder, number of threads and packet size",
        duplicates,
        duplicates_naive,
        "first hit found stays",
    ),
]
