/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* All that knows how wide a lane group is: one block of this file for each instruction set. */

#pragma once

#include <stdint.h>
#include <string.h>

/* Three families of the same names: s_ one number, f4_ four of them, v_ as many as the machine
 * likes. Comparisons give masks that are all false where a number is NaN; min and max return the
 * second operand if either is NaN, as MINPS and MAXPS do. Nothing here contracts or approximates,
 * so a lane gives the same bits in every family. Arithmetic uses the compiler's operators. */

/* ---- One number --------------------------------------------------------------------------------
 */

typedef float s_float;
typedef uint32_t s_uint;
typedef int s_mask;

static inline float s_set(float x) {
  return x;
}
static inline float s_min(float a, float b) {
  return a < b ? a : b;
}
static inline float s_max(float a, float b) {
  return a > b ? a : b;
}
static inline float s_abs(float a) {
  return __builtin_fabsf(a);
}
static inline float s_sqrt(float a) {
  return __builtin_sqrtf(a);
}
static inline int s_lt(float a, float b) {
  return a < b;
}
static inline int s_le(float a, float b) {
  return a <= b;
}
static inline int s_eq(float a, float b) {
  return a == b;
}
static inline int s_and(int a, int b) {
  return a & b;
}
static inline int s_or(int a, int b) {
  return a | b;
}
static inline int s_andnot(int a, int b) {
  return a & !b;
} /* a and not b */
static inline uint32_t s_bits(int a) {
  return (uint32_t)a;
}
static inline int s_from_bits(uint32_t bits) {
  return (int)(bits & 1);
}
static inline float s_select(int m, float a, float b) {
  return m ? a : b;
}
static inline float s_load(const float *p) {
  return *p;
}
static inline void s_store(float *p, float a) {
  *p = a;
}
static inline uint32_t s_loadu(const uint32_t *p) {
  return *p;
}
static inline int s_above(uint32_t x, uint32_t a) {
  return a > x;
} /* lanes of a above x */
#define S_LANES 1

/* ---- Four numbers: a node's bounds for one ray
 * ---------------------------------------------------- */

#if defined(__SSE4_2__)
#include <immintrin.h>

typedef __m128 f4_float;

/* Three numbers and 0: what follows them in memory may be an index, and slow as a denormal float.
 */
static inline __m128 f4_load3(const float *p) {
  return _mm_blend_ps(_mm_loadu_ps(p), _mm_setzero_ps(), 8);
}
static inline __m128 f4_set(float x) {
  return _mm_set1_ps(x);
}
static inline __m128 f4_make(float x, float y, float z, float w) {
  return _mm_setr_ps(x, y, z, w);
}
static inline __m128 f4_min(__m128 a, __m128 b) {
  return _mm_min_ps(a, b);
}
static inline __m128 f4_max(__m128 a, __m128 b) {
  return _mm_max_ps(a, b);
}
/* By the sign bits of `sign`: b where set, else a. */
static inline __m128 f4_by_sign(__m128 sign, __m128 a, __m128 b) {
  return _mm_blendv_ps(a, b, sign);
}
static inline float f4_first(__m128 a) {
  return _mm_cvtss_f32(a);
}
static inline float f4_max3(__m128 a) {
  const __m128 y = _mm_shuffle_ps(a, a, 1), z = _mm_movehl_ps(a, a);
  return _mm_cvtss_f32(_mm_max_ss(_mm_max_ss(a, y), z));
}
static inline float f4_min3(__m128 a) {
  const __m128 y = _mm_shuffle_ps(a, a, 1), z = _mm_movehl_ps(a, a);
  return _mm_cvtss_f32(_mm_min_ss(_mm_min_ss(a, y), z));
}
static inline void whittle_prefetch(const void *p) {
  _mm_prefetch((const char *)p, _MM_HINT_T0);
}
/* The lanes of `set` moved to the front, in order. */
static inline __m128 f4_to_front(__m128 a, uint32_t set) {
#define LANE(i) 4 * (i), 4 * (i) + 1, 4 * (i) + 2, 4 * (i) + 3
#define LANES(a, b, c, d)                                                                          \
  {                                                                                                \
    LANE(a), LANE(b), LANE(c), LANE(d)                                                             \
  }
  static const uint8_t order[16][16] = {
      LANES(0, 0, 0, 0), LANES(0, 0, 0, 0), LANES(1, 0, 0, 0), LANES(0, 1, 0, 0),
      LANES(2, 0, 0, 0), LANES(0, 2, 0, 0), LANES(1, 2, 0, 0), LANES(0, 1, 2, 0),
      LANES(3, 0, 0, 0), LANES(0, 3, 0, 0), LANES(1, 3, 0, 0), LANES(0, 1, 3, 0),
      LANES(2, 3, 0, 0), LANES(0, 2, 3, 0), LANES(1, 2, 3, 0), LANES(0, 1, 2, 3)};
#undef LANES
#undef LANE
  const __m128i bytes = _mm_loadu_si128((const __m128i *)order[set & 15]);
  return _mm_castsi128_ps(_mm_shuffle_epi8(_mm_castps_si128(a), bytes));
}
#endif

/* ---- AVX-512: sixteen lanes
 * ---------------------------------------------------------------------- */

#if defined(__AVX512F__)
#define V_LANES 16
typedef __m512 v_float;
typedef __m512i v_uint;
typedef __mmask16 v_mask;

static inline v_float v_set(float x) {
  return _mm512_set1_ps(x);
}
static inline v_float v_load(const float *p) {
  return _mm512_loadu_ps(p);
}
static inline void v_store(float *p, v_float a) {
  _mm512_storeu_ps(p, a);
}
static inline v_uint v_setu(uint32_t x) {
  return _mm512_set1_epi32((int)x);
}
static inline v_uint v_loadu(const uint32_t *p) {
  return _mm512_loadu_si512(p);
}
static inline void v_storeu(uint32_t *p, v_uint a) {
  _mm512_storeu_si512(p, a);
}
static inline v_float v_min(v_float a, v_float b) {
  return _mm512_min_ps(a, b);
}
static inline v_float v_max(v_float a, v_float b) {
  return _mm512_max_ps(a, b);
}
static inline v_float v_abs(v_float a) {
  return _mm512_abs_ps(a);
}
static inline v_float v_sqrt(v_float a) {
  return _mm512_sqrt_ps(a);
}
/* a * b + c for bounds with room for either rounding: the only thing that may differ by machine. */
static inline v_float v_fused(v_float a, v_float b, v_float c) {
  return _mm512_fmadd_ps(a, b, c);
}
/* a, which is not negative, with the sign of b. */
static inline v_float v_copysign(v_float a, v_float b) {
  return _mm512_or_ps(a, _mm512_and_ps(b, _mm512_set1_ps(-0.0f)));
}
static inline v_mask v_lt(v_float a, v_float b) {
  return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ);
}
static inline v_mask v_le(v_float a, v_float b) {
  return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ);
}
static inline v_mask v_eq(v_float a, v_float b) {
  return _mm512_cmp_ps_mask(a, b, _CMP_EQ_OQ);
}
static inline v_mask v_and(v_mask a, v_mask b) {
  return (v_mask)(a & b);
}
static inline v_mask v_or(v_mask a, v_mask b) {
  return (v_mask)(a | b);
}
static inline v_mask v_andnot(v_mask a, v_mask b) {
  return (v_mask)(a & ~b);
}
static inline uint32_t v_bits(v_mask a) {
  return a;
}
static inline v_mask v_from_bits(uint32_t bits) {
  return (v_mask)bits;
}
static inline v_float v_select(v_mask m, v_float a, v_float b) {
  return _mm512_mask_blend_ps(m, b, a);
}
static inline v_uint v_selectu(v_mask m, v_uint a, v_uint b) {
  return _mm512_mask_blend_epi32(m, b, a);
}
static inline v_mask v_above(uint32_t x, v_uint a) {
  return _mm512_cmpgt_epu32_mask(a, _mm512_set1_epi32((int)x));
}
static inline v_mask v_equ(v_uint a, v_uint b) {
  return _mm512_cmpeq_epi32_mask(a, b);
}
/* table[stride * index], a 32-bit place, but `a` in the lanes of m. */
static inline v_uint v_pick(v_mask m, v_uint a, const uint32_t *table, const int stride,
                            v_uint index) {
  const __m512i at = _mm512_mullo_epi32(index, _mm512_set1_epi32(stride));
  return _mm512_mask_i32gather_epi32(a, (v_mask)~m, at, table, 4);
}
/* The neighbouring float above (up 1) or below (up -1). */
static inline v_float v_next(v_float a, int up) {
  const __m512i bits = _mm512_castps_si512(a);
  const __mmask16 negative = _mm512_movepi32_mask(bits);
  const __m512i magnitude = _mm512_and_si512(bits, _mm512_set1_epi32(INT32_MAX));
  const __m512i step =
      _mm512_mask_blend_epi32(negative, _mm512_set1_epi32(up), _mm512_set1_epi32(-up));
  const __m512i zero = _mm512_set1_epi32(up > 0 ? 1 : INT32_MIN + 1);
  const __mmask16 none = _mm512_cmpeq_epi32_mask(magnitude, _mm512_setzero_si512());
  return _mm512_castsi512_ps(_mm512_mask_blend_epi32(none, _mm512_add_epi32(bits, step), zero));
}
/* first, first + 1, ... */
static inline v_uint v_from(uint32_t first) {
  const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  return _mm512_add_epi32(_mm512_set1_epi32((int)first), lane);
}
static inline v_float v_as_float(v_uint a) {
  return _mm512_castsi512_ps(a);
}
/* Stores the lanes of `set` next to each other, and anything into what is left of V_LANES. */
static inline void v_store_packed(float *p, v_float a, uint32_t set) {
  _mm512_storeu_ps(p, _mm512_maskz_compress_ps((__mmask16)set, a));
}
static inline float v_reduce_min(v_float a) {
  return _mm512_reduce_min_ps(a);
}
static inline float v_reduce_max(v_float a) {
  return _mm512_reduce_max_ps(a);
}
/* The least of each of V_LANES rows. */
static inline v_float v_least_of_rows(const v_float row[V_LANES]) {
  float least[V_LANES];
  for (int i = 0; i < V_LANES; i++)
    least[i] = _mm512_reduce_min_ps(row[i]);
  return _mm512_loadu_ps(least);
}

/* ---- AVX2: eight lanes
 * ---------------------------------------------------------------------------- */

#elif defined(__AVX2__)
#define V_LANES 8
typedef __m256 v_float;
typedef __m256i v_uint;
typedef __m256 v_mask;

static inline v_float v_set(float x) {
  return _mm256_set1_ps(x);
}
static inline v_float v_load(const float *p) {
  return _mm256_loadu_ps(p);
}
static inline void v_store(float *p, v_float a) {
  _mm256_storeu_ps(p, a);
}
static inline v_uint v_setu(uint32_t x) {
  return _mm256_set1_epi32((int)x);
}
static inline v_uint v_loadu(const uint32_t *p) {
  return _mm256_loadu_si256((const __m256i *)p);
}
static inline void v_storeu(uint32_t *p, v_uint a) {
  _mm256_storeu_si256((__m256i *)p, a);
}
static inline v_float v_min(v_float a, v_float b) {
  return _mm256_min_ps(a, b);
}
static inline v_float v_max(v_float a, v_float b) {
  return _mm256_max_ps(a, b);
}
static inline v_float v_abs(v_float a) {
  return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a);
}
static inline v_float v_sqrt(v_float a) {
  return _mm256_sqrt_ps(a);
}
static inline v_float v_fused(v_float a, v_float b, v_float c) {
  return _mm256_fmadd_ps(a, b, c);
}
static inline v_float v_copysign(v_float a, v_float b) {
  return _mm256_or_ps(a, _mm256_and_ps(b, _mm256_set1_ps(-0.0f)));
}
static inline v_mask v_lt(v_float a, v_float b) {
  return _mm256_cmp_ps(a, b, _CMP_LT_OQ);
}
static inline v_mask v_le(v_float a, v_float b) {
  return _mm256_cmp_ps(a, b, _CMP_LE_OQ);
}
static inline v_mask v_eq(v_float a, v_float b) {
  return _mm256_cmp_ps(a, b, _CMP_EQ_OQ);
}
static inline v_mask v_and(v_mask a, v_mask b) {
  return _mm256_and_ps(a, b);
}
static inline v_mask v_or(v_mask a, v_mask b) {
  return _mm256_or_ps(a, b);
}
static inline v_mask v_andnot(v_mask a, v_mask b) {
  return _mm256_andnot_ps(b, a);
}
static inline uint32_t v_bits(v_mask a) {
  return (uint32_t)_mm256_movemask_ps(a);
}
static inline v_mask v_from_bits(uint32_t bits) {
  const __m256i lane = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  const __m256i set = _mm256_and_si256(_mm256_set1_epi32((int)bits), lane);
  return _mm256_castsi256_ps(_mm256_cmpeq_epi32(set, lane));
}
static inline v_float v_select(v_mask m, v_float a, v_float b) {
  return _mm256_blendv_ps(b, a, m);
}
static inline v_uint v_selectu(v_mask m, v_uint a, v_uint b) {
  return _mm256_blendv_epi8(b, a, _mm256_castps_si256(m));
}
static inline v_mask v_above(uint32_t x, v_uint a) {
  const __m256i flip = _mm256_set1_epi32(INT32_MIN);
  const __m256i b = _mm256_set1_epi32((int)(x ^ 0x80000000u));
  return _mm256_castsi256_ps(_mm256_cmpgt_epi32(_mm256_xor_si256(a, flip), b));
}
static inline v_mask v_equ(v_uint a, v_uint b) {
  return _mm256_castsi256_ps(_mm256_cmpeq_epi32(a, b));
}
static inline v_uint v_pick(v_mask m, v_uint a, const uint32_t *table, const int stride,
                            v_uint index) {
  const __m256i at = _mm256_mullo_epi32(index, _mm256_set1_epi32(stride));
  const __m256i there = _mm256_xor_si256(_mm256_castps_si256(m), _mm256_set1_epi32(-1));
  return _mm256_mask_i32gather_epi32(a, (const int *)table, at, there, 4);
}
static inline v_float v_next(v_float a, int up) {
  const __m256i bits = _mm256_castps_si256(a);
  const __m256i negative = _mm256_srai_epi32(bits, 31);
  const __m256i magnitude = _mm256_and_si256(bits, _mm256_set1_epi32(INT32_MAX));
  const __m256i step = _mm256_blendv_epi8(_mm256_set1_epi32(up), _mm256_set1_epi32(-up), negative);
  const __m256i zero = _mm256_set1_epi32(up > 0 ? 1 : INT32_MIN + 1);
  const __m256i none = _mm256_cmpeq_epi32(magnitude, _mm256_setzero_si256());
  return _mm256_castsi256_ps(_mm256_blendv_epi8(_mm256_add_epi32(bits, step), zero, none));
}
static inline v_uint v_from(uint32_t first) {
  return _mm256_add_epi32(_mm256_set1_epi32((int)first), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
}
static inline v_float v_as_float(v_uint a) {
  return _mm256_castsi256_ps(a);
}
static inline void v_store_packed(float *p, v_float a, uint32_t set) {
  _mm_storeu_ps(p, f4_to_front(_mm256_castps256_ps128(a), set));
  p += __builtin_popcount(set & 15);
  _mm_storeu_ps(p, f4_to_front(_mm256_extractf128_ps(a, 1), set >> 4));
}
static inline float v_reduce_min(v_float a) {
  const __m128 h = _mm_min_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
  const __m128 q = _mm_min_ps(h, _mm_movehl_ps(h, h));
  return _mm_cvtss_f32(_mm_min_ss(q, _mm_shuffle_ps(q, q, 1)));
}
static inline float v_reduce_max(v_float a) {
  const __m128 h = _mm_max_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
  const __m128 q = _mm_max_ps(h, _mm_movehl_ps(h, h));
  return _mm_cvtss_f32(_mm_max_ss(q, _mm_shuffle_ps(q, q, 1)));
}
static inline v_float v_least_of_rows(const v_float row[V_LANES]) {
  __m256 pair[4], four[2];
  for (int i = 0; i < 4; i++)
    pair[i] = _mm256_min_ps(_mm256_unpacklo_ps(row[2 * i], row[2 * i + 1]),
                            _mm256_unpackhi_ps(row[2 * i], row[2 * i + 1]));
  for (int i = 0; i < 2; i++) {
    const __m256d a = _mm256_castps_pd(pair[2 * i]), b = _mm256_castps_pd(pair[2 * i + 1]);
    four[i] = _mm256_min_ps(_mm256_castpd_ps(_mm256_unpacklo_pd(a, b)),
                            _mm256_castpd_ps(_mm256_unpackhi_pd(a, b)));
  }
  return _mm256_min_ps(_mm256_permute2f128_ps(four[0], four[1], 0x20),
                       _mm256_permute2f128_ps(four[0], four[1], 0x31));
}

/* ---- SSE4.2: four lanes
 * ---------------------------------------------------------------------------- */

#elif defined(__SSE4_2__)
#define V_LANES 4
typedef __m128 v_float;
typedef __m128i v_uint;
typedef __m128 v_mask;

static inline v_float v_set(float x) {
  return _mm_set1_ps(x);
}
static inline v_float v_load(const float *p) {
  return _mm_loadu_ps(p);
}
static inline void v_store(float *p, v_float a) {
  _mm_storeu_ps(p, a);
}
static inline v_uint v_setu(uint32_t x) {
  return _mm_set1_epi32((int)x);
}
static inline v_uint v_loadu(const uint32_t *p) {
  return _mm_loadu_si128((const __m128i *)p);
}
static inline void v_storeu(uint32_t *p, v_uint a) {
  _mm_storeu_si128((__m128i *)p, a);
}
static inline v_float v_min(v_float a, v_float b) {
  return _mm_min_ps(a, b);
}
static inline v_float v_max(v_float a, v_float b) {
  return _mm_max_ps(a, b);
}
static inline v_float v_abs(v_float a) {
  return _mm_andnot_ps(_mm_set1_ps(-0.0f), a);
}
static inline v_float v_sqrt(v_float a) {
  return _mm_sqrt_ps(a);
}
static inline v_float v_fused(v_float a, v_float b, v_float c) {
  return a * b + c;
}
static inline v_float v_copysign(v_float a, v_float b) {
  return _mm_or_ps(a, _mm_and_ps(b, _mm_set1_ps(-0.0f)));
}
static inline v_mask v_lt(v_float a, v_float b) {
  return _mm_cmplt_ps(a, b);
}
static inline v_mask v_le(v_float a, v_float b) {
  return _mm_cmple_ps(a, b);
}
static inline v_mask v_eq(v_float a, v_float b) {
  return _mm_cmpeq_ps(a, b);
}
static inline v_mask v_and(v_mask a, v_mask b) {
  return _mm_and_ps(a, b);
}
static inline v_mask v_or(v_mask a, v_mask b) {
  return _mm_or_ps(a, b);
}
static inline v_mask v_andnot(v_mask a, v_mask b) {
  return _mm_andnot_ps(b, a);
}
static inline uint32_t v_bits(v_mask a) {
  return (uint32_t)_mm_movemask_ps(a);
}
static inline v_mask v_from_bits(uint32_t bits) {
  const __m128i lane = _mm_setr_epi32(1, 2, 4, 8);
  const __m128i set = _mm_and_si128(_mm_set1_epi32((int)bits), lane);
  return _mm_castsi128_ps(_mm_cmpeq_epi32(set, lane));
}
static inline v_float v_select(v_mask m, v_float a, v_float b) {
  return _mm_blendv_ps(b, a, m);
}
static inline v_uint v_selectu(v_mask m, v_uint a, v_uint b) {
  return _mm_blendv_epi8(b, a, _mm_castps_si128(m));
}
static inline v_mask v_above(uint32_t x, v_uint a) {
  const __m128i flip = _mm_set1_epi32(INT32_MIN);
  const __m128i b = _mm_set1_epi32((int)(x ^ 0x80000000u));
  return _mm_castsi128_ps(_mm_cmpgt_epi32(_mm_xor_si128(a, flip), b));
}
static inline v_mask v_equ(v_uint a, v_uint b) {
  return _mm_castsi128_ps(_mm_cmpeq_epi32(a, b));
}
static inline v_uint v_pick(v_mask m, v_uint a, const uint32_t *table, const int stride,
                            v_uint index) {
  const uint32_t in = ~(uint32_t)_mm_movemask_ps(m);
  uint32_t at[4], to[4];
  _mm_storeu_si128((__m128i *)at, index), _mm_storeu_si128((__m128i *)to, a);
  for (int lane = 0; lane < 4; lane++)
    if (in >> lane & 1)
      to[lane] = table[(uint32_t)stride * at[lane]];
  return _mm_loadu_si128((const __m128i *)to);
}
static inline v_float v_next(v_float a, int up) {
  const __m128i bits = _mm_castps_si128(a);
  const __m128i negative = _mm_srai_epi32(bits, 31);
  const __m128i magnitude = _mm_and_si128(bits, _mm_set1_epi32(INT32_MAX));
  const __m128i step = _mm_blendv_epi8(_mm_set1_epi32(up), _mm_set1_epi32(-up), negative);
  const __m128i zero = _mm_set1_epi32(up > 0 ? 1 : INT32_MIN + 1);
  const __m128i none = _mm_cmpeq_epi32(magnitude, _mm_setzero_si128());
  return _mm_castsi128_ps(_mm_blendv_epi8(_mm_add_epi32(bits, step), zero, none));
}
static inline v_uint v_from(uint32_t first) {
  return _mm_add_epi32(_mm_set1_epi32((int)first), _mm_setr_epi32(0, 1, 2, 3));
}
static inline v_float v_as_float(v_uint a) {
  return _mm_castsi128_ps(a);
}
static inline void v_store_packed(float *p, v_float a, uint32_t set) {
  _mm_storeu_ps(p, f4_to_front(a, set));
}
static inline float v_reduce_min(v_float a) {
  const __m128 q = _mm_min_ps(a, _mm_movehl_ps(a, a));
  return _mm_cvtss_f32(_mm_min_ss(q, _mm_shuffle_ps(q, q, 1)));
}
static inline float v_reduce_max(v_float a) {
  const __m128 q = _mm_max_ps(a, _mm_movehl_ps(a, a));
  return _mm_cvtss_f32(_mm_max_ss(q, _mm_shuffle_ps(q, q, 1)));
}
static inline v_float v_least_of_rows(const v_float row[V_LANES]) {
  __m128 a = row[0], b = row[1], c = row[2], d = row[3];
  _MM_TRANSPOSE4_PS(a, b, c, d);
  return _mm_min_ps(_mm_min_ps(a, b), _mm_min_ps(c, d));
}

#endif

static inline int v_any(v_mask a) {
  return v_bits(a) != 0;
}
static inline void v_storeu_packed(uint32_t *p, v_uint a, uint32_t set) {
  v_store_packed((float *)p, v_as_float(a), set);
}

/* Lanes as integers, in the compiler's vectors: for sums, shifts and single bits. */
typedef uint32_t lane_bits __attribute__((vector_size(4 * V_LANES)));

static inline uint32_t lane_bits_any(lane_bits a) {
  uint32_t any = 0;
  for (uint32_t lane = 0; lane < V_LANES; lane++)
    any |= a[lane];
  return any;
}
