/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Deciding what becomes of a span, and moving its fragments to both sides. */

#pragma once

#include "bvh/bins.h"
#include "bvh/partition.h"

/* What every division needs to know. */
typedef struct divide_context {
  whittle_team *team;
  whittle_bvh_options options;
  whittle_fragment *buffer[2];
  int32_t *piece_counts; /* for whittle_divide_by_team */
  pthread_mutex_t lock;  /* likewise */
} divide_context;

enum {
  DIVIDE_GRAIN = 8192,             /* fragments in a piece of the team's work */
  DIVIDE_LARGE = 4 * DIVIDE_GRAIN, /* spans above this are worth the team's while */
};

/* How many numbers piece_counts has room for. */
static inline size_t whittle_piece_counts(uint32_t count, uint32_t bins) {
  return 4 * (size_t)bins * (2 * ((size_t)count / DIVIDE_GRAIN) + 2);
}

static inline whittle_fragment *whittle_span_fragments(const divide_context *c, const span *s) {
  return c->buffer[s->buffer] + s->first;
}

/* Fills all of the children but `node` and `room`; false: the span is a leaf. Fragments move to the
 * other buffer. `own` is the worker's memory for bins. */
bool whittle_divide(const divide_context *c, bins *own, const span *s, span children[2]);

/* The same, by all of the team, for a span above DIVIDE_LARGE, which is never a leaf. The children
 * hold nothing useful once the run is cancelled. */
void whittle_divide_by_team(divide_context *c, bins *own, const span *s, span children[2]);

/* The steps that both share. */
typedef enum choice { LEAF, SPLIT, HALVE } choice;

choice whittle_choose(const divide_context *c, const span *s, bool found, const split *best);
void whittle_number_children(const span *s, uint32_t left, span children[2]);
void whittle_bound_children(const bins *b, const split *best, uint32_t bins, span children[2]);
uint32_t whittle_count_below(const bins *b, const split *best);
void whittle_halve(const divide_context *c, const span *s, span children[2]);
