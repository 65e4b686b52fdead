/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Constants and small helpers of the exact tests, and a node's test for one ray. */

#pragma once

#include "bvh/bvh.h"
#include "kernel/kernel.h"
#include "kernel/simd.h"

/* Share by which slab intervals grow at both ends: Ize, Robust BVH Ray Traversal, JCGT 2013 needs
 * 2 ulp for boxes; the triangle test's own rounding, relative to its vertices, needs 8 more. */
#ifndef WHITTLE_BREAK_PADDING
#define WHITTLE_SLAB_PAD 0x1p-19f
#else
#define WHITTLE_SLAB_PAD 0.0f
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
