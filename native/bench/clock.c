/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Wall time and an estimate of the clock rate. */

#include "clock.h"

#include <stdint.h>
#include <time.h>

double clock_seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* 16 dependent additions a turn; the empty asm keeps the compiler from merging them. */
static double additions_per_second(uint64_t turns) {
  uint64_t sum = 0;
  double start = clock_seconds();
  for (uint64_t i = 0; i < turns; i++)
    for (int k = 0; k < 16; k++) {
      sum += i;
      __asm__ volatile("" : "+r"(sum));
    }
  return 16 * (double)turns / (clock_seconds() - start);
}

double clock_gigahertz(void) {
  double best = 0; /* an interruption only ever makes it slower */
  for (int i = 0; i < 10; i++) {
    double rate = additions_per_second(120000);
    best = rate > best ? rate : best;
  }
  return best * 1e-9;
}
