/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Collapses the binary tree into the wide one. */

#include "bvh/wide.h"

#include "base/memory.h"

#include <string.h>

/* First triangle and number of triangles below a binary node; and where its costs stand, if it is
 * to be opened. */
typedef struct span {
  uint32_t first, count, costs;
} span;

#define NOT_OPENED UINT32_MAX

/* The least sum of the areas of wide nodes at and below a binary node, if the one above takes at
 * most 1, 2, ... 7 children from there: it falls with their number. Leaves are the same whatever is
 * chosen, and cost nothing. */
typedef struct costs {
  float as[WHITTLE_WIDTH];
} costs;

typedef struct collapse {
  const whittle_node *nodes;
  span *spans;
  costs *costs;
  uint32_t cost_count;
  wide_node *wide;
  uint32_t *sources; /* the binary node that each wide node stands for */
  uint32_t count;
  whittle_run_state *state;
} collapse;

/* Asked now and then: a cancelled build must end at once. */
static bool stop(const collapse *c, size_t i) {
  return i % 16384 == 0 && whittle_cancelled(c->state);
}

static float half_area(const whittle_node *node) {
  const float x = node->bounds_max[0] - node->bounds_min[0];
  const float y = node->bounds_max[1] - node->bounds_min[1];
  const float z = node->bounds_max[2] - node->bounds_min[2];
  return (x * y + y * z) + z * x;
}

/* The least cost of i children, j of them from the left: the sum of both sides at best. */
static void share_out(const costs *left, const costs *right, float best[WHITTLE_WIDTH]) {
  float padded[2 * WHITTLE_WIDTH];
  for (uint32_t i = 0; i < WHITTLE_WIDTH; i++) {
    padded[i] = best[i] = __builtin_inff();
    padded[WHITTLE_WIDTH + i] = right->as[i];
  }
  for (uint32_t j = 1; j < WHITTLE_WIDTH; j++)
    for (uint32_t i = 0; i < WHITTLE_WIDTH; i++) {
      const float sum = left->as[j - 1] + padded[WHITTLE_WIDTH + i - j];
      best[i] = sum < best[i] ? sum : best[i];
    }
}

static const costs nothing = {{0}};

static const costs *costs_of(const collapse *c, uint32_t node) {
  const uint32_t at = c->spans[node].costs;
  return at == NOT_OPENED ? &nothing : &c->costs[at];
}

static void find_costs(collapse *c, const whittle_node *node, costs *to) {
  float best[WHITTLE_WIDTH];
  share_out(costs_of(c, node->left_first), costs_of(c, node->left_first + 1), best);
  to->as[0] = half_area(node) + best[WHITTLE_WIDTH - 1];
  for (uint32_t i = 1; i < WHITTLE_WIDTH; i++)
    to->as[i] = best[i] < to->as[i - 1] ? best[i] : to->as[i - 1];
}

/* Children come after their parents, so one pass from the end knows both in time. */
static void find_spans(collapse *c, size_t node_count) {
  for (size_t i = node_count; i-- > 0 && !stop(c, i);) {
    const whittle_node *node = &c->nodes[i];
    c->spans[i] = (span){node->left_first, node->count, NOT_OPENED};
    if (node->count > 0)
      continue;
    const span left = c->spans[node->left_first], right = c->spans[node->left_first + 1];
    c->spans[i].first = left.first < right.first ? left.first : right.first;
    c->spans[i].count = left.count + right.count;
    if (c->spans[i].count <= WHITTLE_WIDE_LEAF)
      continue;
    find_costs(c, node, &c->costs[c->cost_count]);
    c->spans[i].costs = c->cost_count++;
  }
}

static bool is_leaf(const collapse *c, uint32_t node) {
  return c->spans[node].costs == NOT_OPENED;
}

/* The descendants that a node is best replaced by, at most `most`, which is 2 or more. */
static uint32_t choose_children(const collapse *c, uint32_t source, uint32_t most,
                                uint32_t *chosen) {
  if (is_leaf(c, source)) {
    chosen[0] = source;
    return 1;
  }
  const uint32_t child[2] = {c->nodes[source].left_first, c->nodes[source].left_first + 1};
  const costs *left = costs_of(c, child[0]), *right = costs_of(c, child[1]);
  uint32_t shares[2] = {1, most - 1}, n = 0;
  for (uint32_t j = 2; j < most; j++)
    if (left->as[j - 1] + right->as[most - j - 1] <
        left->as[shares[0] - 1] + right->as[shares[1] - 1])
      shares[0] = j, shares[1] = most - j;
  for (uint32_t side = 0; side < 2; side++) {
    const costs *own = side ? right : left;
    uint32_t share = shares[side];
    while (share > 1 && own->as[share - 2] <= own->as[share - 1])
      share--;
    if (share == 1)
      chosen[n++] = child[side];
    else
      n += choose_children(c, child[side], share, chosen + n);
  }
  return n;
}

static void fill(collapse *c, uint32_t index) {
  wide_node *wide = &c->wide[index];
  uint32_t chosen[WHITTLE_WIDTH];
  const uint32_t n = choose_children(c, c->sources[index], WHITTLE_WIDTH, chosen);
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
  c.costs = whittle_allocate(most, sizeof *c.costs);
  c.sources = whittle_allocate(most, sizeof *c.sources);
  c.wide = whittle_allocate(most, sizeof *c.wide);
  if (c.spans && c.costs && c.sources && c.wide) {
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
  whittle_release(c.costs);
  whittle_release(c.sources);
  return c.wide;
}
