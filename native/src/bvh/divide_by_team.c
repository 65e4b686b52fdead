/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Dividing a large span by all workers: Wald 2007's horizontal parallelism. Bins are merged by
 * minimum, maximum and sum, and each piece knows where its fragments go before it moves them, so
 * the result is that of one worker. */

#include "bvh/divide.h"

#include <string.h>

typedef struct axis_counts {
  int32_t on[4];
} axis_counts;

typedef struct team_division {
  divide_context *c;
  const span *s;
  const whittle_fragment *fragments;
  bins *bins;
  bin_map map;
  divider divider;
  axis_counts *counts; /* of the pieces' bins, piece after piece */
  whittle_fragment *left, *right;
  box4 middles[2];
} team_division;

static axis_counts *counts_of(const team_division *t, uint64_t begin) {
  return t->counts + begin / DIVIDE_GRAIN * t->map.bins;
}

static void bin_piece(void *context, uint64_t begin, uint64_t end) {
  const team_division *t = context;
  bins own;
  whittle_bins_clear(&own, t->map.bins);
  whittle_bins_add(&own, &t->map, t->fragments + begin, (uint32_t)(end - begin));
  memcpy(counts_of(t, begin), own.count, t->map.bins * sizeof *own.count);
  pthread_mutex_lock(&t->c->lock);
  whittle_bins_merge(t->bins, &own, t->map.bins);
  pthread_mutex_unlock(&t->c->lock);
}

/* Leaves in each piece's first count how many go left before it. */
static void count_before(const team_division *t, const split *best) {
  int32_t before = 0;
  for (uint64_t begin = 0; begin < t->s->count; begin += DIVIDE_GRAIN) {
    axis_counts *counts = counts_of(t, begin);
    int32_t here = 0;
    for (uint32_t i = 0; i < best->plane; i++)
      here += counts[i].on[best->axis];
    counts->on[0] = before;
    before += here;
  }
}

static void move_piece(void *context, uint64_t begin, uint64_t end) {
  team_division *t = context;
  const uint64_t before = (uint64_t)counts_of(t, begin)->on[0];
  box4 middles[2];
  whittle_partition(&t->divider, t->fragments + begin, (uint32_t)(end - begin), t->left + before,
                    t->right + (begin - before), middles);
  pthread_mutex_lock(&t->c->lock);
  for (int side = 0; side < 2; side++)
    t->middles[side] = box4_union(t->middles[side], middles[side]);
  pthread_mutex_unlock(&t->c->lock);
}

static void move(team_division *t, span children[2]) {
  t->left = whittle_span_fragments(t->c, &children[0]);
  t->right = whittle_span_fragments(t->c, &children[1]);
  t->middles[0] = t->middles[1] = box4_empty();
  whittle_team_for(t->c->team, t->s->count, DIVIDE_GRAIN, move_piece, t);
  children[0].middles = t->middles[0];
  children[1].middles = t->middles[1];
}

void whittle_divide_by_team(divide_context *c, bins *own, const span *s, span children[2]) {
  team_division t = {.c = c,
                     .s = s,
                     .fragments = whittle_span_fragments(c, s),
                     .bins = own,
                     .map = whittle_bin_map(s->middles, c->options.bins)};
  split best;
  /* Spans above 4 pieces have fewer pieces than twice their share of the counts. */
  t.counts = (axis_counts *)c->piece_counts + 2 * (size_t)(s->first / DIVIDE_GRAIN) * t.map.bins;
  whittle_bins_clear(own, t.map.bins);
  whittle_team_for(c->team, s->count, DIVIDE_GRAIN, bin_piece, &t);
  if (whittle_cancelled(c->team->state))
    return;
  const bool found = whittle_bins_split(own, t.map.bins, t.map.usable, s->bounds, s->count, &best);
  if (whittle_choose(c, s, found, &best) == HALVE) {
    whittle_halve(c, s, children);
    return;
  }
  t.divider = whittle_divider(&t.map, &best);
  whittle_number_children(s, whittle_count_below(own, &best), children);
  whittle_bound_children(own, &best, t.map.bins, children);
  count_before(&t, &best);
  move(&t, children);
}
