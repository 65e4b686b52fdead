/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Frustums around rays that share dominant axis and octant: what they cannot reach is culled. */

#pragma once

#include "kernel/box.h"

/* At depth z along the axis a ray is at slope * z from its origin. A hit lies in the padded slab
 * interval of a box, so within the box grown by the pad and 4 ulp of the distance to its planes;
 * culling by the ranges of origins and slopes with twice that slack can therefore lose none. */
#define FRUSTUM_SLACK (4.0f * WHITTLE_SLAB_PAD)

/* Ranges of a set of rays; slopes are by depth along the dominant axis, in its sense. */
typedef struct frustum {
  float origin_min[3], origin_max[3];
  float slope_min[3], slope_max[3];
  float deepest; /* no hit of any of the rays lies deeper any more */
} frustum;

/* Many of them as structures of arrays: one for each lane group of a packet. */
#define FRUSTUM_ROOM (WHITTLE_MAX_PACKET / V_LANES + V_LANES)
typedef struct frustums {
  float origin_min[3][FRUSTUM_ROOM], origin_max[3][FRUSTUM_ROOM];
  float slope_min[3][FRUSTUM_ROOM], slope_max[3][FRUSTUM_ROOM];
  float deepest[FRUSTUM_ROOM];
} frustums;

/* A frustum in each lane. */
typedef struct v_frustum {
  v_float origin_min[3], origin_max[3], slope_min[3], slope_max[3], deepest;
} v_frustum;

static inline v_frustum frustum_everywhere(const frustum *f) {
  v_frustum all = {.deepest = v_set(f->deepest)};
  for (int i = 0; i < 3; i++) {
    all.origin_min[i] = v_set(f->origin_min[i]), all.origin_max[i] = v_set(f->origin_max[i]);
    all.slope_min[i] = v_set(f->slope_min[i]), all.slope_max[i] = v_set(f->slope_max[i]);
  }
  return all;
}

static inline v_frustum frustums_load(const frustums *f, uint32_t at) {
  v_frustum each = {.deepest = v_load(&f->deepest[at])};
  for (int i = 0; i < 3; i++) {
    each.origin_min[i] = v_load(&f->origin_min[i][at]);
    each.origin_max[i] = v_load(&f->origin_max[i][at]);
    each.slope_min[i] = v_load(&f->slope_min[i][at]);
    each.slope_max[i] = v_load(&f->slope_max[i][at]);
  }
  return each;
}

static inline v_float larger_abs(v_float a, v_float b) {
  return v_max(v_abs(a), v_abs(b));
}

/* The lanes whose frustum may reach into its box, and the depth at which it would. k is the
 * dominant axis. A box with NaN bounds is not reached. */
static inline v_mask frustum_reaches(const v_frustum *f, int k, bool negative, const v_float low[3],
                                     const v_float high[3], v_float *depth) {
  const v_float slack = v_set(FRUSTUM_SLACK), nothing = v_set(0.0f);
  v_float front = negative ? f->origin_min[k] - high[k] : low[k] - f->origin_max[k];
  v_float back = negative ? f->origin_max[k] - low[k] : high[k] - f->origin_min[k];
  const v_float grow = slack * larger_abs(front, back);
  front = front - grow, back = back + grow;
  v_mask reach = v_and(v_le(nothing, back), v_le(front, f->deepest));
  front = v_max(front, nothing);
  for (int i = 1; i < 3; i++) {
    const int a = k + i < 3 ? k + i : k + i - 3;
    const v_float left = f->slope_min[a] * v_select(v_lt(f->slope_min[a], nothing), back, front);
    const v_float right = f->slope_max[a] * v_select(v_lt(f->slope_max[a], nothing), front, back);
    const v_float begin = low[a] - f->origin_max[a], end = high[a] - f->origin_min[a];
    const v_float room = slack * (larger_abs(begin, end) + larger_abs(left, right));
    reach = v_and(reach, v_and(v_le(left, end + room), v_le(begin - room, right)));
  }
  *depth = front;
  return reach;
}
