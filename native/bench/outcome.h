/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What comes of the rounds of a measurement, and the record that begins with it. */

#ifndef BENCH_OUTCOME_H
#define BENCH_OUTCOME_H

#include "contest.h"

#include <stddef.h>

/* Rates in millions a second, and the spread of the rounds. */
typedef struct outcome {
  double ours, embree, ratio, spread, ours_spread, embree_spread;
} outcome;

/* Of work that took both so many seconds in each round. */
outcome outcome_judge(const double *ours, const double *embree, size_t rounds, size_t work);

/* Begins a record with what every one holds; `mode` is Embree's. */
void outcome_begin_record(const contest *c, const char *kind, const outcome *o, const char *mode);
void outcome_record_hits(size_t rays, size_t ours, size_t embree, size_t mismatches);

#endif
