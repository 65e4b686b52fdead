/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Collapses the binary tree into the wide one: costs from the leaves up, branch by branch; then the
 * wide nodes from the root down, piece by piece. Branches and pieces depend on the tree alone. */

#include "bvh/wide.h"

#include "base/memory.h"

#include <string.h>

/* Nodes in a branch, and how many at least of a tree's triangles are in a piece or in all. */
enum { BRANCH = 1024, PIECES = 64, LEAST_PIECE = 512, NO_MORE = 0 };

/* For an inner node: the least sum of the areas of wide nodes at and below it, if the one above
 * takes at most 1, 2, ... 7 children from there: it falls with their number. Leaves are the same
 * whatever is chosen, and cost nothing. Once it is settled that a wide node stands for the node,
 * its children instead, ended by NO_MORE if they are fewer than eight. */
typedef union plan {
  float as[WHITTLE_WIDTH];
  uint32_t chosen[WHITTLE_WIDTH];
} plan;

/* A node and the end of what is below it. */
typedef struct branch {
  uint32_t node, end;
} branch;

/* A node whose subtree is widened by one worker, and its place among the wide nodes. */
typedef struct piece {
  uint32_t source, first, count;
} piece;

typedef struct collapse {
  const whittle_node *nodes;
  uint32_t *counts; /* of the triangles below each inner node */
  plan *plans;      /* by pairs of children */
  branch *branches;
  uint32_t *above; /* nodes over the branches, parents first; later those over the pieces */
  uint32_t branch_count, above_count;
  piece *pieces;
  uint32_t piece_count, most; /* most: triangles in a piece */
  wide_node *wide;
  uint32_t count;
} collapse;

static float half_area(const whittle_node *node) {
  const float x = node->bounds_max[0] - node->bounds_min[0];
  const float y = node->bounds_max[1] - node->bounds_min[1];
  const float z = node->bounds_max[2] - node->bounds_min[2];
  return (x * y + y * z) + z * x;
}

/* The least cost of i children, j of them from the left: the sum of both sides at best. */
static void share_out(const plan *left, const plan *right, float best[WHITTLE_WIDTH]) {
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

static uint32_t count_of(const collapse *c, uint32_t node) {
  return c->nodes[node].count ? c->nodes[node].count : c->counts[node];
}

static bool is_leaf(const collapse *c, uint32_t node) {
  return c->nodes[node].count > 0 || c->counts[node] <= WHITTLE_WIDE_LEAF;
}

/* Pairs of children lie at 1 and 2, 3 and 4, ... */
static plan *own_plan(const collapse *c, uint32_t node) {
  return &c->plans[c->nodes[node].left_first / 2];
}

static const plan nothing = {{0}};

static const plan *plan_of(const collapse *c, uint32_t node) {
  return is_leaf(c, node) ? &nothing : own_plan(c, node);
}

static void find_costs(const collapse *c, uint32_t index) {
  const whittle_node *node = &c->nodes[index];
  if (node->count > 0)
    return;
  c->counts[index] = count_of(c, node->left_first) + count_of(c, node->left_first + 1);
  if (is_leaf(c, index))
    return;
  float best[WHITTLE_WIDTH];
  plan *to = own_plan(c, index);
  share_out(plan_of(c, node->left_first), plan_of(c, node->left_first + 1), best);
  to->as[0] = half_area(node) + best[WHITTLE_WIDTH - 1];
  for (uint32_t i = 1; i < WHITTLE_WIDTH; i++)
    to->as[i] = best[i] < to->as[i - 1] ? best[i] : to->as[i - 1];
}

/* What is below a node follows in depth-first order. Cuts it into branches. */
static void cut(collapse *c, branch whole) {
  const whittle_node *node = &c->nodes[whole.node];
  if (node->count > 0)
    return;
  if (whole.end - node->left_first <= BRANCH) {
    c->branches[c->branch_count++] = whole;
    return;
  }
  c->above[c->above_count++] = whole.node;
  const whittle_node *right = &c->nodes[node->left_first + 1];
  cut(c, (branch){node->left_first, right->count ? whole.end : right->left_first});
  cut(c, (branch){node->left_first + 1, whole.end});
}

/* Children come after their parents, so one pass from the end knows both in time. */
static void cost_branches(void *context, uint64_t begin, uint64_t end) {
  const collapse *c = context;
  for (uint64_t k = begin; k < end; k++) {
    const branch branch = c->branches[k];
    for (uint32_t i = branch.end; i-- > c->nodes[branch.node].left_first;)
      find_costs(c, i);
    find_costs(c, branch.node);
  }
}

/* The descendants that a node is best replaced by, at most `most`, which is 2 or more. */
static uint32_t choose_children(const collapse *c, uint32_t source, uint32_t most,
                                uint32_t *chosen) {
  if (is_leaf(c, source)) {
    chosen[0] = source;
    return 1;
  }
  const uint32_t child[2] = {c->nodes[source].left_first, c->nodes[source].left_first + 1};
  const plan *left = plan_of(c, child[0]), *right = plan_of(c, child[1]);
  uint32_t shares[2] = {1, most - 1}, n = 0;
  for (uint32_t j = 2; j < most; j++)
    if (left->as[j - 1] + right->as[most - j - 1] <
        left->as[shares[0] - 1] + right->as[shares[1] - 1])
      shares[0] = j, shares[1] = most - j;
  for (uint32_t side = 0; side < 2; side++) {
    const plan *own = side ? right : left;
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

/* Settles what a wide node in the place of this one has for children. */
static const uint32_t *settle(const collapse *c, uint32_t source) {
  uint32_t chosen[WHITTLE_WIDTH];
  plan *own = own_plan(c, source);
  uint32_t n = choose_children(c, source, WHITTLE_WIDTH, chosen);
  while (n < WHITTLE_WIDTH)
    chosen[n++] = NO_MORE;
  memcpy(own->chosen, chosen, sizeof chosen);
  return own->chosen;
}

/* Settles all from a node on down and counts the wide nodes. */
static uint32_t settle_below(const collapse *c, uint32_t source) {
  const uint32_t *chosen = settle(c, source);
  uint32_t count = 1;
  for (uint32_t i = 0; i < WHITTLE_WIDTH && chosen[i] != NO_MORE; i++)
    count += is_leaf(c, chosen[i]) ? 0 : settle_below(c, chosen[i]);
  return count;
}

static void settle_pieces(void *context, uint64_t begin, uint64_t end) {
  const collapse *c = context;
  for (uint64_t k = begin; k < end; k++)
    c->pieces[k].count = settle_below(c, c->pieces[k].source);
}

/* Settles the wide nodes that are too large for a piece, breadth first: their numbers are their
 * places in `above`. */
static void settle_above(collapse *c) {
  if (c->counts[0] <= c->most) {
    c->pieces[c->piece_count++].source = 0;
    return;
  }
  c->above[c->above_count++] = 0;
  for (uint32_t k = 0; k < c->above_count; k++) {
    const uint32_t *chosen = settle(c, c->above[k]);
    for (uint32_t i = 0; i < WHITTLE_WIDTH && chosen[i] != NO_MORE; i++)
      if (!is_leaf(c, chosen[i]) && c->counts[chosen[i]] > c->most)
        c->above[c->above_count++] = chosen[i];
      else if (!is_leaf(c, chosen[i]))
        c->pieces[c->piece_count++].source = chosen[i];
  }
}

static wide_node *clear_node(const collapse *c, uint32_t index) {
  return memset(&c->wide[index], 0xff, sizeof *c->wide); /* every float a NaN */
}

static void set_child(const collapse *c, wide_node *wide, uint32_t i, uint32_t source,
                      uint32_t index) {
  const whittle_node *node = &c->nodes[source], *first = node;
  for (int axis = 0; axis < 3; axis++) {
    wide->low[axis][i] = node->bounds_min[axis];
    wide->high[axis][i] = node->bounds_max[axis];
  }
  while (first->count == 0)
    first = &c->nodes[first->left_first];
  wide->child[i] = is_leaf(c, source) ? (wide_child){first->left_first, count_of(c, source)}
                                      : (wide_child){index, wide_node_kind(node)};
}

/* Fills a node and all below it; what is below goes from `next` on. */
static uint32_t fill(const collapse *c, uint32_t source, uint32_t index, uint32_t next) {
  const uint32_t *chosen = own_plan(c, source)->chosen;
  wide_node *wide = clear_node(c, index);
  for (uint32_t i = 0; i < WHITTLE_WIDTH && chosen[i] != NO_MORE; i++) {
    set_child(c, wide, i, chosen[i], next);
    next += !is_leaf(c, chosen[i]);
  }
  for (uint32_t i = 0; i < WHITTLE_WIDTH && chosen[i] != NO_MORE; i++)
    if (!is_leaf(c, chosen[i]))
      next = fill(c, chosen[i], wide->child[i].first, next);
  return next;
}

static void fill_pieces(void *context, uint64_t begin, uint64_t end) {
  const collapse *c = context;
  for (uint64_t k = begin; k < end; k++)
    fill(c, c->pieces[k].source, c->pieces[k].first, c->pieces[k].first + 1);
}

/* In the order in which settle_above found the children. */
static void fill_above(const collapse *c) {
  uint32_t next = 1;
  const piece *piece = c->pieces;
  for (uint32_t k = 0; k < c->above_count; k++) {
    const uint32_t *chosen = own_plan(c, c->above[k])->chosen;
    wide_node *wide = clear_node(c, k);
    for (uint32_t i = 0; i < WHITTLE_WIDTH && chosen[i] != NO_MORE; i++) {
      const bool in_piece = !is_leaf(c, chosen[i]) && c->counts[chosen[i]] <= c->most;
      set_child(c, wide, i, chosen[i], in_piece ? piece->first : next);
      piece += in_piece;
      next += !in_piece && !is_leaf(c, chosen[i]);
    }
  }
}

/* Of a cancelled run nothing may be read: not even the nodes need be there. */
static void find_all_costs(collapse *c, whittle_team *team, size_t node_count) {
  if (whittle_cancelled(team->state))
    return;
  cut(c, (branch){0, (uint32_t)node_count});
  whittle_team_for(team, c->branch_count, 1, cost_branches, c);
  if (!whittle_cancelled(team->state))
    while (c->above_count)
      find_costs(c, c->above[--c->above_count]);
}

static void settle_all(collapse *c, whittle_team *team) {
  c->most = c->counts[0] / PIECES > LEAST_PIECE ? c->counts[0] / PIECES : LEAST_PIECE;
  settle_above(c);
  whittle_team_for(team, c->piece_count, 1, settle_pieces, c);
  c->count = c->above_count;
  for (uint32_t k = 0; k < c->piece_count; k++) {
    c->pieces[k].first = c->count;
    c->count += c->pieces[k].count;
  }
}

static void fill_all(collapse *c, whittle_team *team) {
  if (is_leaf(c, 0)) {
    set_child(c, clear_node(c, 0), 0, 0, 0);
    return;
  }
  fill_above(c);
  whittle_team_for(team, c->piece_count, 1, fill_pieces, c);
}

static whittle_status widen(collapse *c, whittle_team *team, size_t node_count,
                            whittle_error *error) {
  if (node_count > 0) {
    c->count = 1;
    find_all_costs(c, team, node_count);
    if (!whittle_cancelled(team->state) && !is_leaf(c, 0))
      settle_all(c, team);
  }
  if (whittle_cancelled(team->state))
    c->count = 0;
  c->wide = whittle_allocate(c->count, sizeof *c->wide);
  if (!c->wide)
    return whittle_out_of_memory(error, "the wide tree");
  if (c->count)
    fill_all(c, team);
  return WHITTLE_OK;
}

wide_node *whittle_bvh_widen(whittle_team *team, const whittle_node *nodes, size_t node_count,
                             uint32_t *count, whittle_error *error) {
  const size_t inner = node_count / 2 + 1;
  collapse c = {.nodes = nodes};
  c.counts = whittle_allocate(node_count, sizeof *c.counts);
  c.plans = whittle_allocate(inner, sizeof *c.plans);
  c.branches = whittle_allocate(inner, sizeof *c.branches);
  c.above = whittle_allocate(inner, sizeof *c.above);
  c.pieces = whittle_allocate(inner, sizeof *c.pieces);
  if (c.counts && c.plans && c.branches && c.above && c.pieces)
    widen(&c, team, node_count, error);
  else
    whittle_out_of_memory(error, "the wide tree");
  whittle_release(c.counts);
  whittle_release(c.plans);
  whittle_release(c.branches);
  whittle_release(c.above);
  whittle_release(c.pieces);
  *count = c.count;
  return c.wide;
}
