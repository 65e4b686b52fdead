/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Vertices placed in the world and brought into scene space, and what is wrong with a triangle. */

#pragma once

#include "base/matrix.h"
#include "scene/scene.h"

#include <float.h>
#include <math.h>

typedef enum placement { PLACED, PLACED_NON_FINITE, PLACED_ZERO_AREA } placement;

/* A vertex in world space; false if it is not finite as a float. */
static inline bool whittle_place_vertex(const mesh *m, const instance *where, uint32_t vertex,
                                        double world[3]) {
  const float *p = m->positions + 3 * (size_t)vertex;
  const double local[3] = {p[0], p[1], p[2]};
  whittle_matrix_point(where->transform, local, world);
  return fabs(world[0]) <= FLT_MAX && fabs(world[1]) <= FLT_MAX && fabs(world[2]) <= FLT_MAX;
}

/* Whether the cross product of two edges is exactly 0: the triangle is a line or a point. */
static inline bool whittle_zero_area(const float a[3], const float b[3], const float c[3]) {
  double p[3], q[3];
  for (int i = 0; i < 3; i++) {
    p[i] = (double)b[i] - (double)a[i];
    q[i] = (double)c[i] - (double)a[i];
  }
  return p[1] * q[2] == p[2] * q[1] && p[2] * q[0] == p[0] * q[2] && p[0] * q[1] == p[1] * q[0];
}

/* `scale` is 2^-exponent of the frame. Zeros come out positive, so that the smallest and largest of
 * several values have the same bits in whichever order they are found. A vertex that is not finite
 * becomes NaN. */
static inline void whittle_place_in_scene(const mesh *m, const instance *where, uint32_t vertex,
                                          const scene_frame *frame, double scale, float out[3]) {
  double world[3];
  const bool finite = whittle_place_vertex(m, where, vertex, world);
  for (int i = 0; i < 3; i++)
    out[i] = finite ? (float)((world[i] - frame->center[i]) * scale) + 0.0f : NAN;
}

/* What becomes of a triangle with these vertices. */
static inline placement whittle_judge_triangle(const float a[3], const float b[3],
                                               const float c[3]) {
  if (isnan(a[0]) || isnan(b[0]) || isnan(c[0]))
    return PLACED_NON_FINITE;
  return whittle_zero_area(a, b, c) ? PLACED_ZERO_AREA : PLACED;
}
