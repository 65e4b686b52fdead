/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Random numbers that are the same on every machine. */

#ifndef BENCH_RANDOM_H
#define BENCH_RANDOM_H

#include "vector.h"

#include <stdint.h>

typedef struct random_state {
  uint64_t value;
} random_state;

static inline random_state random_seed(uint64_t seed) {
  return (random_state){seed};
}

/* SplitMix64 (Steele, Lea, Flood 2014): a counter and a finalizer. */
static inline uint64_t random_bits(random_state *state) {
  uint64_t z = state->value += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/* In [0, 1). */
static inline float random_unit(random_state *state) {
  return (float)(random_bits(state) >> 40) * 0x1p-24f;
}

/* Uniform on the unit sphere, by rejection. */
static inline vector random_direction(random_state *state) {
  for (;;) {
    vector v = {2 * random_unit(state) - 1, 2 * random_unit(state) - 1, 2 * random_unit(state) - 1};
    float square = dot(v, v);
    if (square > 0.01f && square <= 1)
      return normalise(v);
  }
}

#endif
