/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Comparisons of many lane groups at once, each as a byte or a short: a block for each instruction
 * set, as in simd.h. */

#pragma once

#include "kernel/simd.h"

#if defined(__AVX512F__)
#define V_BYTES 64

/* Bytes and shorts of many lane groups, which v_store_bytes makes of lanes. */
typedef __m512i v_bytes;

/* Numbers from 0 to 255, rounded down. */
static inline void v_store_bytes(uint8_t *p, v_float a) {
  _mm_storeu_si128((__m128i *)p, _mm512_cvtusepi32_epi8(_mm512_cvttps_epi32(a)));
}
static inline v_bytes v_set_bytes(uint8_t x) {
  return _mm512_set1_epi8((char)x);
}
static inline v_bytes v_load_bytes(const void *p) {
  return _mm512_loadu_si512(p);
}
/* Not 0 where a > b. */
static inline v_bytes v_bytes_above(v_bytes a, v_bytes b) {
  return _mm512_subs_epu8(a, b);
}
/* The same of a short and V_BYTES others that v_store_shorts has made. */
static inline v_bytes v_short_above(int16_t a, const int16_t *b) {
  const __m512i all = _mm512_set1_epi16(a);
  return _mm512_packus_epi16(_mm512_subs_epi16(all, _mm512_loadu_si512(b)),
                             _mm512_subs_epi16(all, _mm512_loadu_si512(b + V_BYTES / 2)));
}
/* The upper halves of V_BYTES floats as shorts. v_short_above packs two vectors of these, which
 * takes eight of the one and of the other in turns: so every other eight stand in the second one.
 */
static inline void v_store_shorts(int16_t *p, const float *from) {
  const __m512i odd = _mm512_setr_epi64(2, 3, 6, 7, 10, 11, 14, 15);
  const __m512i even = _mm512_setr_epi64(0, 1, 4, 5, 8, 9, 12, 13);
  __m512i half[2];
  for (int i = 0; i < 2; i++) {
    const __m512i low = _mm512_srli_epi32(_mm512_loadu_si512(from + 32 * i), 16);
    const __m512i high = _mm512_srli_epi32(_mm512_loadu_si512(from + 32 * i + 16), 16);
    half[i] = _mm512_inserti64x4(_mm512_castsi256_si512(_mm512_cvtepi32_epi16(low)),
                                 _mm512_cvtepi32_epi16(high), 1);
  }
  _mm512_storeu_si512(p, _mm512_permutex2var_epi64(half[0], even, half[1]));
  _mm512_storeu_si512(p + V_BYTES / 2, _mm512_permutex2var_epi64(half[0], odd, half[1]));
}
static inline v_bytes v_bytes_or(v_bytes a, v_bytes b) {
  return _mm512_or_si512(a, b);
}
static inline uint64_t v_bytes_zero(v_bytes a) {
  return _mm512_testn_epi8_mask(a, a);
}

#elif defined(__AVX2__)
#define V_BYTES 32

typedef __m256i v_bytes;

static inline void v_store_bytes(uint8_t *p, v_float a) {
  const __m256i whole = _mm256_cvttps_epi32(a);
  const __m128i shorts =
      _mm_packus_epi32(_mm256_castsi256_si128(whole), _mm256_extracti128_si256(whole, 1));
  _mm_storel_epi64((__m128i *)p, _mm_packus_epi16(shorts, shorts));
}
static inline v_bytes v_set_bytes(uint8_t x) {
  return _mm256_set1_epi8((char)x);
}
static inline v_bytes v_load_bytes(const void *p) {
  return _mm256_loadu_si256((const __m256i *)p);
}
static inline v_bytes v_bytes_above(v_bytes a, v_bytes b) {
  return _mm256_subs_epu8(a, b);
}
static inline v_bytes v_short_above(int16_t a, const int16_t *b) {
  const __m256i all = _mm256_set1_epi16(a);
  return _mm256_packus_epi16(_mm256_subs_epi16(all, v_load_bytes(b)),
                             _mm256_subs_epi16(all, v_load_bytes(b + V_BYTES / 2)));
}
static inline void v_store_shorts(int16_t *p, const float *from) {
  for (int i = 0; i < 2; i++) {
    const __m256i low = _mm256_srli_epi32(v_load_bytes(from + 8 * i), 16);
    const __m256i high = _mm256_srli_epi32(v_load_bytes(from + 16 + 8 * i), 16);
    const __m256i both = _mm256_permute4x64_epi64(_mm256_packus_epi32(low, high), 0xd8);
    _mm256_storeu_si256((__m256i *)(p + 16 * i), both);
  }
}
static inline v_bytes v_bytes_or(v_bytes a, v_bytes b) {
  return _mm256_or_si256(a, b);
}
static inline uint64_t v_bytes_zero(v_bytes a) {
  return (uint32_t)_mm256_movemask_epi8(_mm256_cmpeq_epi8(a, _mm256_setzero_si256()));
}

#elif defined(__SSE4_2__)
#define V_BYTES 16

typedef __m128i v_bytes;

static inline void v_store_bytes(uint8_t *p, v_float a) {
  const __m128i whole = _mm_cvttps_epi32(a), shorts = _mm_packus_epi32(whole, whole);
  const int bytes = _mm_cvtsi128_si32(_mm_packus_epi16(shorts, shorts));
  memcpy(p, &bytes, sizeof bytes);
}
static inline v_bytes v_set_bytes(uint8_t x) {
  return _mm_set1_epi8((char)x);
}
static inline v_bytes v_load_bytes(const void *p) {
  return _mm_loadu_si128((const __m128i *)p);
}
static inline v_bytes v_bytes_above(v_bytes a, v_bytes b) {
  return _mm_subs_epu8(a, b);
}
static inline v_bytes v_short_above(int16_t a, const int16_t *b) {
  const __m128i all = _mm_set1_epi16(a);
  return _mm_packus_epi16(_mm_subs_epi16(all, v_load_bytes(b)),
                          _mm_subs_epi16(all, v_load_bytes(b + V_BYTES / 2)));
}
static inline void v_store_shorts(int16_t *p, const float *from) {
  for (int i = 0; i < 2; i++) {
    const __m128i low = _mm_srli_epi32(v_load_bytes(from + 8 * i), 16);
    const __m128i high = _mm_srli_epi32(v_load_bytes(from + 8 * i + 4), 16);
    _mm_storeu_si128((__m128i *)(p + 8 * i), _mm_packus_epi32(low, high));
  }
}
static inline v_bytes v_bytes_or(v_bytes a, v_bytes b) {
  return _mm_or_si128(a, b);
}
static inline uint64_t v_bytes_zero(v_bytes a) {
  return (uint32_t)_mm_movemask_epi8(_mm_cmpeq_epi8(a, _mm_setzero_si128()));
}

#endif
