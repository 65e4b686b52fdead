/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* A tree with a subtree for each instance: what is kept of each, so that a build redoes only those
 * whose instance has changed. */

#pragma once

#include "scene/grow.h"

/* The first of a subtree's entries in each of the scene's arrays. */
typedef struct subtree_place {
  uint32_t node, wide, triangle;
} subtree_place;

/* Subtrees are taken apart near their roots, and these are the pieces that the tree over all of
 * them is made of. Its root is held by that tree. Numbers count from the subtree's first node, wide
 * node and triangle. */
typedef struct subtree_piece {
  whittle_node root;
  uint32_t first_node, nodes, first_wide, wides, first_triangle, triangles;
  uint32_t depth; /* below the root */
} subtree_piece;

/* The subtree of one instance. */
typedef struct subtree {
  uint64_t version; /* of the mesh; 0: the instance was removed */
  double transform[16];
  world_bounds bounds;
  uint32_t first_piece, pieces;     /* in the list of all */
  uint32_t nodes, wides, triangles; /* how many: nodes below the roots of the pieces */
  uint32_t leaves, largest_leaf;
  double cost; /* of the pieces together, as of a whittle_bvh */
  uint64_t dropped_non_finite, dropped_zero_area;
  subtree_place at;
} subtree;

/* Nodes lie behind the tree over the pieces, whose size follows from how many they are, and so do
 * wide nodes. What a build makes anew goes to the end: who moves one object again and again
 * rewrites nothing but the end. */
typedef struct scene_subtrees {
  subtree *list; /* by instance */
  size_t count;
  uint32_t *order; /* the instances with triangles in the order of their places */
  uint32_t used;
  subtree_piece *pieces; /* by instance */
  uint32_t piece_count;
  scene_frame frame;
  whittle_bvh_options options;
  size_t node_room, wide_room, triangle_room; /* of the scene's arrays */
} scene_subtrees;

void whittle_subtrees_free(scene_subtrees *subtrees); /* NULL is fine */

/* How deep a subtree may be: that leaves the tree over the pieces 24 levels, enough for 2^24. With
 * 256 triangles to a piece, that is half of them for the instances and half for the other pieces.
 */
enum { SUBTREE_DEPTH = 40, PIECE_TRIANGLES = 256, MOST_SUBTREES = 1 << 23 };
