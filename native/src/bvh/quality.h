/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Judging a finished tree: its shape, and who makes its boxes large. */

#pragma once

#include "bvh/bvh.h"

/* A tree with the triangles in its leaves: nine floats each, in leaf order. */
typedef struct whittle_judged {
  const whittle_node *nodes;
  size_t node_count;
  const float *vertices;
  size_t triangle_count;
} whittle_judged;

/* The label of a node that holds triangles of several. */
#define WHITTLE_SHARED UINT32_MAX

/* Fills the counts, histograms and the SAH cost. */
void whittle_judge_shape(const whittle_judged *tree, double traversal_cost,
                         whittle_quality *quality);

/* What a label (an instance, a material) has of the tree. */
typedef struct whittle_label_share {
  uint64_t nodes; /* that hold its triangles only */
  double stretch; /* see whittle_part_quality */
} whittle_label_share;

/* Follows the labels of the triangles up the tree. `owners` (a label for each node, or
 * WHITTLE_SHARED) may be NULL; `shares` has an entry, zeroed, for each label. */
void whittle_judge_labels(const whittle_judged *tree, const uint32_t *labels, uint32_t *owners,
                          whittle_label_share *shares, size_t label_count);
