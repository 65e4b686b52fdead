/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The caller's rays, brought into scene space in chunks. */

#pragma once

#include "scene/scene.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { RAY_CHUNK = 256 };

/* Rays in scene space. The largest component of a direction has a magnitude in [1, 2], so t here is
 * the caller's t / 2^t_exponent. A hit has t_min < t <= t_max; both limits were rounded down, which
 * is the same as comparing a float t with the exact limits. A ray that cannot hit has t_max = -1,
 * t_min = 0 and a harmless direction; so have the entries from count to the next multiple of 16. */
typedef struct ray_chunk {
  float origin[3][RAY_CHUNK], direction[3][RAY_CHUNK];
  float t_min[RAY_CHUNK], t_max[RAY_CHUNK];
  int32_t t_exponent[RAY_CHUNK];
  uint32_t count;
  bool one_origin; /* known to be the same in all entries up to count */
} ray_chunk;

static inline uint32_t float_bits(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return bits;
}

static inline float bits_float(uint32_t bits) {
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

/* What can be said without reading every ray: missing arrays and unknown bits. */
whittle_status whittle_rays_check(const whittle_rays *rays, whittle_error *error);

/* Reads one ray, however odd its numbers, as entry i. */
void whittle_ray_load(const scene_frame *frame, const whittle_rays *rays, size_t ray,
                      ray_chunk *chunk, uint32_t i);

/* Reads rays first .. first + count - 1, count <= RAY_CHUNK: what the kernels' `load` does faster.
 */
void whittle_rays_load(const scene_frame *frame, const whittle_rays *rays, size_t first,
                       uint32_t count, ray_chunk *chunk);

/* Fills the entries from count to the next multiple of 16. */
void whittle_rays_pad(ray_chunk *chunk);

/* t in the caller's units: exact, but FLT_MAX where it would overflow; infinity (a miss) stays. */
static inline float whittle_rays_t(const ray_chunk *chunk, uint32_t ray, float t) {
  const int32_t wanted = chunk->t_exponent[ray];
  const int32_t exponent = wanted < -400 ? -400 : wanted > 400 ? 400 : wanted;
  const uint64_t bits = (uint64_t)(1023 + exponent) << 52;
  double scale;
  memcpy(&scale, &bits, sizeof scale);
  const double scaled = (double)t * scale;
  return scaled > FLT_MAX && t <= FLT_MAX ? FLT_MAX : (float)scaled;
}
