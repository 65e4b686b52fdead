/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The scene as the core holds it. */

#pragma once

#include "base/error.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Those of a mesh's arrays that are copies; NULL where it reads the caller's. */
typedef struct mesh_memory {
  float *positions;
  uint32_t *triangles;
  float *normals;
  uint32_t *materials;
} mesh_memory;

typedef struct mesh {
  const float *positions;
  const uint32_t *triangles;
  const float *normals;      /* NULL: flat */
  const uint32_t *materials; /* NULL: all 0 */
  mesh_memory own;
  void (*release)(void *owner); /* gives back the arrays that are not our own; or NULL */
  void *owner;
  uint8_t *used; /* by vertex: is a corner of a finite triangle; NULL: all are */
  size_t vertex_count, triangle_count;
  bool normals_by_corner;
  uint64_t version; /* of positions and triangles: no other mesh of the scene ever had it */
  uint64_t dropped_non_finite, dropped_zero_area; /* by the last build */
} mesh;

typedef struct instance {
  double transform[16];
  float
      normal_matrix[9]; /* inverse transpose of the upper 3x3 scaled to about unit size, by rows */
  uint32_t mesh;
  int32_t object_id;
  uint32_t visibility;
  float side;   /* -1 if the transform mirrors, else 1: turns cross(e1, e2) outwards */
  bool removed; /* only its number is left: it has no triangles and is seen by all rays */
} instance;

/* Whose triangle it is; the order of these decides between equal t. */
typedef struct triangle_id {
  uint32_t instance;
  uint32_t triangle; /* the caller's index in its mesh */
} triangle_id;

/* Triangles in leaf order, in blocks: those of one leaf, up to eight. A block of n has nine rows of
 * n floats: x of the first vertices, y, z, then those of the second and of the third vertices. What
 * a hit alone needs is kept apart from what every test reads. See scene/triangles.h. */
typedef struct triangle_store {
  float *rows;
  triangle_id *ids;
  uint8_t *places; /* index in the block, and its size */
} triangle_store;

/* Scene space is (world - center) / 2^exponent; center is a multiple of 2^exponent on each axis,
 * which is at least the scene's extent: small moves of an object keep all other bits. */
typedef struct scene_frame {
  double center[3];
  int exponent;
} scene_frame;

struct whittle_scene {
  mesh *meshes;
  size_t mesh_count, mesh_capacity;
  uint64_t mesh_version; /* the last one given to a mesh */
  instance *instances;
  size_t instance_count, instance_capacity;
  whittle_material *materials; /* never empty: material 0 is the default until some are set */
  size_t material_count;
  whittle_light *lights;
  size_t light_count;
  whittle_world world;

  /* What a build makes, replaced as a whole when the next one succeeds. */
  scene_frame frame;
  whittle_node *nodes;      /* node 1 starts a cache line, so that siblings share one; or NULL */
  whittle_node *node_block; /* what to release: nodes - 1 */
  size_t node_count;        /* 0 if the build was lean */
  struct wide_node *wide;   /* the same tree with eight children to a node: bvh/wide.h */
  uint32_t wide_count;
  triangle_store triangles;
  size_t triangle_count;
  whittle_build_options options;   /* of the build, with the defaults filled in; no progress */
  struct scene_subtrees *subtrees; /* their places in the arrays above: subtrees.h; or NULL */
  whittle_build_stats stats;
  bool built;

  /* -1: being changed or built; n > 0: traced by n calls. */
  atomic_int users;
};

/* Enter and leave for readers (trace, render) and writers; enter fails with WHITTLE_BUSY, and for
 * readers with WHITTLE_NOT_BUILT. */
whittle_status whittle_scene_read_begin(const whittle_scene *scene, whittle_error *error);
void whittle_scene_read_end(const whittle_scene *scene);
/* WHITTLE_NOT_BUILT for readers of a lean scene: `what` needs the binary tree. */
whittle_status whittle_scene_has_binary(const whittle_scene *scene, const char *what,
                                        whittle_error *error);
whittle_status whittle_scene_write_begin(whittle_scene *scene, whittle_error *error);
void whittle_scene_write_end(whittle_scene *scene);
