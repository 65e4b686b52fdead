/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* From nodes in the order in which they were made to the finished array. */

#pragma once

#include "bvh/bvh.h"

/* Nodes made together, next to each other in the pool: the children of one large span, or a whole
 * subtree below its root. Each has a place in the order of a depth-first walk: sorted by place,
 * segments come in that order, whoever made them when. */
typedef struct segment {
  uint32_t place;
  bool subtree;    /* inner nodes count their children from the segment's first node; otherwise, */
  uint32_t source; /* and from the root, they name the place of a segment */
  uint32_t target;
  uint32_t count;
  uint32_t leaves, largest_leaf;
  double inner_area, leaf_cost;
} segment;

typedef struct node_pool {
  whittle_node root;
  whittle_node *nodes;
  segment *segments;
  uint32_t node_count, segment_count;
} node_pool;

/* Copies the pool's nodes into a new array and fills everything of `bvh` but its depth. */
whittle_status whittle_layout(whittle_team *team, node_pool *pool, float traversal_cost,
                              whittle_bvh *bvh, whittle_error *error);
