/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Frustums around rays that share dominant axis and octant: what they cannot reach is culled. */

#pragma once

#include "kernel/box.h"
#include "kernel/simd_bytes.h"

/* At depth z along the axis a ray is at slope * z from its origin, with |slope| <= 1. A hit's
 * vertices lie on both sides of the ray to 6 * 2^-24 of the distance to the farthest side of their
 * box, and it begins no deeper than WHITTLE_BOX_PAD of that before the box: twice the pad loses
 * none. */
#define FRUSTUM_SLACK (2.0f * WHITTLE_BOX_PAD)

/* Ranges of a set of rays; slopes are by depth along the dominant axis, in its sense. */
typedef struct frustum {
  float origin_min[3], origin_max[3];
  float slope_min[3], slope_max[3];
  float deepest; /* no hit of any of the rays lies deeper any more */
} frustum;

/* Many of them as structures of arrays: one for each lane group of a packet. */
#define FRUSTUM_ROOM (WHITTLE_MAX_PACKET / V_LANES + V_BYTES)
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

/* The lanes whose frustum may reach into its box, and the depth at which it would. k is the
 * dominant axis. A box with NaN bounds is not reached. */
static inline v_mask frustum_reaches(const v_frustum *f, int k, bool negative, const v_float low[3],
                                     const v_float high[3], v_float *depth) {
  const v_float nothing = v_set(0.0f);
  v_float begin[3], end[3], reach = nothing;
  for (int i = 0; i < 3; i++) {
    begin[i] = low[i] - f->origin_max[i], end[i] = high[i] - f->origin_min[i];
    reach = v_max(v_max(nothing - begin[i], end[i]), reach);
  }
  const v_float behind = nothing - end[k], before = nothing - begin[k];
  const v_float room = v_set(FRUSTUM_SLACK) * reach;
  const v_float front = v_max((negative ? behind : begin[k]) - room, nothing);
  const v_float back = (negative ? before : end[k]) + room;
  v_mask meets = v_and(v_le(nothing, back), v_le(front, f->deepest));
  for (int i = 1; i < 3; i++) {
    const int a = k + i < 3 ? k + i : k + i - 3;
    const v_float left = f->slope_min[a] * v_select(v_lt(f->slope_min[a], nothing), back, front);
    const v_float right = f->slope_max[a] * v_select(v_lt(f->slope_max[a], nothing), front, back);
    meets = v_and(meets, v_and(v_le(left, end[a] + room), v_le(begin[a] - room, right)));
  }
  *depth = front;
  return meets;
}

/* A frustum whose lines nearly meet in a point, for boxes of nodes that are not small beside the
 * scene, which is about 1 wide: four planes through the point, and two across the axis. All slack
 * is folded into the planes: twice FRUSTUM_SLACK of the farthest that anything can be away, because
 * it counts for both of a plane's bounds, and as much again for the rounding of these few steps. */
typedef struct point_frustum {
  uint32_t front, back;     /* rows of a node: its bounds along the axis as they are met */
  uint32_t turn[4], row[4]; /* bound along the axis that a plane takes, and that beside it */
  float slope[4], side[4];  /* slope * turn + side * row + offset >= 0 where the plane is passed */
  float offset[4], begin, end, sense;
} point_frustum;

/* `low` and `high` are the rows of the bounds on the axes in order. */
static inline point_frustum point_frustum_of(const frustum *f, const float point[3], float spread,
                                             const int order[3], bool negative,
                                             const uint32_t low[3], const uint32_t high[3]) {
  const float away = s_max(s_max(s_abs(point[0]), s_abs(point[1])), s_abs(point[2])) + 1.0f;
  const float room = 2.0f * spread + away * (4.0f * FRUSTUM_SLACK);
  const int k = order[2];
  point_frustum planes = {.sense = negative ? -1.0f : 1.0f};
  planes.front = negative ? high[k] : low[k], planes.back = negative ? low[k] : high[k];
  const float depth = planes.sense * point[k];
  planes.begin = -depth - room, planes.end = -depth + room;
  for (int i = 0; i < 2; i++) {
    const int a = order[i];
    const float least = f->slope_min[a], most = f->slope_max[a];
    /* least * depth <= high, low <= most * depth */
    planes.row[2 * i] = high[a], planes.side[2 * i] = 1.0f;
    planes.slope[2 * i] = -least * planes.sense;
    planes.turn[2 * i] = least < 0.0f ? planes.back : planes.front;
    planes.offset[2 * i] = room - point[a] + least * depth;
    planes.row[2 * i + 1] = low[a], planes.side[2 * i + 1] = -1.0f;
    planes.slope[2 * i + 1] = most * planes.sense;
    planes.turn[2 * i + 1] = most < 0.0f ? planes.front : planes.back;
    planes.offset[2 * i + 1] = room + point[a] - most * depth;
  }
  return planes;
}

/* The lanes whose box, in rows of a node, the frustum may reach no deeper than `deepest`. */
static inline v_mask point_frustum_reaches(const point_frustum *f, const float *rows, float deepest,
                                           v_float *depth) {
  const v_float sense = v_set(f->sense), nothing = v_set(0.0f);
  v_float least = v_fused(v_load(rows + f->back), sense, v_set(f->end));
  *depth = v_fused(v_load(rows + f->front), sense, v_set(f->begin));
  for (int i = 0; i < 4; i++) {
    const v_float to = v_fused(v_load(rows + f->row[i]), v_set(f->side[i]), v_set(f->offset[i]));
    least = v_min(v_fused(v_load(rows + f->turn[i]), v_set(f->slope[i]), to), least);
  }
  return v_and(v_le(nothing, least), v_le(*depth, v_set(deepest)));
}
