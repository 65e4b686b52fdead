/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Dividing a span by one worker: by ranks, by bins or by the median. */

#include "bvh/divide.h"
#include "bvh/median.h"

static uint32_t ceil_log2(uint32_t n) {
  return n > 1 ? 32 - (uint32_t)__builtin_clz(n - 1) : 0;
}

/* Whether halving from here on would use up the depth that is left: then it must begin. Spans keep
 * ceil_log2(count) <= max_depth - depth, so no leaf can lie deeper. */
static bool must_halve(const divide_context *c, const span *s) {
  return ceil_log2(s->count) >= c->options.max_depth - s->depth;
}

choice whittle_choose(const divide_context *c, const span *s, bool found, const split *best) {
  if (s->count <= c->options.max_leaf) {
    const float divided = c->options.traversal_cost * best->area + best->cost;
    if (!found || best->leaf_cost <= divided)
      return LEAF;
  }
  return found && !must_halve(c, s) ? SPLIT : HALVE;
}

void whittle_number_children(const span *s, uint32_t left, span children[2]) {
  for (uint32_t side = 0; side < 2; side++) {
    span *child = &children[side];
    child->first = side ? s->first + left : s->first;
    child->count = side ? s->count - left : left;
    child->depth = s->depth + 1;
    child->buffer = 1 - s->buffer;
  }
}

void whittle_bound_children(const bins *b, const split *best, uint32_t bins, span children[2]) {
  children[0].bounds = whittle_bins_bounds(b, best->axis, 0, best->plane);
  children[1].bounds = whittle_bins_bounds(b, best->axis, best->plane, bins);
}

uint32_t whittle_count_below(const bins *b, const split *best) {
  uint32_t left = 0;
  for (uint32_t i = 0; i < best->plane; i++)
    left += (uint32_t)b->count[i][best->axis];
  return left;
}

void whittle_halve(const divide_context *c, const span *s, span children[2]) {
  whittle_number_children(s, s->count / 2, children);
  whittle_median(s, whittle_span_fragments(c, s), whittle_span_fragments(c, &children[0]),
                 whittle_span_fragments(c, &children[1]), children, c->team->state);
}

static bool divide_by_ranks(const divide_context *c, bins *own, const span *s, span children[2]) {
  const whittle_fragment *fragments = whittle_span_fragments(c, s);
  ranks ranks;
  split best;
  whittle_bins_rank(own, &ranks, fragments, s->count);
  const bool found = whittle_bins_split(own, s->count, float4_every(), s->bounds, s->count, &best);
  const choice choice = whittle_choose(c, s, found, &best);
  if (choice == LEAF)
    return false;
  if (choice == HALVE)
    best.plane = s->count / 2;
  whittle_number_children(s, best.plane, children);
  whittle_bound_children(own, &best, s->count, children);
  whittle_fragment *to = whittle_span_fragments(c, &children[0]);
  for (uint32_t i = 0; i < s->count; i++)
    to[ranks.rank[i][best.axis]] = fragments[i];
  for (uint32_t side = 0; side < 2; side++)
    children[side].middles = box4_empty(); /* ranks need none */
  return true;
}

static bool divide_by_bins(const divide_context *c, bins *own, const span *s, span children[2]) {
  const whittle_fragment *fragments = whittle_span_fragments(c, s);
  const bin_map map = whittle_bin_map(s->middles, c->options.bins);
  split best;
  whittle_bins_clear(own, map.bins);
  whittle_bins_add(own, &map, fragments, s->count);
  const bool found = whittle_bins_split(own, map.bins, map.usable, s->bounds, s->count, &best);
  const choice choice = whittle_choose(c, s, found, &best);
  if (choice == LEAF)
    return false;
  if (choice == HALVE) {
    whittle_halve(c, s, children);
    return true;
  }
  const divider d = whittle_divider(&map, &best);
  box4 middles[2];
  whittle_number_children(s, whittle_count_below(own, &best), children);
  whittle_bound_children(own, &best, map.bins, children);
  whittle_partition(&d, fragments, s->count, whittle_span_fragments(c, &children[0]),
                    whittle_span_fragments(c, &children[1]), middles);
  children[0].middles = middles[0];
  children[1].middles = middles[1];
  return true;
}

bool whittle_divide(const divide_context *c, bins *own, const span *s, span children[2]) {
  const uint32_t few = c->options.bins < MOST_RANKED ? c->options.bins : MOST_RANKED;
  if (s->count == 1 || s->count <= c->options.whole)
    return false;
  return s->count <= few ? divide_by_ranks(c, own, s, children)
                         : divide_by_bins(c, own, s, children);
}
