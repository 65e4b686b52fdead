/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Four floats at once: all that the builder knows of the CPU's vectors. */

#pragma once

#include <emmintrin.h>
#include <stdint.h>

typedef __m128 float4;

static inline float4 float4_load(const float *p) {
  return _mm_load_ps(p);
} /* aligned to 16 */
static inline float4 float4_load_any(const float *p) {
  return _mm_loadu_ps(p);
}
static inline void float4_store(float *p, float4 a) {
  _mm_store_ps(p, a);
}
static inline float4 float4_all(float a) {
  return _mm_set1_ps(a);
}
static inline float4 float4_add(float4 a, float4 b) {
  return _mm_add_ps(a, b);
}
static inline float4 float4_sub(float4 a, float4 b) {
  return _mm_sub_ps(a, b);
}
static inline float4 float4_mul(float4 a, float4 b) {
  return _mm_mul_ps(a, b);
}

/* b where a is NaN. */
static inline float4 float4_min(float4 a, float4 b) {
  return _mm_min_ps(a, b);
}
static inline float4 float4_max(float4 a, float4 b) {
  return _mm_max_ps(a, b);
}

/* Masks: all bits of a lane set or none; a lane with all bits set is a NaN. */
static inline float4 float4_less(float4 a, float4 b) {
  return _mm_cmplt_ps(a, b);
}
static inline float4 float4_and(float4 a, float4 b) {
  return _mm_and_ps(a, b);
}
static inline float4 float4_or(float4 a, float4 b) {
  return _mm_or_ps(a, b);
}
static inline float4 float4_every(void) {
  return _mm_castsi128_ps(_mm_set1_epi32(-1));
}
static inline float4 float4_not(float4 a) {
  return _mm_xor_ps(a, _mm_castsi128_ps(_mm_set1_epi32(-1)));
}
static inline uint32_t float4_bits(float4 mask) {
  return (uint32_t)_mm_movemask_ps(mask);
}
static inline uint32_t float4_any(float4 mask) {
  return _mm_movemask_ps(mask) != 0;
}
static inline float4 float4_choose(float4 mask, float4 yes, float4 no) {
  return _mm_or_ps(_mm_and_ps(mask, yes), _mm_andnot_ps(mask, no));
}

/* The lanes x, y, z; the fourth is 0, whatever bits stood there. */
static inline float4 float4_xyz(float4 a) {
  return _mm_and_ps(a, _mm_castsi128_ps(_mm_setr_epi32(-1, -1, -1, 0)));
}

/* Lanes rounded towards 0. */
static inline void float4_truncate(float4 a, int32_t out[4]) {
  _mm_store_si128((__m128i *)out, _mm_cvttps_epi32(a));
}

/* Rows a, b, c become columns: (a.x, b.x, c.x, 0), (a.y, ...), (a.z, ...). */
static inline void float4_transpose3(float4 a, float4 b, float4 c, float4 out[3]) {
  const float4 low = _mm_unpacklo_ps(a, b);  /* ax bx ay by */
  const float4 high = _mm_unpackhi_ps(a, b); /* az bz aw bw */
  const float4 zero = _mm_setzero_ps();
  const float4 c_low = _mm_unpacklo_ps(c, zero); /* cx 0 cy 0 */
  out[0] = _mm_movelh_ps(low, c_low);
  out[1] = _mm_movehl_ps(c_low, low);
  out[2] = _mm_movelh_ps(high, _mm_unpackhi_ps(c, zero));
}

/* The x, y and z of four points; the float behind each is read and left out. */
static inline void float4_columns(const float *a, const float *b, const float *c, const float *d,
                                  float4 out[3]) {
  const float4 p = float4_load_any(a), q = float4_load_any(b);
  const float4 r = float4_load_any(c), s = float4_load_any(d);
  const float4 low = _mm_unpacklo_ps(p, q), high = _mm_unpacklo_ps(r, s);
  out[0] = _mm_movelh_ps(low, high);
  out[1] = _mm_movehl_ps(high, low);
  out[2] = _mm_movelh_ps(_mm_unpackhi_ps(p, q), _mm_unpackhi_ps(r, s));
}

/* Four counts at once. */
typedef __m128i int4;

static inline int4 int4_zero(void) {
  return _mm_setzero_si128();
}
static inline int4 int4_all(int32_t a) {
  return _mm_set1_epi32(a);
}
static inline int4 int4_mask(float4 mask) {
  return _mm_castps_si128(mask);
}
static inline int4 int4_sub(int4 a, int4 b) {
  return _mm_sub_epi32(a, b);
}
static inline void int4_store(int32_t *p, int4 a) {
  _mm_store_si128((__m128i *)p, a);
}
static inline int4 int4_load(const int32_t *p) {
  return _mm_load_si128((const __m128i *)p);
}
static inline int4 int4_add(int4 a, int4 b) {
  return _mm_add_epi32(a, b);
}
static inline float4 int4_to_float4(int4 a) {
  return _mm_cvtepi32_ps(a);
}
