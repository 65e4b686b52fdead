/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Constants and small helpers of the exact tests, and a node's test for one ray. */

#pragma once

#include "kernel/kernel.h"
#include "kernel/simd.h"
#include "scene/triangles.h"

/* Boxes are grown by this share of the distance from the ray's origin to their farthest side. The
 * edge test decides for vertices that are off by 6 * 2^-24 of that, and a slab's own arithmetic
 * adds 4 (Ize, Robust BVH Ray Traversal, JCGT 2013): so no accepted triangle misses its own box. */
#define WHITTLE_BOX_PAD 0x1p-20f

/* And nodes: the same, so that they contain the intervals of their triangles. */
#ifndef WHITTLE_BREAK_PADDING
#define WHITTLE_NODE_PAD WHITTLE_BOX_PAD
#else
#define WHITTLE_NODE_PAD 0.0f
#endif

#define WHITTLE_STACK (WHITTLE_MAX_DEPTH + 2)

/* The power of two that brings the largest of three numbers to [1, 2), or 1 for zeros. */
static inline double whittle_to_unit(double a, double b, double c) {
  double most = __builtin_fabs(a);
  most = __builtin_fabs(b) > most ? __builtin_fabs(b) : most;
  most = __builtin_fabs(c) > most ? __builtin_fabs(c) : most;
  uint64_t bits;
  memcpy(&bits, &most, 8);
  const uint64_t exponent = bits >> 52;
  if (exponent == 0)
    return 1.0;
  const uint64_t inverse = (2046 - exponent) << 52;
  double scale;
  memcpy(&scale, &inverse, 8);
  return scale;
}

/* The axis on which a direction is longest, ties to x before y before z. */
static inline int whittle_dominant_axis(const float d[3]) {
  const float x = s_abs(d[0]), y = s_abs(d[1]), z = s_abs(d[2]);
  return x >= y && x >= z ? 0 : y >= z ? 1 : 2;
}

/* What decides a hit once the edges are passed. */
typedef struct triangle_plane {
  float normal[3]; /* about unit size */
  float low[3], high[3];
} triangle_plane;

/* Edges are exact in double, so needles keep their normals; the power of two keeps the smallest
 * triangles from underflowing. */
static inline triangle_plane whittle_plane(const triangle_record *triangle) {
  double e1[3], e2[3], n[3];
  triangle_plane plane;
  for (int i = 0; i < 3; i++) {
    e1[i] = (double)triangle->v1[i] - triangle->v0[i];
    e2[i] = (double)triangle->v2[i] - triangle->v0[i];
    plane.low[i] = s_min(s_min(triangle->v0[i], triangle->v1[i]), triangle->v2[i]);
    plane.high[i] = s_max(s_max(triangle->v0[i], triangle->v1[i]), triangle->v2[i]);
  }
  n[0] = e1[1] * e2[2] - e1[2] * e2[1];
  n[1] = e1[2] * e2[0] - e1[0] * e2[2];
  n[2] = e1[0] * e2[1] - e1[1] * e2[0];
  const double scale = whittle_to_unit(n[0], n[1], n[2]);
  for (int i = 0; i < 3; i++)
    plane.normal[i] = (float)(n[i] * scale);
  return plane;
}

#define FAMILY(name) s_##name
#define FAMILY_LANES S_LANES
#include "kernel/triangle.inl"
#undef FAMILY
#undef FAMILY_LANES

#define FAMILY(name) v_##name
#define FAMILY_LANES V_LANES
#include "kernel/triangle.inl"
#undef FAMILY
#undef FAMILY_LANES
