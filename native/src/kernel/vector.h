/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Vectors of three, a lane group of them at a time, in a fixed order of operations. */

#pragma once

#include "kernel/simd.h"

/* Four numbers at a time in double precision, in the compiler's vectors: nothing else needs them.
 */
#define FOUR 4
typedef float four_floats __attribute__((vector_size(16)));
typedef double four_doubles __attribute__((vector_size(32)));
typedef int64_t four_longs __attribute__((vector_size(32)));

/* Compilers take conversions between the two to pieces. */
#if defined(__AVX__)
#define WIDENED(a) ((four_doubles)_mm256_cvtps_pd((__m128)(a)))
#define NARROWED(a) ((four_floats)_mm256_cvtpd_ps((__m256d)(a)))
#else
#define WIDENED(a) __builtin_convertvector((four_floats)(a), four_doubles)
#define NARROWED(a) __builtin_convertvector((a), four_floats)
#endif

typedef struct v_vector {
  v_float x, y, z;
} v_vector;

static inline v_vector vec(v_float x, v_float y, v_float z) {
  return (v_vector){x, y, z};
}
static inline v_vector vec_set(const float v[3]) {
  return vec(v_set(v[0]), v_set(v[1]), v_set(v[2]));
}
static inline v_vector vec_add(v_vector a, v_vector b) {
  return vec(a.x + b.x, a.y + b.y, a.z + b.z);
}
static inline v_vector vec_sub(v_vector a, v_vector b) {
  return vec(a.x - b.x, a.y - b.y, a.z - b.z);
}
static inline v_vector vec_mul(v_vector a, v_vector b) {
  return vec(a.x * b.x, a.y * b.y, a.z * b.z);
}
static inline v_vector vec_scale(v_vector a, v_float s) {
  return vec(a.x * s, a.y * s, a.z * s);
}
static inline v_float vec_dot(v_vector a, v_vector b) {
  return (a.x * b.x + a.y * b.y) + a.z * b.z;
}
static inline v_float vec_most(v_vector a) {
  return v_max(v_max(a.x, a.y), a.z);
}
static inline v_vector vec_abs(v_vector a) {
  return vec(v_abs(a.x), v_abs(a.y), v_abs(a.z));
}
static inline v_vector vec_select(v_mask m, v_vector a, v_vector b) {
  return vec(v_select(m, a.x, b.x), v_select(m, a.y, b.y), v_select(m, a.z, b.z));
}

static inline v_vector vec_load(float *const array[3], uint32_t at) {
  return vec(v_load(array[0] + at), v_load(array[1] + at), v_load(array[2] + at));
}
static inline void vec_store(float *const array[3], uint32_t at, v_vector a) {
  v_store(array[0] + at, a.x), v_store(array[1] + at, a.y), v_store(array[2] + at, a.z);
}
/* Three consecutive rows of a block of V_LANES columns. */
static inline v_vector vec_rows(float (*rows)[V_LANES]) {
  return vec(v_load(rows[0]), v_load(rows[1]), v_load(rows[2]));
}

/* Unit length, or `otherwise` where a has none that a float can hold. */
static inline v_vector vec_unit(v_vector a, v_vector otherwise) {
  const v_float square = vec_dot(a, a);
  const v_mask fine = v_and(v_lt(v_set(0.0f), square), v_lt(square, v_set(__builtin_inff())));
  return vec_select(fine, vec_scale(a, v_set(1.0f) / v_sqrt(square)), otherwise);
}
