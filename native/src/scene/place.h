/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* One triangle of one instance, placed in the world and brought into scene space. */

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
static inline bool whittle_zero_area(const float v[3][3]) {
  double a[3], b[3];
  for (int i = 0; i < 3; i++) {
    a[i] = (double)v[1][i] - (double)v[0][i];
    b[i] = (double)v[2][i] - (double)v[0][i];
  }
  return a[1] * b[2] == a[2] * b[1] && a[2] * b[0] == a[0] * b[2] && a[0] * b[1] == a[1] * b[0];
}

/* `scale` is 2^-exponent of the frame. Zeros come out positive, so that the smallest and largest of
 * several values have the same bits in whichever order they are found. */
static inline placement whittle_place_triangle(const mesh *m, const instance *where,
                                               uint32_t triangle, const scene_frame *frame,
                                               double scale, float v[3][3]) {
  const uint32_t *corners = m->triangles + 3 * (size_t)triangle;
  bool finite = true;
  for (int k = 0; k < 3; k++) {
    double world[3];
    finite &= whittle_place_vertex(m, where, corners[k], world);
    for (int i = 0; i < 3; i++)
      v[k][i] = (float)((world[i] - frame->center[i]) * scale) + 0.0f;
  }
  if (!finite)
    return PLACED_NON_FINITE;
  return whittle_zero_area((const float(*)[3])v) ? PLACED_ZERO_AREA : PLACED;
}
