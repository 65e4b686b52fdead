/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The frustum around a packet of rays that share dominant axis and sign. */

#pragma once

#include "kernel/box.h"

/* At depth z along the axis a ray is at x = slope * z from its origin. A hit lies in the padded slab
 * interval of a box, so within the box grown by the pad and 4 ulp of the distance to its planes;
 * culling by the ranges of origins and slopes with twice that slack can therefore lose none. */
#define FRUSTUM_SLACK (4.0f * 0x1p-19f)

typedef struct frustum {
  bool valid;
  int axis;
  float sign;
  float origin_min[3], origin_max[3];
  float slope_min[3], slope_max[3]; /* against the dominant axis, per unit of depth */
  float deepest;                    /* no hit of any ray lies deeper any more */
} frustum;

/* Whether no ray of the packet can hit anything inside the box. */
static inline bool frustum_misses(const frustum *f, const float low[3], const float high[3]) {
  const int k = f->axis;
  float front = f->sign > 0.0f ? low[k] - f->origin_max[k] : f->origin_min[k] - high[k];
  float back = f->sign > 0.0f ? high[k] - f->origin_min[k] : f->origin_max[k] - low[k];
  const float grow = FRUSTUM_SLACK * s_max(s_abs(front), s_abs(back));
  front -= grow, back += grow;
  if (back < 0.0f || front > f->deepest)
    return true;
  front = s_max(front, 0.0f);
  for (int i = 1; i < 3; i++) {
    const int a = (k + i) % 3;
    const float least = f->slope_min[a] * (f->slope_min[a] < 0.0f ? back : front);
    const float most = f->slope_max[a] * (f->slope_max[a] < 0.0f ? front : back);
    const float left = low[a] - f->origin_max[a], right = high[a] - f->origin_min[a];
    const float slack = FRUSTUM_SLACK * (s_max(s_abs(left), s_abs(right)) +
                                         s_max(s_abs(least), s_abs(most)));
    if (least > right + slack || most < left - slack)
      return true;
  }
  return false;
}
