/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Scene space: a power of two and a centre on its grid. */

#include "scene/frame.h"

/* World positions fit a float, so extents stay below 2^129; at the other end 2^-exponent must. */
enum { LEAST_EXPONENT = -1000 };

/* The least k with extent <= 2^k. */
static int exponent_for(double extent) {
  int exponent = 0;
  const double mantissa = frexp(extent, &exponent);
  if (extent == 0.0)
    return 0;
  if (mantissa == 0.5)
    exponent--;
  return exponent < LEAST_EXPONENT ? LEAST_EXPONENT : exponent;
}

scene_frame whittle_frame_of(const world_bounds *bounds) {
  scene_frame frame = {.center = {0.0, 0.0, 0.0}, .exponent = 0};
  double extent = 0.0;
  if (!(bounds->lo[0] <= bounds->hi[0]))
    return frame;
  for (int i = 0; i < 3; i++)
    extent = fmax(extent, bounds->hi[i] - bounds->lo[i]);
  frame.exponent = exponent_for(extent);
  for (int i = 0; i < 3; i++) {
    const double middle = 0.5 * bounds->lo[i] + 0.5 * bounds->hi[i];
    const double step = floor(ldexp(middle, -frame.exponent) + 0.5);
    frame.center[i] = ldexp(step, frame.exponent) + 0.0; /* not -0 */
  }
  return frame;
}
