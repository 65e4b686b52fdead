/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* A tree with a subtree for each instance: what is kept of each, so that a build redoes only those
 * whose instance has changed. */

#pragma once

#include "scene/grow.h"

/* The first of a subtree's entries in each of the scene's arrays, and the rank of the first
 * triangle of its mesh. */
typedef struct subtree_place {
  uint32_t node, wide, triangle, rank;
} subtree_place;

/* The subtree of one instance. */
typedef struct subtree {
  uint64_t version; /* of the mesh; 0: the instance was removed */
  double transform[16];
  world_bounds bounds;
  whittle_node root;                /* numbered from the subtree's own root and triangles */
  uint32_t nodes, wides, triangles; /* how many: nodes without the root, which the top holds */
  uint32_t leaves, depth, largest_leaf;
  double cost; /* as of a whittle_bvh */
  uint64_t dropped_non_finite, dropped_zero_area;
  subtree_place at;
} subtree;

/* Nodes lie behind the tree over the subtrees, whose size follows from how many they are, and so do
 * wide nodes. What a build makes anew goes to the end: who moves one object again and again
 * rewrites nothing but the end. */
typedef struct scene_subtrees {
  subtree *list; /* by instance */
  size_t count;
  uint32_t *order; /* the instances with triangles in the order of their places */
  uint32_t used;
  scene_frame frame;
  whittle_bvh_options options;
  size_t node_room, wide_room, triangle_room; /* of the scene's arrays */
} scene_subtrees;

void whittle_subtrees_free(scene_subtrees *subtrees); /* NULL is fine */

/* How deep a subtree may be, which leaves the tree over them the rest of WHITTLE_MAX_DEPTH, and how
 * many of them that is enough for. */
enum { SUBTREE_DEPTH = 40, MOST_SUBTREES = 1 << (WHITTLE_MAX_DEPTH - SUBTREE_DEPTH) };
