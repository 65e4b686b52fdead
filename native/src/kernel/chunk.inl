/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The caller's rays into a chunk, and what they hit out of it: plain loops over one array each. */

/* Ordinary rays are floats in a range where every product below is exact: then the results are
 * those of whittle_ray_load. What lies outside is marked odd and loaded by that. */
#define ORDINARY_LEAST 0x1p-60f
#define ORDINARY_MOST 0x1p60f

static bool is_ordinary(const scene_frame *frame, const whittle_rays *rays) {
  const bool any_double = rays->origins.is_double || rays->directions.is_double ||
                          (rays->t_min.data && rays->t_min.is_double) ||
                          (rays->t_max.data && rays->t_max.is_double);
  return !any_double && frame->exponent >= -60 && frame->exponent <= 60;
}

static void gather(const whittle_array *array, size_t first, uint32_t count, int component,
                   float *restrict to) {
  const char *at = (const char *)array->data + (ptrdiff_t)first * array->stride +
                   component * array->component_stride;
  if (array->stride == sizeof(float)) {
    memcpy(to, at, count * sizeof(float));
    return;
  }
  for (uint32_t i = 0; i < count; i++, at += array->stride)
    memcpy(&to[i], at, sizeof(float));
}

static void load_origins(const scene_frame *frame, const whittle_rays *rays, size_t first,
                         uint32_t count, ray_chunk *chunk, uint32_t *restrict odd) {
  const double factor = (double)bits_float((uint32_t)(127 - frame->exponent) << 23);
  const bool one = rays->origins.stride == 0;
  for (int axis = 0; axis < 3; axis++) {
    float *restrict origin = chunk->origin[axis];
    const double center = frame->center[axis];
    gather(&rays->origins, first, one ? 1 : count, axis, origin);
    for (uint32_t i = 0; i < (one ? 1 : count); i++)
      origin[i] = (float)(((double)origin[i] - center) * factor);
    if (one) {
      for (uint32_t i = 1; i < count; i++)
        origin[i] = origin[0];
      if (fabsf(origin[0]) <= FLT_MAX)
        continue;
    }
    for (uint32_t i = 0; i < count; i++)
      odd[i] |= fabsf(origin[i]) <= FLT_MAX ? 0u : 1u;
  }
}

static void load_directions(const scene_frame *frame, const whittle_rays *rays, size_t first,
                            uint32_t count, ray_chunk *chunk, uint32_t *restrict odd) {
  for (int axis = 0; axis < 3; axis++)
    gather(&rays->directions, first, count, axis, chunk->direction[axis]);
  float *restrict dx = chunk->direction[0], *restrict dy = chunk->direction[1];
  float *restrict dz = chunk->direction[2];
  int32_t *restrict exponents = chunk->t_exponent;
  for (uint32_t i = 0; i < count; i++) {
    const float x = fabsf(dx[i]), y = fabsf(dy[i]), z = fabsf(dz[i]);
    const float xy = x > y ? x : y, largest = xy > z ? xy : z;
    const uint32_t fine = (x <= largest) & (y <= largest) & (z <= largest) &
                          (largest >= ORDINARY_LEAST) & (largest <= ORDINARY_MOST);
    odd[i] |= fine ^ 1u;
    const uint32_t above = float_bits(largest) & 0x7f800000u;
    const float factor = bits_float(0x7f000000u - above);
    dx[i] *= factor, dy[i] *= factor, dz[i] *= factor;
    exponents[i] = frame->exponent + 127 - (int32_t)(above >> 23);
  }
}

/* One of the limits of t. A negative one is odd: rounding down matters to it. */
static void load_limits(const whittle_array *array, float missing, size_t first, uint32_t count,
                        const ray_chunk *chunk, float *restrict limits, uint32_t *restrict odd) {
  const bool one = !array->data || array->stride == 0;
  float given = missing;
  if (one && array->data)
    memcpy(&given, array->data, sizeof given);
  if (one)
    for (uint32_t i = 0; i < count; i++)
      limits[i] = given;
  if (one && (given == 0.0f || given == INFINITY))
    return;
  if (!one)
    gather(array, first, count, 0, limits);
  const int32_t *restrict exponents = chunk->t_exponent;
  for (uint32_t i = 0; i < count; i++) {
    const float limit = limits[i];
    const float scaled = limit * bits_float((uint32_t)(127 - exponents[i]) << 23);
    const uint32_t fine =
        (limit == 0.0f) | (limit == INFINITY) | ((scaled >= FLT_MIN) & (scaled <= FLT_MAX));
    limits[i] = scaled;
    odd[i] |= fine ^ 1u;
  }
}

static void kernel_load(const scene_frame *frame, const whittle_rays *rays, size_t first,
                        uint32_t count, ray_chunk *chunk) {
  uint32_t odd[RAY_CHUNK] = {0}, any = 0;
  chunk->count = count;
  if (!is_ordinary(frame, rays)) {
    whittle_rays_load(frame, rays, first, count, chunk);
    return;
  }
  load_origins(frame, rays, first, count, chunk, odd);
  load_directions(frame, rays, first, count, chunk, odd);
  load_limits(&rays->t_min, 0.0f, first, count, chunk, chunk->t_min, odd);
  load_limits(&rays->t_max, INFINITY, first, count, chunk, chunk->t_max, odd);
  for (uint32_t i = 0; i < count; i++)
    any |= odd[i];
  for (uint32_t i = 0; any && i < count; i++)
    if (odd[i])
      whittle_ray_load(frame, rays, first + i, chunk, i);
  whittle_rays_pad(chunk);
}

/* ---- Hits ------------------------------------------------------------------------------------ */

static void give_misses(const whittle_hits *hits, size_t first, uint32_t count) {
  for (uint32_t i = 0; hits->t && i < count; i++)
    hits->t[first + i] = INFINITY;
  if (hits->u)
    memset(hits->u + first, 0, count * sizeof(float));
  if (hits->v)
    memset(hits->v + first, 0, count * sizeof(float));
  if (hits->instance)
    memset(hits->instance + first, 0xff, count * sizeof(int32_t));
  if (hits->triangle)
    memset(hits->triangle + first, 0xff, count * sizeof(int32_t));
}

/* whittle_rays_t where the power of two is a float. */
static void give_distances(const ray_chunk *chunk, const uint32_t *restrict record,
                           float *restrict out) {
  const int32_t *restrict exponents = chunk->t_exponent;
  const float *restrict t = chunk->t_max;
  uint32_t odd = 0;
  for (uint32_t i = 0; i < chunk->count; i++)
    odd |= (exponents[i] < -126) | (exponents[i] > 127);
  for (uint32_t i = 0; i < chunk->count; i++) {
    const float scaled = t[i] * bits_float((uint32_t)(127 + exponents[i]) << 23);
    const float finite = scaled <= FLT_MAX ? scaled : FLT_MAX;
    out[i] = record[i] != WHITTLE_NONE ? finite : INFINITY;
  }
  for (uint32_t i = 0; odd && i < chunk->count; i++)
    out[i] = record[i] != WHITTLE_NONE ? whittle_rays_t(chunk, i, t[i]) : INFINITY;
}

static void give_weights(const uint32_t *restrict record, const float *restrict weight,
                         uint32_t count, float *restrict out) {
  for (uint32_t i = 0; i < count; i++)
    out[i] = record[i] != WHITTLE_NONE ? weight[i] : 0.0f;
}

static void kernel_give(const whittle_scene *scene, const ray_chunk *chunk, const ray_stream *rays,
                        const whittle_hits *hits, size_t first) {
  const triangle_id *ids = scene->triangles.ids;
  const uint32_t *record = rays->record, count = chunk->count;
  uint32_t missed = WHITTLE_NONE;
  for (uint32_t i = 0; i < count; i++)
    missed &= record[i];
  if (missed == WHITTLE_NONE) {
    give_misses(hits, first, count);
    return;
  }
  if (hits->t)
    give_distances(chunk, record, hits->t + first);
  if (hits->u)
    give_weights(record, rays->u, count, hits->u + first);
  if (hits->v)
    give_weights(record, rays->v, count, hits->v + first);
  for (uint32_t i = 0; hits->instance && i < count; i++)
    hits->instance[first + i] = record[i] != WHITTLE_NONE ? (int32_t)ids[record[i]].instance : -1;
  for (uint32_t i = 0; hits->triangle && i < count; i++)
    hits->triangle[first + i] = record[i] != WHITTLE_NONE ? (int32_t)ids[record[i]].triangle : -1;
}
