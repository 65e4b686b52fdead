/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Packing the nodes in depth-first order, and judging them on the way. */

#include "bvh/layout.h"
#include "base/memory.h"

#include <stdlib.h>

enum { GRAIN = 8 };

typedef struct packing {
  const whittle_node *reserved;
  segment *segments;
  uint64_t count;
  whittle_node *nodes;
} packing;

static int by_place(const void *a, const void *b) {
  const uint64_t x = ((const segment *)a)->place, y = ((const segment *)b)->place;
  return (x > y) - (x < y);
}

static const segment *segment_at(const packing *p, uint64_t place) {
  uint64_t low = 0, high = p->count;
  while (high - low > 1) {
    const uint64_t middle = low + (high - low) / 2;
    if (p->segments[middle].place <= place)
      low = middle;
    else
      high = middle;
  }
  return &p->segments[low];
}

static double half_area(const whittle_node *node) {
  double side[3];
  for (int i = 0; i < 3; i++)
    side[i] = (double)node->bounds_max[i] - (double)node->bounds_min[i];
  return side[0] * side[1] + side[1] * side[2] + side[2] * side[0];
}

static void judge(segment *s, const whittle_node *node) {
  if (node->count == 0) {
    s->inner_area += half_area(node);
    return;
  }
  s->leaf_cost += node->count * half_area(node);
  s->leaves++;
  if (node->count > s->largest_leaf)
    s->largest_leaf = node->count;
}

static void pack(packing *p, segment *s) {
  for (uint32_t i = 0; i < s->count; i++) {
    whittle_node node = p->reserved[s->place + i];
    judge(s, &node);
    if (node.count == 0) {
      const uint64_t child = node.left_first;
      const segment *home = child - s->place < s->count ? s : segment_at(p, child);
      node.left_first = (uint32_t)(child - home->place + home->target);
    }
    p->nodes[s->target + i] = node;
  }
}

static void pack_pieces(void *context, uint64_t begin, uint64_t end) {
  packing *p = context;
  for (uint64_t i = begin; i < end; i++)
    pack(p, &p->segments[i]);
}

whittle_status whittle_layout(whittle_team *team, const whittle_node *reserved, segment *segments,
                              uint64_t count, float traversal_cost, whittle_bvh *bvh,
                              whittle_error *error) {
  uint64_t nodes = 1;
  qsort(segments, count, sizeof *segments, by_place);
  for (uint64_t i = 0; i < count; i++) {
    segments[i].target = nodes;
    nodes += segments[i].count;
  }
  bvh->block = whittle_allocate(nodes + 1, sizeof *bvh->block);
  if (!bvh->block)
    return whittle_out_of_memory(error, "the nodes of the tree");
  bvh->nodes = bvh->block + 1;
  bvh->node_count = (uint32_t)nodes;
  packing p = {reserved, segments, count, bvh->nodes};
  whittle_team_for(team, count, GRAIN, pack_pieces, &p);
  segment sum = {.place = 0};
  segment root = {.place = 0, .target = 0, .count = 1};
  pack(&p, &root);
  sum = root;
  for (uint64_t i = 0; i < count; i++) {
    sum.inner_area += segments[i].inner_area;
    sum.leaf_cost += segments[i].leaf_cost;
    sum.leaves += segments[i].leaves;
    if (segments[i].largest_leaf > sum.largest_leaf)
      sum.largest_leaf = segments[i].largest_leaf;
  }
  const double whole = half_area(&bvh->nodes[0]);
  bvh->leaves = sum.leaves;
  bvh->largest_leaf = sum.largest_leaf;
  bvh->sah_cost = whole > 0.0 ? (traversal_cost * sum.inner_area + sum.leaf_cost) / whole : 0.0;
  return WHITTLE_OK;
}
