/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Rebases rays in double precision, scales directions exactly and rounds the
 * limits of t. */

#include "scene/rays.h"

whittle_status whittle_rays_check(const whittle_rays *rays, whittle_error *error) {
  if (rays->visibility & ~(uint32_t)WHITTLE_ALL)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "visibility",
                        "visibility is 0x%x; it must be a sum of CAMERA, "
                        "SHADOW, REFLECTION and "
                        "REFRACTION",
                        (unsigned)rays->visibility);
  if (rays->count == 0)
    return WHITTLE_OK;
  if (!rays->origins.data)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "origins",
                        "there are %zu rays but no origins", rays->count);
  if (!rays->directions.data)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "directions",
                        "there are %zu rays but no directions", rays->count);
  return WHITTLE_OK;
}

static double read_value(const whittle_array *array, size_t ray, int component) {
  const char *at = (const char *)array->data + (ptrdiff_t)ray * array->stride +
                   component * array->component_stride;
  if (array->is_double) {
    double value;
    memcpy(&value, at, sizeof value);
    return value;
  }
  float value;
  memcpy(&value, at, sizeof value);
  return value;
}

/* The largest float that is not above `value`; of -0.0...01 that is the
 * denormal below 0. */
static float round_down(double value) {
  const float nearest = (float)value;
  if (!((double)nearest > value))
    return nearest;
  const uint32_t bits = float_bits(nearest);
  if (nearest == 0.0f)
    return bits_float(0x80000001u);
  return bits_float(nearest > 0.0f ? bits - 1 : bits + 1);
}

/* value * 2^exponent with one rounding, as ldexp, without its call where a
 * factor will do. */
static inline double scale_by(double value, int exponent) {
  if (exponent < -1022 || exponent > 1023)
    return ldexp(value, exponent);
  const uint64_t bits = (uint64_t)(1023 + exponent) << 52;
  double factor;
  memcpy(&factor, &bits, sizeof factor);
  return value * factor;
}

/* The exponent that frexp gives, for a finite value above 0. */
static inline int exponent_above(double value) {
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  int above = (int)(bits >> 52) - 1022;
  if (above == -1022)
    frexp(value, &above);
  return above;
}

/* value * 2^-exponent rounded down to float. A double that underflows keeps its
 * sign. */
static float scale_limit(double value, int exponent) {
  const double scaled = scale_by(value, -exponent);
  if (scaled == 0.0 && value < 0.0)
    return bits_float(0x80000001u);
  return round_down(scaled);
}

static void mark_missing(ray_chunk *chunk, uint32_t i) {
  for (int axis = 0; axis < 3; axis++) {
    chunk->origin[axis][i] = 0.0f;
    chunk->direction[axis][i] = axis == 2 ? 1.0f : 0.0f;
  }
  chunk->t_min[i] = 0.0f;
  chunk->t_max[i] = -1.0f;
  chunk->t_exponent[i] = 0;
}

void whittle_ray_load(const scene_frame *frame, const whittle_rays *rays, size_t ray,
                      ray_chunk *chunk, uint32_t i) {
  double direction[3], largest = 0.0;
  bool finite = true;
  for (int axis = 0; axis < 3; axis++) {
    const double from = read_value(&rays->origins, ray, axis) - frame->center[axis];
    chunk->origin[axis][i] = (float)scale_by(from, -frame->exponent);
    direction[axis] = read_value(&rays->directions, ray, axis);
    finite = finite && isfinite(chunk->origin[axis][i]) && isfinite(direction[axis]);
    largest = fabs(direction[axis]) > largest ? fabs(direction[axis]) : largest;
  }
  const double t_min = rays->t_min.data ? read_value(&rays->t_min, ray, 0) : 0.0;
  const double t_max = rays->t_max.data ? read_value(&rays->t_max, ray, 0) : INFINITY;
  if (!finite || largest == 0.0 || isnan(t_min) || isnan(t_max)) {
    mark_missing(chunk, i);
    return;
  }
  const int above = exponent_above(largest);
  for (int axis = 0; axis < 3; axis++)
    chunk->direction[axis][i] = (float)scale_by(direction[axis], 1 - above);
  chunk->t_exponent[i] = frame->exponent - (above - 1);
  chunk->t_min[i] = scale_limit(t_min, chunk->t_exponent[i]);
  chunk->t_max[i] = scale_limit(t_max, chunk->t_exponent[i]);
}

void whittle_rays_pad(ray_chunk *chunk) {
  for (uint32_t i = chunk->count; i & 15; i++)
    mark_missing(chunk, i);
}

void whittle_rays_load(const scene_frame *frame, const whittle_rays *rays, size_t first,
                       uint32_t count, ray_chunk *chunk) {
  chunk->count = count;
  for (uint32_t i = 0; i < count; i++)
    whittle_ray_load(frame, rays, first + i, chunk, i);
  whittle_rays_pad(chunk);
}
