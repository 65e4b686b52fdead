/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Dividing a large span by all workers: Wald 2007's horizontal parallelism. Bins are merged by
 * minimum, maximum and sum, and each piece knows where its fragments go before it moves them, so
 * the result is that of one worker. */

#include "bvh/divide.h"

typedef struct team_division {
  divide_context *c;
  const span *s;
  const whittle_fragment *fragments;
  bins *bins;
  bin_map map;
  divider divider;
  uint32_t *left_counts; /* by piece; later how many went left before it */
  whittle_fragment *left, *right;
  box4 middles[2];
} team_division;

static void bin_piece(void *context, uint64_t begin, uint64_t end) {
  const team_division *t = context;
  bins own;
  whittle_bins_clear(&own, t->map.bins);
  whittle_bins_add(&own, &t->map, t->fragments + begin, (uint32_t)(end - begin));
  pthread_mutex_lock(&t->c->lock);
  whittle_bins_merge(t->bins, &own, t->map.bins);
  pthread_mutex_unlock(&t->c->lock);
}

static void count_piece(void *context, uint64_t begin, uint64_t end) {
  const team_division *t = context;
  t->left_counts[begin / DIVIDE_GRAIN] =
      whittle_count_left(&t->divider, t->fragments + begin, (uint32_t)(end - begin));
}

static void move_piece(void *context, uint64_t begin, uint64_t end) {
  team_division *t = context;
  const uint64_t before = t->left_counts[begin / DIVIDE_GRAIN];
  box4 middles[2];
  whittle_partition(&t->divider, t->fragments + begin, (uint32_t)(end - begin), t->left + before,
                    t->right + (begin - before), middles);
  pthread_mutex_lock(&t->c->lock);
  for (int side = 0; side < 2; side++)
    t->middles[side] = box4_union(t->middles[side], middles[side]);
  pthread_mutex_unlock(&t->c->lock);
}

static void move(team_division *t, span children[2]) {
  const uint32_t count = t->s->count;
  whittle_team *team = t->c->team;
  t->left = whittle_span_fragments(t->c, &children[0]);
  t->right = whittle_span_fragments(t->c, &children[1]);
  t->middles[0] = t->middles[1] = box4_empty();
  /* Spans above 4 pieces have fewer pieces than twice their share of the counters. */
  t->left_counts = t->c->left_counts + 2 * (size_t)(t->s->first / DIVIDE_GRAIN);
  whittle_team_for(team, count, DIVIDE_GRAIN, count_piece, t);
  if (whittle_cancelled(team->state))
    return;
  uint32_t before = 0;
  for (uint32_t piece = 0; (uint64_t)piece * DIVIDE_GRAIN < count; piece++) {
    const uint32_t here = t->left_counts[piece];
    t->left_counts[piece] = before;
    before += here;
  }
  whittle_team_for(team, count, DIVIDE_GRAIN, move_piece, t);
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
  move(&t, children);
}
