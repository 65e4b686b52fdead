/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* A node that waits to be built: a stretch of fragments and what is known of it. */

#pragma once

#include "base/float4.h"
#include "bvh/bvh.h"

/* Boxes of four lanes, the last one meaningless. */
typedef struct box4 {
  float4 lo, hi;
} box4;

static inline box4 box4_empty(void) {
  return (box4){float4_all(__builtin_inff()), float4_all(-__builtin_inff())};
}

static inline box4 box4_union(box4 a, box4 b) {
  return (box4){float4_min(a.lo, b.lo), float4_max(a.hi, b.hi)};
}

static inline box4 fragment_box(const whittle_fragment *f) {
  return (box4){float4_load(f->lo), float4_load(f->hi)};
}

/* Twice the centroid; the fourth lane is 0. */
static inline float4 box4_middle(box4 box) {
  return float4_add(float4_xyz(box.lo), float4_xyz(box.hi));
}

typedef struct span {
  box4 bounds;
  box4 middles;       /* bounds of the doubled centroids */
  whittle_node *node; /* what is to become of the span */
  uint32_t room;      /* the first of 2 (count - 1) places for the nodes below it */
  uint32_t first, count, depth;
  uint32_t buffer; /* which of the two holds the fragments */
} span;
