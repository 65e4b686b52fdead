/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* From nodes spread over reserved places to the finished array. */

#pragma once

#include "bvh/bvh.h"

/* A stretch of nodes that was filled without a gap. Sorted by place, segments are in the order of a
 * depth-first walk, whoever built them. */
typedef struct segment {
  uint64_t place; /* of its first node among the reserved ones */
  uint64_t target;
  uint32_t count;
  uint32_t leaves, largest_leaf;
  double inner_area, leaf_cost;
} segment;

/* Packs `segments` of the reserved nodes into a new array; the root is reserved[0] and no segment
 * holds it. Fills everything of `bvh` but its depth. */
whittle_status whittle_layout(whittle_team *team, const whittle_node *reserved, segment *segments,
                              uint64_t count, float traversal_cost, whittle_bvh *bvh,
                              whittle_error *error);
