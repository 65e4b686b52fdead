/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The shape of a tree: how deep its leaves lie, how full they are, what a random ray pays. */

#include "bvh/quality.h"
#include "bvh/measure.h"

typedef struct shape {
  const whittle_node *nodes;
  whittle_quality *quality;
  double inner_area, leaf_cost;
} shape;

static void visit(shape *s, uint32_t index, uint32_t depth) {
  const whittle_node *node = &s->nodes[index];
  if (node->count == 0) {
    s->inner_area += whittle_node_area(node);
    visit(s, node->left_first, depth + 1);
    visit(s, node->left_first + 1, depth + 1);
    return;
  }
  s->leaf_cost += node->count * whittle_node_area(node);
  whittle_quality *q = s->quality;
  q->leaves++;
  q->depth_histogram[depth]++;
  q->leaf_size_histogram[node->count]++;
  q->depth = depth > q->depth ? depth : q->depth;
  q->largest_leaf = node->count > q->largest_leaf ? node->count : q->largest_leaf;
}

void whittle_judge_shape(const whittle_judged *tree, double traversal_cost,
                         whittle_quality *quality) {
  quality->nodes = tree->node_count;
  if (tree->node_count == 0)
    return;
  shape s = {.nodes = tree->nodes, .quality = quality};
  visit(&s, 0, 0);
  const double whole = whittle_node_area(&tree->nodes[0]);
  quality->sah_cost = whole > 0.0 ? (traversal_cost * s.inner_area + s.leaf_cost) / whole : 0.0;
}
