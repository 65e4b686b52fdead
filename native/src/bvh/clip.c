/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Clipping plane by plane (Sutherland, Hodgman: Reentrant Polygon Clipping, 1974). */

#include "bvh/clip.h"

#include <math.h>
#include <string.h>

polygon whittle_polygon_of(const float *corners) {
  polygon p = {.count = 3};
  for (int i = 0; i < 9; i++)
    p.at[i / 3][i % 3] = corners[i];
  return p;
}

static void add(polygon *p, const double at[3]) {
  if (p->count < POLYGON_MOST)
    memcpy(p->at[p->count++], at, sizeof p->at[0]);
}

/* Where the edge from a to b meets the plane; the coordinate on its axis is exact. */
static void add_crossing(polygon *p, const double a[3], const double b[3], int axis, double plane) {
  const double share = (plane - a[axis]) / (b[axis] - a[axis]);
  double at[3];
  for (int i = 0; i < 3; i++)
    at[i] = a[i] + share * (b[i] - a[i]);
  at[axis] = plane;
  add(p, at);
}

/* Keeps what lies where side * (coordinate - plane) >= 0. */
static void cut(polygon *p, int axis, double plane, double side) {
  uint32_t kept = 0;
  for (uint32_t i = 0; i < p->count; i++)
    kept += side * (p->at[i][axis] - plane) >= 0.0;
  if (kept == p->count)
    return;
  const polygon whole = *p;
  p->count = 0;
  for (uint32_t i = 0; kept && i < whole.count; i++) {
    const double *a = whole.at[i], *b = whole.at[(i + 1) % whole.count];
    const int a_in = side * (a[axis] - plane) >= 0.0, b_in = side * (b[axis] - plane) >= 0.0;
    if (a_in)
      add(p, a);
    if (a_in != b_in)
      add_crossing(p, a, b, axis, plane);
  }
}

void whittle_polygon_clip(const polygon *whole, const whittle_node *box, polygon *inside) {
  *inside = *whole;
  for (int axis = 0; axis < 3; axis++) {
    cut(inside, axis, box->bounds_min[axis], 1.0);
    cut(inside, axis, box->bounds_max[axis], -1.0);
    if (inside->count == 0)
      return;
  }
}

double whittle_polygon_area(const polygon *p) {
  double sum[3] = {0.0, 0.0, 0.0};
  for (uint32_t i = 1; i + 1 < p->count; i++) {
    double a[3], b[3];
    for (int k = 0; k < 3; k++) {
      a[k] = p->at[i][k] - p->at[0][k];
      b[k] = p->at[i + 1][k] - p->at[0][k];
    }
    sum[0] += a[1] * b[2] - a[2] * b[1];
    sum[1] += a[2] * b[0] - a[0] * b[2];
    sum[2] += a[0] * b[1] - a[1] * b[0];
  }
  return 0.5 * sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
}
