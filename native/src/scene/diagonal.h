/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Which of its diagonals divides a quad: the one from the first corner to the third if the areas A
 * and B of the halves beside it, as vectors, face the same way: A.B > 0. If A.B < 0 the second and
 * the fourth corner are on one side of it, or the quad is folded there by more than a right angle:
 * the other diagonal. In single precision, A.B is off by at most some roundings of the product of
 * four edges that it is made of; where its sign could come out otherwise, the quad is left open. */

#pragma once

#include "base/float4.h"

#include <math.h>

typedef enum quad_diagonal { DIAGONAL_OPEN, DIAGONAL_FIRST, DIAGONAL_SECOND } quad_diagonal;

/* Sixty-four roundings to single precision, of the product's size: a few times what can add up. */
#define QUAD_DOUBT 0x1p-18

/* What is lost in numbers too small for single precision, while squares of edges are below the
 * latter: and then none is too large. */
#define QUAD_LOST 1e-30
#define QUAD_LARGE 1e12

static inline double quad_dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void quad_cross(const double a[3], const double b[3], double out[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

/* The corners' coordinates. In double, next to nothing is rounded. */
static inline quad_diagonal whittle_quad_diagonal(const float *const corner[4]) {
  double e[3][3], a[3], b[3];
  for (int i = 0; i < 3; i++)
    for (int axis = 0; axis < 3; axis++)
      e[i][axis] = (double)corner[i + 1][axis] - (double)corner[0][axis];
  quad_cross(e[0], e[1], a);
  quad_cross(e[1], e[2], b);
  const double e1 = quad_dot(e[0], e[0]), e2 = quad_dot(e[1], e[1]), e3 = quad_dot(e[2], e[2]);
  const double product = quad_dot(a, b), doubt = QUAD_DOUBT * e2 * sqrt(e1 * e3) + QUAD_LOST;
  if (!(e1 + e2 + e3 < QUAD_LARGE && fabs(product) > doubt))
    return DIAGONAL_OPEN;
  return product > 0.0 ? DIAGONAL_FIRST : DIAGONAL_SECOND;
}

/* A vector of each of four quads. */
typedef struct four_vectors {
  float4 axis[3];
} four_vectors;

static inline float4 four_dot(const four_vectors *a, const four_vectors *b) {
  return float4_add(
      float4_add(float4_mul(a->axis[0], b->axis[0]), float4_mul(a->axis[1], b->axis[1])),
      float4_mul(a->axis[2], b->axis[2]));
}

static inline four_vectors four_sub(const four_vectors *a, const four_vectors *b) {
  four_vectors out;
  for (int i = 0; i < 3; i++)
    out.axis[i] = float4_sub(a->axis[i], b->axis[i]);
  return out;
}

static inline four_vectors four_cross(const four_vectors *a, const four_vectors *b) {
  four_vectors out;
  for (int i = 0; i < 3; i++) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    out.axis[i] =
        float4_sub(float4_mul(a->axis[j], b->axis[k]), float4_mul(a->axis[k], b->axis[j]));
  }
  return out;
}

/* Of four quads, a bit for each that surely has DIAGONAL_FIRST, by a wider bound in single
 * precision: the product of four edges is below the square of the sum E of the edges' squares.
 * corner[4 k + i] is the i-th corner of the k-th quad, with one float more behind it. */
static inline uint32_t whittle_four_plain_quads(const float *const corner[16]) {
  four_vectors at[4];
  for (int i = 0; i < 4; i++)
    float4_columns(corner[i], corner[4 + i], corner[8 + i], corner[12 + i], at[i].axis);
  const four_vectors e1 = four_sub(&at[1], &at[0]), e2 = four_sub(&at[2], &at[0]),
                     e3 = four_sub(&at[3], &at[0]);
  const four_vectors a = four_cross(&e1, &e2), b = four_cross(&e2, &e3);
  const float4 edges =
      float4_add(float4_add(four_dot(&e1, &e1), four_dot(&e2, &e2)), four_dot(&e3, &e3));
  const float4 doubt =
      float4_add(float4_mul(float4_all((float)QUAD_DOUBT), float4_mul(edges, edges)),
                 float4_all((float)QUAD_LOST));
  return float4_bits(float4_and(float4_less(doubt, four_dot(&a, &b)),
                                float4_less(edges, float4_all((float)QUAD_LARGE))));
}
