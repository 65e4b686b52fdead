/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The public interface of the Whittle core, and its manual. */

#ifndef WHITTLE_H
#define WHITTLE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Conventions that hold everywhere
 *
 * - World space is right-handed and in the caller's units; matrices are row-major double[16] and
 *   map column vectors: p' = M (p, 1). Images have row 0 at the bottom.
 * - Option structs are zero-initialised by the caller: zero means the default.
 * - A function that can fail returns a whittle_status and, if `error` is not NULL, fills it with
 *   the name of the argument at fault and a sentence. Nothing prints, exits or keeps the pointers
 *   that it is given beyond the call, unless it says so.
 * - A scene belongs to one thread while it is changed or built. After whittle_scene_build any
 *   number of threads may trace and render it at once; changing it meanwhile is WHITTLE_BUSY.
 * - Results are the same bits for every instruction set, number of threads, packet size and
 *   builder setting. */

#define WHITTLE_VERSION "0.1.0"

#if defined(__GNUC__)
#define WHITTLE_API __attribute__((visibility("default")))
#else
#define WHITTLE_API
#endif

/* ---- Errors -------------------------------------------------------------------------------- */

typedef enum whittle_status {
  WHITTLE_OK = 0,
  WHITTLE_INVALID_ARGUMENT, /* `argument` names it */
  WHITTLE_OUT_OF_MEMORY,
  WHITTLE_BUSY,        /* the scene is being traced, rendered or built by someone else */
  WHITTLE_NOT_BUILT,   /* tracing needs whittle_scene_build after the last change; counting, one
                          that is not lean */
  WHITTLE_CANCELLED,   /* the progress callback said stop */
  WHITTLE_UNSUPPORTED, /* the CPU, or WHITTLE_ISA, rules it out */
} whittle_status;

typedef struct whittle_error {
  whittle_status status;
  char argument[32]; /* the argument at fault, or "" */
  char message[224]; /* one sentence in English */
} whittle_error;

/* ---- Progress and cancelling ---------------------------------------------------------------- */

/* Called on the calling thread, at most 20 times a second, with the fraction done in [0, 1].
 * Returning 0 cancels: the call then frees what it holds and returns WHITTLE_CANCELLED. */
typedef struct whittle_progress {
  int (*report)(void *user, double fraction);
  void *user;
} whittle_progress;

/* ---- The machine ----------------------------------------------------------------------------- */

/* The instruction set in use: "sse4.2", "avx2" or "avx512". It is chosen by cpuid and xgetbv when
 * first asked for, or by the environment variable WHITTLE_ISA; NULL and an error if that names one
 * which this CPU or system cannot run. */
WHITTLE_API const char *whittle_isa(whittle_error *error);

/* The instruction sets that can run here, narrowest first, ended by NULL. */
WHITTLE_API const char *const *whittle_isas(void);

/* How many threads `threads = 0` means: the fewest of the processors online, those this process
 * may run on, and the whole processors of its container's quota; at least 1. */
WHITTLE_API uint32_t whittle_default_threads(void);

/* ---- Scene ----------------------------------------------------------------------------------- */

typedef struct whittle_scene whittle_scene;

/* Which rays see an instance. */
enum {
  WHITTLE_CAMERA = 1,
  WHITTLE_SHADOW = 2,
  WHITTLE_REFLECTION = 4,
  WHITTLE_REFRACTION = 8,
  WHITTLE_ALL = 15,
};

typedef struct whittle_mesh {
  const float *positions; /* vertex_count x 3, finite or not: bad triangles are dropped */
  size_t vertex_count;
  const uint32_t *triangles; /* triangle_count x 3 indices below vertex_count */
  size_t triangle_count;
  const float *normals;      /* NULL: flat. vertex_count x 3, or by corner */
  int normals_by_corner;     /* triangle_count x 3 x 3; with `corners`, corner_count x 3 */
  const uint32_t *materials; /* NULL: all 0. triangle_count indices into the materials */
  const uint32_t *corners;   /* NULL, or what `triangles` index then, below corner_count: corners of
                                polygons, each with the index of its vertex */
  size_t corner_count;
  /* NULL: the arrays are copied. Else those named first are used as they are, and must stay the
   * same, until the mesh is gone, which calls this once on whatever thread that is. With `corners`,
   * triangles and normals are copied all the same. A call that fails keeps nothing. */
  void (*release)(void *owner);
  void *owner;
} whittle_mesh;

WHITTLE_API whittle_status whittle_scene_create(whittle_scene **scene, whittle_error *error);
WHITTLE_API void whittle_scene_destroy(whittle_scene *scene); /* NULL is fine */

/* Adds a mesh and gives its index, counted from 0. */
WHITTLE_API whittle_status whittle_scene_add_mesh(whittle_scene *scene, const whittle_mesh *mesh,
                                                  uint32_t *index, whittle_error *error);

/* Places a mesh. `transform` must be finite and invertible with last row 0 0 0 1. `object_id` is
 * what the object index pass shows. */
WHITTLE_API whittle_status whittle_scene_add_instance(whittle_scene *scene, uint32_t mesh,
                                                      const double transform[16], int32_t object_id,
                                                      uint32_t visibility, uint32_t *index,
                                                      whittle_error *error);

/* ---- Changing a scene ----
 *
 * Numbers of meshes and instances never change; those of what is removed are not given again. The
 * scene must be built again before it is traced. What fails leaves it as it was. */

WHITTLE_API whittle_status whittle_scene_set_transform(whittle_scene *scene, uint32_t instance,
                                                       const double transform[16],
                                                       whittle_error *error);

/* Gives all instances of a mesh another one. A mesh of the same positions and triangles costs no
 * new subtree: its normals and materials are not part of it. */
WHITTLE_API whittle_status whittle_scene_replace_mesh(whittle_scene *scene, uint32_t mesh,
                                                      const whittle_mesh *source,
                                                      whittle_error *error);

/* Its mesh stays, for others to show: replaced by an empty one it takes no memory. */
WHITTLE_API whittle_status whittle_scene_remove_instance(whittle_scene *scene, uint32_t instance,
                                                         whittle_error *error);

/* ---- Polygons ---- */

typedef struct whittle_polygons {
  const float *positions; /* vertex_count x 3 */
  size_t vertex_count;
  const uint32_t *corners; /* one polygon's after the other's, each the index of its vertex */
  size_t corner_count;
  const uint32_t *faces; /* of each triangle the number of its polygon, never falling: one of k
                            corners has k - 2, so one that is not named has two corners */
  size_t triangle_count;
} whittle_polygons;

/* What whittle_triangulate leaves open. */
#define WHITTLE_OPEN UINT32_MAX

/* Writes triangle_count x 3 indices of vertices, or of corners if `by_corner` is not 0. A quad is
 * divided from its first corner to its third if the areas of the halves face the same way, else
 * from the second to the fourth. Where single precision could see that otherwise, as with an area
 * of 0, and for five corners and more, the triangles get three times WHITTLE_OPEN, and `open` their
 * number. */
WHITTLE_API whittle_status whittle_triangulate(const whittle_polygons *polygons, int by_corner,
                                               uint32_t *triangles, size_t *open,
                                               whittle_error *error);

/* What a surface does with light; a surface is the sum of its lobes and all zero is black.
 * Per channel and for light at angle theta to the normal, F the exact dielectric reflectance of
 * `ior`, S the Schlick ramp (1 - cos theta)^5:
 *   mirror ray:    mirror + metal_weight (metal + (1 - metal) S) + specular F
 *   refracted ray: transmission (1 - F)
 *   light:         diffuse (1 - F) / pi, or without specular diffuse / pi; with roughness > 0 also
 *                  a GGX highlight
 * With roughness 0 the mirror ray is traced; above, it is not: only lights show, as a GGX
 * highlight, and the world's colour. Refraction is always sharp. */
typedef struct whittle_material {
  float diffuse[3];
  float mirror[3];       /* constant with angle */
  float metal[3];        /* reflectance at normal incidence */
  float metal_weight;    /* 0 to 1 */
  float specular[3];     /* tint of the dielectric reflection */
  float transmission[3]; /* tint of the refracted ray */
  float emission[3];     /* radiance, both sides */
  float ior;             /* 0: 1.5 */
  float roughness;       /* as in Blender: GGX alpha = roughness^2 */
} whittle_material;

typedef enum whittle_light_kind { WHITTLE_POINT = 0, WHITTLE_SUN = 1 } whittle_light_kind;

typedef struct whittle_light {
  whittle_light_kind kind;
  double position[3];  /* point: world position */
  double direction[3]; /* sun: the way its light travels, any length but 0 */
  float intensity[3];  /* point: radiant intensity, W/sr; sun: irradiance, W/m^2 */
  int no_shadow;
} whittle_light;

typedef struct whittle_world {
  float color[3];   /* radiance that rays see which leave the scene */
  float ambient[3]; /* radiance that lights every diffuse surface, unshadowed */
} whittle_world;

/* Each replaces what was set before; they need no new build. A scene without materials is white
 * diffuse (0.8), one without lights is dark. Material indices of meshes are checked at render. */
WHITTLE_API whittle_status whittle_scene_set_materials(whittle_scene *scene,
                                                       const whittle_material *materials,
                                                       size_t count, whittle_error *error);
WHITTLE_API whittle_status whittle_scene_set_lights(whittle_scene *scene,
                                                    const whittle_light *lights, size_t count,
                                                    whittle_error *error);
WHITTLE_API whittle_status whittle_scene_set_world(whittle_scene *scene, const whittle_world *world,
                                                   whittle_error *error);

/* ---- Build ----------------------------------------------------------------------------------- */

typedef struct whittle_build_options {
  uint32_t threads;     /* 0: whittle_default_threads() */
  uint32_t bins;        /* 0: 16; 2 to 64 */
  uint32_t max_leaf;    /* 0: 8; 1 to 64 triangles */
  float traversal_cost; /* 0: 1, in triangle tests */
  int by_instance;      /* a subtree for each instance, kept for the next build by instance */
  int lean; /* no binary tree: sooner, in less memory, but there is nothing to count on */
  whittle_progress progress;
} whittle_build_options;

typedef struct whittle_build_stats {
  uint64_t triangles;          /* in the tree, all instances together */
  uint64_t dropped_non_finite; /* triangles with a vertex that is not finite once placed */
  uint64_t dropped_zero_area;  /* points and lines */
  uint32_t meshes, instances;
  uint32_t nodes, leaves, depth; /* depth: edges from the root to the deepest leaf */
  uint32_t largest_leaf;
  uint32_t threads, bins;
  double sah_cost; /* (C sum of inner areas + sum of count x leaf area) / root area */
  uint64_t bytes;  /* of the finished structures: nodes, indices, triangles, meshes */
  uint64_t bytes_nodes, bytes_triangles, bytes_meshes;
  uint64_t bytes_binary; /* the part of bytes_nodes that a lean build does without, where it is 0 */
  double seconds, seconds_flatten, seconds_tree; /* wall time */
  /* By instance: how many instances there are, and how many of them got a new subtree, the others
   * keeping theirs; whether all did because the scene outgrew its frame, or shrank in it; and the
   * part of seconds_tree that went into the tree over the subtrees and putting all together. */
  uint32_t subtrees, subtrees_built;
  int32_t frame_changed;
  double seconds_join;
  double center[3]; /* what was subtracted from world positions */
  int32_t exponent; /* and then they were divided by 2^exponent */
} whittle_build_stats;

/* Builds or rebuilds everything that tracing needs. `stats` may be NULL. After WHITTLE_CANCELLED or
 * an error the scene is as before the call.
 *
 * By instance, the tree is put together from a subtree for each instance, and a build that follows
 * one with the same options makes only those anew whose transform or mesh has changed. Images and
 * hits have the same bits either way; counters are those of the tree at hand. Rays take longer
 * where instances overlap, which the one tree takes apart.
 *
 * Rays are traced on a tree with eight children to a node and up to eight triangles to a leaf. The
 * binary one that it is made from takes nearly as much memory, and is only there to be looked at. A
 * lean build leaves it out, and does not even divide what will be a leaf of the other: the very
 * same eightfold tree, sooner. Nodes, leaves, depth and SAH cost in `stats` are then those of a
 * binary tree with such leaves, and what needs the finer one fails with WHITTLE_NOT_BUILT: counters
 * of any kind, the cost, the probe, the lecture mode, whittle_scene_tree, whittle_scene_owners and
 * whittle_scene_quality. */
WHITTLE_API whittle_status whittle_scene_build(whittle_scene *scene,
                                               const whittle_build_options *options,
                                               whittle_build_stats *stats, whittle_error *error);

/* Triangles dropped from one mesh (placed by its instances), as counted by the last build. */
WHITTLE_API whittle_status whittle_scene_dropped(const whittle_scene *scene, uint32_t mesh,
                                                 uint64_t *non_finite, uint64_t *zero_area,
                                                 whittle_error *error);

/* One node of the binary tree, as the lecture draws it. Children are adjacent: left at left_first,
 * right at left_first + 1. count > 0 marks a leaf over count entries of the triangle order from
 * left_first on. Node 0 is the root; bounds are in scene space: (world - center) / 2^exponent. */
typedef struct whittle_node {
  float bounds_min[3];
  uint32_t left_first;
  float bounds_max[3];
  uint32_t count;
} whittle_node;

/* The finished tree: owned by the scene, valid until it changes. An empty scene has 0 nodes. */
typedef struct whittle_tree {
  const whittle_node *nodes;
  size_t node_count;
  size_t triangle_count;
} whittle_tree;
WHITTLE_API whittle_status whittle_scene_tree(const whittle_scene *scene, whittle_tree *tree,
                                              whittle_error *error);

/* Copies the triangles in leaf order: vertices float[9] in scene space, the caller's instance and
 * triangle indices. Any pointer may be NULL. */
WHITTLE_API whittle_status whittle_scene_triangles(const whittle_scene *scene, float *vertices,
                                                   uint32_t *instances, uint32_t *triangles,
                                                   whittle_error *error);

/* ---- Quality --------------------------------------------------------------------------------- */

typedef struct whittle_quality_options {
  uint32_t threads;         /* 0: whittle_default_threads() */
  int overlap;              /* measure the overlap: takes long */
  uint64_t overlap_samples; /* triangles that it looks at, evenly spread; 0: every one, exactly */
  int by_instance;          /* a tree of its own for each instance: about the time of a build */
  whittle_progress progress;
} whittle_quality_options;

/* The triangles of one instance or of one material.
 *
 * The fill of a triangle is twice its area over half the surface of its box: 1 for a right triangle
 * with its legs along two axes, near 0 for a long thin one that lies diagonally. Stretch is the
 * part of the surface of shared nodes (with triangles of several instances, or materials) that they
 * would lose, each by itself, without these triangles: who has most of it makes the shared boxes
 * large. */
typedef struct whittle_part_quality {
  uint64_t triangles;
  uint64_t slivers; /* of them with a fill below WHITTLE_SLIVER */
  uint64_t nodes;   /* that hold its triangles only */
  uint64_t bytes;   /* triangles, those nodes, and its share of the meshes by triangles */
  double area;      /* world units */
  double box_fill;  /* mean of its triangles; 0 without any */
  double largest_triangle_share; /* of the area */
  double box_min[3], box_max[3]; /* world space; all 0 without triangles */
  double stretch;                /* 0 to 1 */
  double overlap_part;           /* with overlap: its part in that of the whole tree */
  /* Of an instance, if by_instance. */
  double sah_cost;    /* of a tree of its own, built as the scene's was */
  double stray_share; /* of its box's surface that goes away without at most 1 % of its triangles */
  uint64_t stray_triangles; /* which the top of its own tree sets apart: this many */
  double overlap; /* share of its area in leaf boxes that hold triangles of other instances,
                     by 256 to 16384 points spread evenly over it */
} whittle_part_quality;

#define WHITTLE_SLIVER 0.0625

enum { WHITTLE_DEEPEST = 64, WHITTLE_LARGEST_LEAF = 64 };

typedef struct whittle_quality {
  uint64_t triangles, nodes, leaves, bytes;
  uint32_t depth, largest_leaf;
  double sah_cost; /* as in whittle_build_stats */
  /* With overlap: the sum over nodes of their cost (traversal_cost, of a leaf its triangles) times
   * the area of other triangles in their boxes, over the area of all. */
  double overlap;
  uint64_t overlap_samples;
  double box_fill;
  uint64_t slivers;
  uint64_t depth_histogram[WHITTLE_DEEPEST + 1];          /* leaves by depth */
  uint64_t leaf_size_histogram[WHITTLE_LARGEST_LEAF + 1]; /* leaves by triangles */
  size_t instance_count, material_count;
  whittle_part_quality *instances, *materials;
  double seconds;
} whittle_quality;

/* Judges the built tree; the scene may be traced meanwhile. What it gives is the caller's, to be
 * released with whittle_quality_free; after an error there is nothing to release. */
WHITTLE_API whittle_status whittle_scene_quality(const whittle_scene *scene,
                                                 const whittle_quality_options *options,
                                                 whittle_quality *quality, whittle_error *error);
WHITTLE_API void whittle_quality_free(whittle_quality *quality);

/* ---- Tracing rays ---------------------------------------------------------------------------- */

/* Numbers laid out in memory with any strides, so that arrays of structures, structures of arrays
 * and single values all fit. */
typedef struct whittle_array {
  const void *data;
  int is_double;              /* double instead of float */
  ptrdiff_t stride;           /* bytes from one ray to the next; 0: one value for all */
  ptrdiff_t component_stride; /* bytes from x to y to z */
} whittle_array;

typedef struct whittle_rays {
  size_t count;
  whittle_array origins;    /* world space */
  whittle_array directions; /* any finite non-zero length; t is in units of that length */
  whittle_array t_min;      /* data NULL: 0 */
  whittle_array t_max;      /* data NULL: infinity; a hit has t_min < t <= t_max */
  uint32_t visibility;      /* instances are seen if they share a bit; 0: WHITTLE_ALL */
} whittle_rays;

/* Where results go: one entry a ray; NULL arrays are left out. */
typedef struct whittle_hits {
  float *t;            /* infinity: miss */
  int32_t *instance;   /* -1: miss */
  int32_t *triangle;   /* the caller's index in its mesh; -1: miss */
  float *u, *v;        /* weights of the second and third vertex */
  uint32_t *nodes;     /* nodes that this ray alone visits on the binary tree, root included */
  uint32_t *triangles; /* triangles that it tests */
} whittle_hits;

typedef struct whittle_trace_options {
  uint32_t threads; /* 0: whittle_default_threads() */
  uint32_t packet;  /* consecutive rays traced as one packet: 1: single rays; to 256. 0: 256 where
                       neighbours look alike, and 1 where they do not, chosen for every 256 */
} whittle_trace_options;

/* The nearest hit of each ray; among hits at equal t that of the lowest (instance, triangle).
 * Rays with a non-finite number or a zero direction miss. Asking for nodes or triangles uses the
 * counting single-ray traversal; the hits are the same bits. */
WHITTLE_API whittle_status whittle_intersect(const whittle_scene *scene, const whittle_rays *rays,
                                             const whittle_hits *hits,
                                             const whittle_trace_options *options,
                                             whittle_error *error);

/* Whether anything lies on each ray: blocked[i] = 1 or 0. */
WHITTLE_API whittle_status whittle_occluded(const whittle_scene *scene, const whittle_rays *rays,
                                            uint8_t *blocked, const whittle_trace_options *options,
                                            whittle_error *error);

/* The oracle: every triangle tested in double precision by another formula, no tree. Takes the same
 * rebased float vertices and rays. `nodes` and `triangles` are not written. */
WHITTLE_API whittle_status whittle_reference_intersect(const whittle_scene *scene,
                                                       const whittle_rays *rays,
                                                       const whittle_hits *hits,
                                                       const whittle_trace_options *options,
                                                       whittle_error *error);

/* ---- Rendering ------------------------------------------------------------------------------- */

typedef struct whittle_camera {
  double to_world[16];   /* camera looks along its -z, y is up */
  double projection[16]; /* as OpenGL's: perspective or orthographic, shift and aspect inside */
  double clip_start, clip_end; /* depths along the view; clip_end 0: no far clip */
  uint32_t width, height;      /* of the whole image */
  uint32_t region[4];          /* x0, y0, x1, y1 of what is rendered; all 0: everything */
} whittle_camera;

typedef enum whittle_mode {
  WHITTLE_FAST = 0, /* the automatic choice */
  WHITTLE_LECTURE,  /* binary packets: first ray, frustum, brute force; counts coherence */
  WHITTLE_SINGLE,   /* one ray at a time */
} whittle_mode;

typedef enum whittle_pattern {
  WHITTLE_REGULAR = 0, /* centres of an n x n grid */
  WHITTLE_STRATIFIED,  /* one random point in each cell, by hashing pixel, sample and seed */
} whittle_pattern;

typedef struct whittle_settings {
  uint32_t samples; /* per pixel, a square number: 1 (0), 4, 9, 16, ... 4096 */
  whittle_pattern pattern;
  uint32_t seed;      /* of the stratified pattern */
  uint32_t max_depth; /* bounces after the first hit; 0: 8; up to 64 */
  int no_bounces;     /* depth 0: neither mirror nor refracted rays */
  float cutoff;       /* rays that would add less than this share are dropped; 0: 1/1024 */
  int no_cutoff;      /* drop none but those of weight 0 */
  int transparent;    /* background leaves colour and alpha 0 */
  whittle_mode mode;
  uint32_t packet;  /* rays in a packet: 0: chosen; 1, 16, 64, 256, 1024 */
  uint32_t threads; /* 0: whittle_default_threads() */
  int generic;      /* use the kernel that leaves nothing out */
  whittle_progress progress;
} whittle_settings;

/* The images that a render can make. Counters hold what each pixel's rays cost alone on the binary
 * tree, summed over its samples. Depth is along the view axis, 1e10 where nothing is hit; depth,
 * position, normal and object index are those of the sample nearest the pixel's centre. Coherence
 * is the share, 0 to 1, of rays that entered the nodes which the packets of the pixel's rays
 * visited, over all nodes and packets; 1 where there are none. If counters are wanted too, the rays
 * are traced twice, by packets and counting. */
typedef enum whittle_pass {
  WHITTLE_PASS_COMBINED = 0, /* 4: linear RGB times alpha, alpha */
  WHITTLE_PASS_DEPTH,        /* 1 */
  WHITTLE_PASS_POSITION,     /* 3: world space */
  WHITTLE_PASS_NORMAL,       /* 3: world space, smooth, towards the camera */
  WHITTLE_PASS_OBJECT_INDEX, /* 1 */
  WHITTLE_PASS_NODES,        /* 1: of all rays; then by kind */
  WHITTLE_PASS_NODES_PRIMARY,
  WHITTLE_PASS_NODES_SHADOW,
  WHITTLE_PASS_NODES_REFLECTION,
  WHITTLE_PASS_NODES_REFRACTION,
  WHITTLE_PASS_TRIANGLES,
  WHITTLE_PASS_TRIANGLES_PRIMARY,
  WHITTLE_PASS_TRIANGLES_SHADOW,
  WHITTLE_PASS_TRIANGLES_REFLECTION,
  WHITTLE_PASS_TRIANGLES_REFRACTION,
  WHITTLE_PASS_LEAF_DEPTH, /* 1: the deepest leaf that the pixel's rays visited, in edges from the
                              root; 0: none */
  WHITTLE_PASS_COHERENCE,  /* 1: in the lecture mode only, see above */
  WHITTLE_PASS_SECONDS,    /* 1: wall time of the pixel's tile / its pixels; not reproducible */
  WHITTLE_PASS_COUNT,
} whittle_pass;

/* Name ("combined", "nodes_shadow", ...) and number of channels of a pass. */
WHITTLE_API const char *whittle_pass_name(whittle_pass pass);
WHITTLE_API uint32_t whittle_pass_channels(whittle_pass pass);

enum {
  WHITTLE_RAY_PRIMARY = 0,
  WHITTLE_RAY_SHADOW,
  WHITTLE_RAY_REFLECTION,
  WHITTLE_RAY_REFRACTION,
  WHITTLE_RAY_KINDS
};

/* Who pays for the rays. Each table is the caller's and has WHITTLE_RAY_KINDS rows, of `instances`
 * + 1 or `materials` + 1 columns as whittle_scene_columns gives them. A visit to a node is charged
 * to the instance (material) that all triangles under it belong to, or if they differ to the last
 * column; a test to the triangle's own, so that the last column of tests is 0. Rows add up to the
 * totals of whittle_render_stats. */
typedef struct whittle_cost {
  size_t instances, materials;
  uint64_t *instance_nodes, *instance_triangles;
  uint64_t *material_nodes, *material_triangles;
} whittle_cost;

/* The columns that a whittle_cost needs now, without the last one. */
WHITTLE_API whittle_status whittle_scene_columns(const whittle_scene *scene, size_t *instances,
                                                 size_t *materials, whittle_error *error);

/* Who is charged for each node of the tree: an index, or -1 for the last column. Arrays of
 * node_count entries, either of which may be NULL. */
WHITTLE_API whittle_status whittle_scene_owners(const whittle_scene *scene, int32_t *instances,
                                                int32_t *materials, whittle_error *error);

/* Buffers of region height x region width x channels floats; NULL where a pass is not wanted. A
 * wanted counter pass (of nodes or triangles, or the leaf depth) makes the render count, and so
 * does `cost`, which may be NULL. */
typedef struct whittle_image {
  float *pass[WHITTLE_PASS_COUNT];
  const whittle_cost *cost;
} whittle_image;

/* What a scene and its settings need; the rest is left out of the kernel and of memory. */
enum {
  WHITTLE_NEED_MIRROR = 1,       /* a material reflects sharply */
  WHITTLE_NEED_GLASS = 2,        /* a material transmits */
  WHITTLE_NEED_SMOOTH = 4,       /* a mesh has normals */
  WHITTLE_NEED_LIGHTS = 8,       /* more than one light */
  WHITTLE_NEED_HIGHLIGHT = 16,   /* a reflecting material is rough */
  WHITTLE_NEED_COUNTERS = 32,    /* a counter pass or the cost is wanted */
  WHITTLE_NEED_SAMPLES = 64,     /* more than one sample a pixel */
  WHITTLE_NEED_VISIBILITY = 128, /* an instance is hidden from some rays */
  WHITTLE_NEED_ALL = 255,
};

/* Of the bit of a need: its name ("glass"), and why it can be left out if it is not set. */
WHITTLE_API const char *whittle_need_name(uint32_t need);
WHITTLE_API const char *whittle_need_reason(uint32_t need);

typedef struct whittle_render_stats {
  uint64_t rays[WHITTLE_RAY_KINDS];
  uint64_t nodes[WHITTLE_RAY_KINDS];     /* only with counters */
  uint64_t triangles[WHITTLE_RAY_KINDS]; /* only with counters */
  uint64_t shadow_rays_left_out;         /* lights behind the surface or of weight 0 */
  uint64_t secondary_rays_left_out;      /* below the cut-off or beyond the depth limit */
  double dropped_weight;   /* their summed weight: the bound of the error, per pixel */
  uint64_t own_box_misses; /* hits outside their own padded box: must be 0 */
  /* Only in the lecture mode: how often each of the three tests decided a node for a packet. */
  uint64_t packets, packet_nodes, packet_rays;
  uint64_t decided_first, decided_frustum, decided_brute_force;
  uint64_t active_rays;  /* rays that hit the nodes their packets visited, summed */
  uint64_t visited_rays; /* rays in those packets, summed */
  /* Lanes of the groups of rays that nodes and triangles were tested with, and how many of these
   * held a ray that still looked for a hit and had entered the node above, or the triangle's leaf.
   * They hang on the width of the instruction set, which is `lanes`. */
  uint64_t node_lanes, node_lanes_used, triangle_lanes, triangle_lanes_used;
  double seconds; /* wall time */
  double seconds_primary, seconds_shadow, seconds_secondary,
      seconds_shade; /* summed over threads */
  uint32_t threads;
  uint32_t lanes;        /* rays in a vector */
  uint32_t needs;        /* of the scene and settings */
  uint32_t kernel_needs; /* of the kernel that ran; more than needs only if generic */
  uint64_t bytes;        /* working memory beside the images */
} whittle_render_stats;

/* Renders into `image`, which holds nothing useful after a failure. `stats` may be NULL. */
WHITTLE_API whittle_status whittle_render(const whittle_scene *scene, const whittle_camera *camera,
                                          const whittle_settings *settings,
                                          const whittle_image *image, whittle_render_stats *stats,
                                          whittle_error *error);

/* ---- Probing a pixel --------------------------------------------------------------------------
 */

/* A ray of a pixel, in world space. Its points are origin + t direction; the direction's length
 * says only what unit t has. */
typedef struct whittle_probe_ray {
  uint32_t kind;   /* WHITTLE_RAY_PRIMARY ... */
  uint32_t sample; /* of the pixel, from 0 */
  uint32_t depth;  /* bounces before it; a shadow ray has that of the ray whose hit it starts at */
  int64_t parent;  /* index of the ray that sent it; -1: the camera did */
  int64_t light;   /* index of the light that a shadow ray asks; -1: it is none */
  double origin[3], direction[3];
  float t_min, t_max;
  float t;                              /* infinity: miss */
  int32_t instance, triangle, material; /* -1: miss */
  float u, v;                           /* weights of the second and third vertex */
  const uint32_t *nodes;                /* visited, in order: indices into the tree */
  size_t node_count;
  const uint32_t *triangles; /* tested, in order: indices into the leaf order */
  size_t triangle_count;
} whittle_probe_ray;

/* The rays of a pixel in the order traced. A shadow ray's hit is the first that it found. */
typedef struct whittle_probe {
  const whittle_probe_ray *rays;
  size_t count;
} whittle_probe;

/* The very rays that whittle_render traces for pixel (x, y) of the whole image, and their counts;
 * the camera's region, settings.threads and settings.progress are not used. */
WHITTLE_API whittle_status whittle_probe_pixel(const whittle_scene *scene,
                                               const whittle_camera *camera,
                                               const whittle_settings *settings, uint32_t x,
                                               uint32_t y, whittle_probe **probe,
                                               whittle_error *error);
WHITTLE_API void whittle_probe_release(whittle_probe *probe); /* NULL is fine */

/* ---- Rendering in the background ---------------------------------------------------------------
 */

typedef struct whittle_job whittle_job;

/* Starts whittle_render on a thread of its own. The scene, the buffers of the image and the cost
 * that it points to must outlive the job;
 * settings.progress is not used. */
WHITTLE_API whittle_status whittle_job_start(const whittle_scene *scene,
                                             const whittle_camera *camera,
                                             const whittle_settings *settings,
                                             const whittle_image *image, whittle_job **job,
                                             whittle_error *error);
WHITTLE_API double whittle_job_poll(const whittle_job *job, int *done); /* fraction in [0, 1] */
WHITTLE_API void whittle_job_cancel(whittle_job *job);                  /* returns at once */
/* Waits for the end; gives the render's status and, if it went well, its stats. */
WHITTLE_API whittle_status whittle_job_wait(whittle_job *job, whittle_render_stats *stats,
                                            whittle_error *error);
WHITTLE_API void whittle_job_destroy(whittle_job *job); /* cancels and waits if it still runs */

#ifdef __cplusplus
}
#endif
#endif
