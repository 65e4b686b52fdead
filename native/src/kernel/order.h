/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Which of a node's eight children comes first: distances as sixteen bits each in one register. */

#pragma once

#include "kernel/simd.h"

#include <smmintrin.h>

/* The upper bits of distances, those below 0 as 0: never above what they stand for, in its order,
 * or equal. ORDER_NONE stands for no child. */
typedef __m128i child_order;

#define ORDER_CHILDREN 8
#define ORDER_NONE 0xffffu
#define ORDER_SHIFT                                                                                \
  15 /* packing saturates: numbers below 0 give 0, and INT32_MAX gives ORDER_NONE */

/* The keys of distances in `there`; `near` and `there` are as many lane groups as make eight. */
static inline child_order order_of(const v_float near[], const v_mask there[]) {
#if defined(__AVX512F__)
  const __m512i bits =
      _mm512_mask_mov_epi32(_mm512_set1_epi32(INT32_MAX), there[0], _mm512_castps_si512(near[0]));
  const __m256i keys = _mm512_castsi512_si256(_mm512_srai_epi32(bits, ORDER_SHIFT));
  const __m128i low = _mm256_castsi256_si128(keys), high = _mm256_extracti128_si256(keys, 1);
#elif defined(__AVX2__)
  const __m256 none = _mm256_castsi256_ps(_mm256_set1_epi32(INT32_MAX));
  const __m256 bits = _mm256_blendv_ps(none, near[0], there[0]);
  const __m256i keys = _mm256_srai_epi32(_mm256_castps_si256(bits), ORDER_SHIFT);
  const __m128i low = _mm256_castsi256_si128(keys), high = _mm256_extracti128_si256(keys, 1);
#else
  const __m128 none = _mm_castsi128_ps(_mm_set1_epi32(INT32_MAX));
  const __m128i low =
      _mm_srai_epi32(_mm_castps_si128(_mm_blendv_ps(none, near[0], there[0])), ORDER_SHIFT);
  const __m128i high =
      _mm_srai_epi32(_mm_castps_si128(_mm_blendv_ps(none, near[1], there[1])), ORDER_SHIFT);
#endif
  return _mm_packus_epi32(low, high);
}

/* The key of a distance that others are compared with. */
static inline uint32_t order_key(float distance) {
  int32_t bits;
  memcpy(&bits, &distance, sizeof bits);
  return bits < 0 ? 0 : (uint32_t)bits >> ORDER_SHIFT;
}

/* The child with the least key, and that key; the first of several. */
static inline uint32_t order_first(child_order order, uint32_t *key) {
  const uint32_t least = (uint32_t)_mm_cvtsi128_si32(_mm_minpos_epu16(order));
  *key = least & ORDER_NONE;
  return least >> 16;
}

/* Without child i. */
static inline child_order order_without(child_order order, uint32_t i) {
  static const uint16_t none[2 * ORDER_CHILDREN] = {[ORDER_CHILDREN] = ORDER_NONE};
  return _mm_or_si128(order, _mm_loadu_si128((const __m128i *)&none[ORDER_CHILDREN - i]));
}
