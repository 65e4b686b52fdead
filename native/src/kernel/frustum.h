/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Frustums around rays that share dominant axis and octant: what they cannot reach is culled. */

#pragma once

#include "kernel/box.h"

/* At depth z along the axis a ray is at slope * z from its origin. A hit lies in the padded slab
 * interval of a box, so within the box grown by the pad and 4 ulp of the distance to its planes;
 * culling by the ranges of origins and slopes with twice that slack can therefore lose none. */
#define FRUSTUM_SLACK (4.0f * 0x1p-19f)

/* Several frustums as structures of arrays, one for each lane group of a packet. Slopes are by depth
 * along the dominant axis, in its sense. */
#define FRUSTUM_ROOM (WHITTLE_MAX_PACKET / V_LANES + V_LANES)
typedef struct frustums {
  float origin_min[3][FRUSTUM_ROOM], origin_max[3][FRUSTUM_ROOM];
  float slope_min[3][FRUSTUM_ROOM], slope_max[3][FRUSTUM_ROOM];
  float deepest[FRUSTUM_ROOM]; /* no hit of any of the rays lies deeper any more */
} frustums;

static inline v_float larger_abs(v_float a, v_float b) { return v_max(v_abs(a), v_abs(b)); }

/* Which of the V_LANES frustums from `at` on may reach into the box. */
static inline v_mask frustums_reach(const frustums *f, uint32_t at, int k, bool negative,
                                    const float low[3], const float high[3]) {
  const v_float slack = v_set(FRUSTUM_SLACK), nothing = v_set(0.0f);
  const v_float least = v_load(&f->origin_min[k][at]), most = v_load(&f->origin_max[k][at]);
  v_float front = negative ? least - v_set(high[k]) : v_set(low[k]) - most;
  v_float back = negative ? most - v_set(low[k]) : v_set(high[k]) - least;
  const v_float grow = slack * larger_abs(front, back);
  front = front - grow, back = back + grow;
  v_mask reach = v_and(v_le(nothing, back), v_le(front, v_load(&f->deepest[at])));
  front = v_max(front, nothing);
  for (int i = 1; i < 3; i++) {
    const int a = (k + i) % 3;
    const v_float slope_min = v_load(&f->slope_min[a][at]), slope_max = v_load(&f->slope_max[a][at]);
    const v_float left = slope_min * v_select(v_lt(slope_min, nothing), back, front);
    const v_float right = slope_max * v_select(v_lt(slope_max, nothing), front, back);
    const v_float begin = v_set(low[a]) - v_load(&f->origin_max[a][at]);
    const v_float end = v_set(high[a]) - v_load(&f->origin_min[a][at]);
    const v_float room = slack * (larger_abs(begin, end) + larger_abs(left, right));
    reach = v_and(reach, v_and(v_le(left, end + room), v_le(begin - room, right)));
  }
  return reach;
}
