/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Interleaved rounds, quantiles and spread. */

#include "measure.h"

#include "fail.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double shortest = 0.01;

static double mean_of(const contender *c, unsigned repeats) {
  double sum = 0;
  for (unsigned i = 0; i < repeats; i++)
    sum += c->run(c->user);
  return sum / repeats;
}

void measure_rounds(contender *contenders, size_t count, size_t rounds) {
  unsigned *repeats = allocate(count, sizeof(*repeats));
  for (size_t i = 0; i < count; i++) {
    double seconds = mean_of(&contenders[i], 1);
    repeats[i] = (unsigned)fmin(1000, fmax(1, ceil(shortest / fmax(seconds, 1e-9))));
  }
  for (size_t round = 0; round < rounds; round++)
    for (size_t turn = 0; turn < count; turn++) {
      size_t i = (round + turn) % count;
      contenders[i].seconds[round] = mean_of(&contenders[i], repeats[i]);
    }
  free(repeats);
}

static int compare_doubles(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

double measure_quantile(const double *values, size_t count, double p) {
  double *sorted = allocate(count, sizeof(double));
  memcpy(sorted, values, count * sizeof(double));
  qsort(sorted, count, sizeof(double), compare_doubles);
  double place = p * (double)(count - 1);
  size_t low = (size_t)place, high = low + 1 < count ? low + 1 : low;
  double value = sorted[low] + (place - (double)low) * (sorted[high] - sorted[low]);
  free(sorted);
  return value;
}

double measure_spread(const double *values, size_t count) {
  double low = measure_quantile(values, count, 0.25);
  double high = measure_quantile(values, count, 0.75);
  return (high - low) / measure_quantile(values, count, 0.5);
}
