/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Collapses the binary tree into the wide one. */

#include "bvh/wide.h"

#include "base/memory.h"

#include <string.h>

/* First triangle and number of triangles below a binary node. */
typedef struct span {
  uint32_t first, count;
} span;

typedef struct collapse {
  const whittle_node *nodes;
  span *spans;
  wide_node *wide;
  uint32_t *sources; /* the binary node that each wide node stands for */
  uint32_t count;
  whittle_run_state *state;
} collapse;

/* Asked now and then: a cancelled build must end at once. */
static bool stop(const collapse *c, size_t i) {
  return i % 16384 == 0 && whittle_cancelled(c->state);
}

/* Children come after their parents, so one pass from the end knows both spans in time. */
static void find_spans(collapse *c, size_t node_count) {
  for (size_t i = node_count; i-- > 0 && !stop(c, i);) {
    const whittle_node *node = &c->nodes[i];
    c->spans[i] = (span){node->left_first, node->count};
    if (node->count > 0)
      continue;
    const span left = c->spans[node->left_first], right = c->spans[node->left_first + 1];
    c->spans[i].first = left.first < right.first ? left.first : right.first;
    c->spans[i].count = left.count + right.count;
  }
}

static float half_area(const whittle_node *node) {
  const float x = node->bounds_max[0] - node->bounds_min[0];
  const float y = node->bounds_max[1] - node->bounds_min[1];
  const float z = node->bounds_max[2] - node->bounds_min[2];
  return (x * y + y * z) + z * x;
}

static bool is_leaf(const collapse *c, uint32_t node) {
  return c->nodes[node].count > 0 || c->spans[node].count <= WHITTLE_WIDE_LEAF;
}

/* The up to eight descendants that become the children of a node. */
static uint32_t choose_children(const collapse *c, uint32_t source,
                                uint32_t chosen[WHITTLE_WIDTH]) {
  uint32_t n = 1;
  chosen[0] = source;
  while (n < WHITTLE_WIDTH) {
    uint32_t widest = n;
    float most = -1.0f;
    for (uint32_t i = 0; i < n; i++) {
      const float area = half_area(&c->nodes[chosen[i]]);
      if (!is_leaf(c, chosen[i]) && area > most)
        widest = i, most = area;
    }
    if (widest == n)
      break;
    const uint32_t left = c->nodes[chosen[widest]].left_first;
    chosen[widest] = left;
    chosen[n++] = left + 1;
  }
  return n;
}

static void fill(collapse *c, uint32_t index) {
  wide_node *wide = &c->wide[index];
  uint32_t chosen[WHITTLE_WIDTH];
  const uint32_t n = choose_children(c, c->sources[index], chosen);
  memset(wide, 0xff, sizeof *wide); /* every float a NaN */
  for (uint32_t i = 0; i < n; i++) {
    const whittle_node *node = &c->nodes[chosen[i]];
    for (int axis = 0; axis < 3; axis++) {
      wide->low[axis][i] = node->bounds_min[axis];
      wide->high[axis][i] = node->bounds_max[axis];
    }
    if (is_leaf(c, chosen[i])) {
      wide->child[i] = (wide_child){c->spans[chosen[i]].first, c->spans[chosen[i]].count};
    } else {
      wide->child[i] = (wide_child){c->count, wide_node_kind(node)};
      c->sources[c->count++] = chosen[i];
    }
  }
}

wide_node *whittle_bvh_widen(const whittle_node *nodes, size_t node_count, whittle_run_state *state,
                             uint32_t *count, whittle_error *error) {
  /* Every wide node but the root opens at least one inner node of its own. */
  const size_t most = node_count / 2 + 1;
  collapse c = {.nodes = nodes, .count = node_count > 0, .state = state};
  c.spans = whittle_allocate(node_count, sizeof *c.spans);
  c.sources = whittle_allocate(most, sizeof *c.sources);
  c.wide = whittle_allocate(most, sizeof *c.wide);
  if (c.spans && c.sources && c.wide) {
    find_spans(&c, node_count);
    c.sources[0] = 0;
    for (uint32_t i = 0; i < c.count && !stop(&c, i); i++)
      fill(&c, i);
    *count = c.count;
    c.wide = whittle_shrink(c.wide, c.count * sizeof *c.wide);
  } else {
    whittle_release(c.wide);
    c.wide = NULL;
    whittle_out_of_memory(error, "the wide tree");
  }
  whittle_release(c.spans);
  whittle_release(c.sources);
  return c.wide;
}
