/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* How much surface lies in boxes to which it does not belong. */

#pragma once

#include "base/team.h"
#include "bvh/quality.h"

/* Which triangles are looked at: `count` of them, evenly spread over the leaf order. */
typedef struct whittle_overlap {
  uint64_t count;
  double *foreign; /* of each: its area in other nodes' boxes, times the cost of those nodes */
  double *area;    /* of each */
} whittle_overlap;

/* The triangle that is looked at as number i. */
static inline size_t whittle_overlap_triangle(const whittle_judged *tree, uint64_t count,
                                              uint64_t i) {
  return (size_t)((__extension__(unsigned __int128)(2 * i + 1) * tree->triangle_count) /
                  (2 * count));
}

/* Fills `foreign` and `area`. Called by the leader of a team; adds `count` times
 * WHITTLE_OVERLAP_UNITS to the run's `done`. */
enum { WHITTLE_OVERLAP_UNITS = 64 };
whittle_status whittle_judge_overlap(whittle_team *team, const whittle_judged *tree,
                                     double traversal_cost, whittle_overlap *overlap,
                                     whittle_error *error);

/* Whether a point lies in a leaf that is not `label`'s alone. */
int whittle_in_foreign_leaf(const whittle_judged *tree, const uint32_t *owners, uint32_t label,
                            const double point[3]);
