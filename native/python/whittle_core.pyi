# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Types of the native module: scenes of triangles, their BVH, rays and Whitted images."""

from collections.abc import Callable, Mapping, Sequence
from math import inf
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

CAMERA: int  #: visible to camera rays
SHADOW: int  #: casts shadows
REFLECTION: int  #: visible in mirrors
REFRACTION: int  #: visible through glass
ALL: int

PASSES: dict[str, int]
"""Name of each pass and its channels, in the order of the C header: ``combined``, ``depth``,
``position``, ``normal``, ``object_index``, ``nodes``, ``nodes_primary``, ``nodes_shadow``,
``nodes_reflection``, ``nodes_refraction``, ``triangles``, ``triangles_primary``, ...,
``leaf_depth`` (edges from the root to the deepest leaf visited), ``coherence`` (0 to 1: share of
the packets' rays that entered the nodes visited; in the mode "lecture" only), ``seconds`` (wall
time of the pixel's tile by its pixels: not reproducible)."""

class Cancelled(Exception):
    """The progress callback returned False, or the job was cancelled."""

def isa() -> str:
    """The instruction set in use; RuntimeError if WHITTLE_ISA names one that cannot run here."""

def isas() -> tuple[str, ...]:
    """Those of ``sse4.2``, ``avx2``, ``avx512`` that this CPU and system can run."""

def default_threads() -> int:
    """What ``threads=0`` means here."""

def triangulate(
    positions: ArrayLike,  # float32 (n, 3)
    corners: ArrayLike,  # uint32 (k,): the vertex of each polygon's corner, polygon by polygon
    faces: ArrayLike,  # uint32 (m,), never falling: the polygon of each triangle
    *,
    by_corner: bool = False,
) -> tuple[NDArray[np.uint32], int]:
    """Triangles (m, 3) of vertices, or by_corner of corners, and how many of them are open: those
    hold 4294967295 three times. Triangles stay; a quad is divided from its first corner to its
    third if the areas of the halves face the same way, else from the second to the fourth. Quads
    where rounding may decide that, and polygons of more corners, are left open. ValueError names
    what does not fit."""

@final
class Scene:
    """Meshes, instances, materials, lights and world; then a BVH; then rays and images.

    Wrong shapes, types, indices and transforms raise ValueError naming the argument; changing a
    scene that is being traced raises RuntimeError, as does tracing one that is not built.

    Arrays may be anything that numpy makes an array of, in any layout: real numbers of another type
    are converted, integers are taken for indices if they lie in range.
    """

    def add_mesh(
        self,
        positions: ArrayLike,  # float32 (n, 3)
        triangles: ArrayLike,  # uint32 (m, 3)
        normals: ArrayLike | None = None,  # float32 (n, 3) or (m, 3, 3)
        uvs: Mapping[str, ArrayLike] | None = None,  # float32 (n, 2) or (m, 3, 2)
        materials: ArrayLike | None = None,  # uint32 (m,)
        *,
        corners: ArrayLike | None = None,  # uint32 (k,): triangles index these then
        keep: bool = False,
    ) -> int:
        """Gives its number. Triangles index vertices, or with corners (the vertex of each corner of
        the mesh's polygons) those, and then normals are (k, 3); ValueError names an index that is
        too large.

        Arrays are copied, or with keep used as they are until the mesh is gone: they must be
        read-only, C-ordered and of the types named."""
    def add_instance(
        self,
        mesh: int,
        transform: ArrayLike,  # float64 (4, 4), p' = M @ (p, 1)
        object_id: int = 0,
        visibility: int = ...,
    ) -> int: ...
    def set_transform(self, instance: int, transform: ArrayLike) -> None:
        """Moves an instance: float64 (4, 4), as in add_instance. Instances and meshes keep their
        numbers, and the scene must be built again before it is traced, as after the next two."""
    def replace_mesh(
        self,
        mesh: int,
        positions: ArrayLike,
        triangles: ArrayLike,
        normals: ArrayLike | None = None,
        uvs: Mapping[str, ArrayLike] | None = None,
        materials: ArrayLike | None = None,
        *,
        corners: ArrayLike | None = None,
        keep: bool = False,
    ) -> None:
        """Gives all instances of a mesh another one; arrays as in add_mesh. If only its normals or
        materials differ, a build by instance keeps their subtrees."""
    def remove_instance(self, instance: int) -> None:
        """Its number is not given again, and naming it afterwards raises ValueError. Its mesh
        stays: replaced by an empty one it takes no memory."""
    def set_materials(self, materials: Sequence[Mapping[str, Any]]) -> None:
        """Each a mapping with any of diffuse, mirror, metal, specular, transmission, emission
        (three floats), metal_weight, ior, roughness (floats); what is missing is 0 (ior: 1.5)."""
    def set_lights(self, lights: Sequence[Mapping[str, Any]]) -> None:
        """Each a mapping: kind ("point" or "sun"), intensity (three floats: W/sr, or W/m^2 for a
        sun), position or direction (three floats, world), shadow (bool, default True)."""
    def set_world(self, color: Sequence[float], ambient: Sequence[float] = (0, 0, 0)) -> None:
        """Radiance that escaping rays see, and radiance that lights every diffuse surface."""
    def build(
        self,
        threads: int = 0,
        bins: int = 16,
        on_progress: Callable[[float], bool | None] | None = None,
        *,
        max_leaf: int = 0,
        traversal_cost: float = 0.0,
        by_instance: bool = False,
        lean: bool = False,
    ) -> dict[str, Any]:
        """by_instance makes a subtree for each instance under a tree over them, and the next build
        with the same options makes only those anew that have changed; images and hits have the same
        bits, but rays cost more where instances overlap.

        lean leaves out the binary tree: it takes less time and memory, but counters, cost, probe,
        quality, owners, nodes, triangles and the mode "lecture" then raise RuntimeError.

        Stats by the names of whittle_build_stats, plus ``dropped``: a list with a mapping
        (mesh, non_finite, zero_area) for each mesh that lost triangles."""
    def intersect(
        self,
        origins: ArrayLike,  # float32 or float64 (k, 3), world space
        directions: ArrayLike,
        t_min: float | ArrayLike = 0.0,
        t_max: float | ArrayLike = inf,
        threads: int = 0,
        *,
        packet: int = 0,
        visibility: int = ...,
        counters: bool = False,  # adds nodes, triangles: uint32 (k,)
    ) -> dict[str, NDArray[Any]]:
        """Arrays (k,): t float32 (inf: miss), instance int32 (-1: miss), triangle int32, u, v."""
    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: float | ArrayLike = 0.0,
        t_max: float | ArrayLike = inf,
        threads: int = 0,
        *,
        packet: int = 0,
        visibility: int = ...,
    ) -> NDArray[np.bool_]: ...
    def reference_intersect(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: float | ArrayLike = 0.0,
        t_max: float | ArrayLike = inf,
        threads: int = 0,
        *,
        visibility: int = ...,
    ) -> dict[str, NDArray[Any]]:
        """As intersect, by brute force in double precision without the tree."""
    def render(
        self,
        camera: Mapping[str, Any],
        settings: Mapping[str, Any] | None = None,
        on_progress: Callable[[float], bool | None] | None = None,
    ) -> dict[str, Any]:
        """Pass name -> float32 (h, w, c), row 0 at the bottom, and ``stats``: a dict.

        camera: to_world, projection: float64 (4, 4); width, height: of the whole image;
        clip_start, clip_end; region: (x0, y0, x1, y1), default everything.
        settings: passes (sequence of names, default ("combined",)), samples, pattern ("regular",
        "stratified"), seed, max_depth (0: no bounces; default 8), cutoff (0: none; default
        1/1024), transparent, mode ("fast", "lecture", "single"), packet, threads, generic, cost.
        stats: by the names of whittle_render_stats, with rays, nodes and triangles as dicts by
        kind (primary, shadow, reflection, refraction), ``needs`` and ``kernel_needs`` as lists of
        names, and ``left_out``: a list of (name, reason). Of these, node_lanes, triangle_lanes and
        those used depend on the instruction set (lanes), like times and bytes.

        With settings["cost"] the render counts, and the result has ``cost``: {"instance":
        {"nodes": uint64 (4, n + 1), "triangles": uint64 (4, n + 1)}, "material": the same with
        (4, m + 1)}. Rows are primary, shadow, reflection, refraction; a column is what the rays
        did to one instance (material), the last one the visits to nodes that hold triangles of
        several. Each row adds up to stats.
        """
    def start(
        self, camera: Mapping[str, Any], settings: Mapping[str, Any] | None = None
    ) -> Job: ...
    def quality(
        self,
        overlap: bool = False,
        by_instance: bool = False,
        on_progress: Callable[[float], bool | None] | None = None,
        *,
        threads: int = 0,
        overlap_samples: int = 0,
    ) -> dict[str, Any]:
        """Judges the built tree by the names of whittle_quality in the C header.

        Numbers: triangles, slivers, nodes, leaves, bytes, depth, largest_leaf, sah_cost, box_fill,
        seconds. ``depth_histogram``, ``leaf_size_histogram``: uint64, leaves by depth and by
        triangles. ``instance``, ``material``: a dict with an array (n,) for each number of
        whittle_part_quality (box_min, box_max: (n, 3), world space).
        overlap: adds ``overlap`` (EPO), ``overlap_samples`` and each part's ``overlap_part``; of
        overlap_samples triangles only, evenly spread, unless that is 0: all, exactly, which takes
        long where many boxes overlap.
        by_instance: adds to ``instance`` sah_cost, stray_share, stray_triangles of trees of their
        own, and ``overlap``, the share of the area in leaf boxes that hold others' triangles.
        """
    def probe(
        self, camera: Mapping[str, Any], settings: Mapping[str, Any] | None, x: int, y: int
    ) -> list[dict[str, Any]]:
        """The rays that render traces for pixel (x, y) of the whole image, in the order traced.

        Of each: kind ("primary", "shadow", "reflection", "refraction"), sample, depth (bounces
        before it), parent (index in the list; -1: the camera), light (index, of a shadow ray; else
        -1), origin and direction float64 (3,) in world space, t_min, t_max, t (inf: miss; points
        are origin + t * direction), distance (to the hit, in world units), instance, triangle,
        material (-1: miss), u, v, nodes (uint32: indices into nodes(), in visiting order) and
        triangles (uint32: indices into triangles(), in testing order). Lengths of nodes and
        triangles add up to the counter passes at that pixel.
        """
    def owners(self) -> dict[str, NDArray[np.int32]]:
        """Whose triangles lie under each node of nodes(): ``instance`` and ``material``, int32
        (nodes,); -1: those of several."""
    def nodes(self) -> NDArray[np.void]:
        """A copy of the tree: bounds_min (3,), left_first, bounds_max (3,), count."""
    def triangles(self) -> dict[str, NDArray[Any]]:
        """The triangles in leaf order: vertices float32 (n, 3, 3) in scene space, instance,
        triangle."""

@final
class Job:
    def poll(self) -> tuple[float, bool]:
        """Fraction done, and whether it has ended."""
    def cancel(self) -> None: ...
    def result(self) -> dict[str, Any]:
        """Waits; what Scene.render returns, or raises what it would raise."""
