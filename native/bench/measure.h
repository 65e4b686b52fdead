/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Interleaved rounds of timing, and what is made of them. */

#ifndef BENCH_MEASURE_H
#define BENCH_MEASURE_H

#include <stddef.h>

/* Something that is timed: run(user) does the work once and gives its seconds. */
typedef struct contender {
  double (*run)(void *user);
  void *user;
  double *seconds; /* one for each round */
} contender;

/* Runs every contender once to warm up, then once in each round; who starts moves on by one from
 * round to round. Work under 10 ms is repeated to fill them, and the mean kept. */
void measure_rounds(contender *contenders, size_t count, size_t rounds);

/* The p-th part of the sorted values (0.5: the median), linear between neighbours. */
double measure_quantile(const double *values, size_t count, double p);

/* Distance of the quartiles over the median. */
double measure_spread(const double *values, size_t count);

#endif
