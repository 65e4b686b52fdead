/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* An integer hash for sample positions: the same everywhere, without state. */

#pragma once

#include <stdint.h>

/* Two rounds of multiply and xorshift over each input; constants are odd 32-bit primes. */
static inline uint32_t whittle_mix(uint32_t h, uint32_t x) {
  h = (h ^ x) * 0x9e3779b1u;
  h = (h ^ h >> 15) * 0x85ebca77u;
  return h ^ h >> 13;
}

static inline uint32_t whittle_hash(uint32_t x, uint32_t y, uint32_t sample, uint32_t seed) {
  return whittle_mix(whittle_mix(whittle_mix(whittle_mix(seed, x), y), sample), 0xc2b2ae3du);
}
