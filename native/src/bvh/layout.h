/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* From nodes that lie where they were made to the finished array. */

#pragma once

#include "bvh/bvh.h"

/* Nodes made together, next to each other: the children of one large span, or a whole subtree below
 * its root. Each has a place in the order of a depth-first walk: sorted by place, segments come in
 * that order, whoever made them when. */
typedef struct segment {
  const whittle_node *nodes;
  uint32_t count;
  uint32_t place;
  bool subtree; /* inner nodes count their children from the segment's first node; otherwise, and
                   from the root, they name the place of a segment */
  uint32_t target;
  uint32_t leaves, largest_leaf;
  double inner_area, leaf_cost;
} segment;

typedef struct segment_list {
  whittle_node root;
  segment *segments;
  uint32_t count;
} segment_list;

/* Copies all nodes into a new array and fills everything of `bvh` but its depth. */
whittle_status whittle_layout(whittle_team *team, segment_list *list, float traversal_cost,
                              whittle_bvh *bvh, whittle_error *error);
