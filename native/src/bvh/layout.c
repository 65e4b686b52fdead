/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Packing the nodes in depth-first order, and judging them on the way. */

#include "bvh/layout.h"
#include "base/memory.h"
#include "bvh/measure.h"

#include <stdlib.h>

enum { GRAIN = 8 };

typedef struct packing {
  const segment_list *list;
  whittle_node *nodes;
} packing;

static int by_place(const void *a, const void *b) {
  const uint32_t x = ((const segment *)a)->place, y = ((const segment *)b)->place;
  return (x > y) - (x < y);
}

static const segment *segment_at(const segment_list *list, uint32_t place) {
  uint32_t low = 0, high = list->count;
  while (high - low > 1) {
    const uint32_t middle = low + (high - low) / 2;
    if (list->segments[middle].place <= place)
      low = middle;
    else
      high = middle;
  }
  return &list->segments[low];
}

static void judge(segment *s, const whittle_node *node) {
  if (node->count == 0) {
    s->inner_area += whittle_node_area(node);
    return;
  }
  s->leaf_cost += node->count * whittle_node_area(node);
  s->leaves++;
  if (node->count > s->largest_leaf)
    s->largest_leaf = node->count;
}

static void pack(const packing *p, segment *s) {
  for (uint32_t i = 0; i < s->count; i++) {
    whittle_node node = s->nodes[i];
    judge(s, &node);
    if (node.count == 0)
      node.left_first =
          s->subtree ? node.left_first + s->target : segment_at(p->list, node.left_first)->target;
    p->nodes[s->target + i] = node;
  }
}

static void pack_pieces(void *context, uint64_t begin, uint64_t end) {
  const packing *p = context;
  for (uint64_t i = begin; i < end; i++)
    pack(p, &p->list->segments[i]);
}

/* Adds up in the order of places, so that the sums have the same bits for any number of workers. */
static void summarise(const segment_list *list, segment sum, float traversal_cost,
                      whittle_bvh *bvh) {
  for (uint32_t i = 0; i < list->count; i++) {
    const segment *s = &list->segments[i];
    sum.inner_area += s->inner_area;
    sum.leaf_cost += s->leaf_cost;
    sum.leaves += s->leaves;
    if (s->largest_leaf > sum.largest_leaf)
      sum.largest_leaf = s->largest_leaf;
  }
  const double whole = whittle_node_area(&bvh->nodes[0]);
  bvh->leaves = sum.leaves;
  bvh->largest_leaf = sum.largest_leaf;
  bvh->cost = (double)traversal_cost * sum.inner_area + sum.leaf_cost;
  bvh->sah_cost = whole > 0.0 ? bvh->cost / whole : 0.0;
}

whittle_status whittle_layout(whittle_team *team, segment_list *list, float traversal_cost,
                              whittle_bvh *bvh, whittle_error *error) {
  qsort(list->segments, list->count, sizeof *list->segments, by_place);
  uint32_t nodes = 1;
  for (uint32_t i = 0; i < list->count; i++) {
    list->segments[i].target = nodes;
    nodes += list->segments[i].count;
  }
  bvh->block = whittle_allocate((size_t)nodes + 1, sizeof *bvh->block);
  if (!bvh->block)
    return whittle_out_of_memory(error, "the nodes of the tree");
  bvh->nodes = bvh->block + 1;
  bvh->node_count = nodes;
  packing p = {list, bvh->nodes};
  whittle_team_for(team, list->count, GRAIN, pack_pieces, &p);
  segment root = {.nodes = &list->root, .count = 1};
  pack(&p, &root);
  summarise(list, root, traversal_cost, bvh);
  return WHITTLE_OK;
}
