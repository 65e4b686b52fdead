/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The caller's rays into a chunk, and what they hit out of it: a lane group at a time. */

/* Ordinary rays are floats in a range where every product below is exact: then the results are
 * those of whittle_ray_load. What lies outside is marked odd and loaded by that. */
#define ORDINARY_LEAST 0x1p-60f
#define ORDINARY_MOST 0x1p60f

/* The groups' odd lanes, as bits. */
typedef uint32_t odd_lanes[RAY_CHUNK / V_LANES];

static bool is_ordinary(const scene_frame *frame, const whittle_rays *rays) {
  const bool any_double = rays->origins.is_double || rays->directions.is_double ||
                          (rays->t_min.data && rays->t_min.is_double) ||
                          (rays->t_max.data && rays->t_max.is_double);
  return !any_double && frame->exponent >= -60 && frame->exponent <= 60;
}

/* A row of the caller's numbers: where it stands, if groups of lanes can be read there, or else
 * `room` with a copy. */
static const float *row_of(const whittle_array *array, size_t first, uint32_t count, int component,
                           float *room) {
  const char *at = (const char *)array->data + (ptrdiff_t)first * array->stride +
                   component * array->component_stride;
  if (array->stride == sizeof(float)) {
    if (count % V_LANES == 0)
      return (const float *)at;
    memcpy(room, at, count * sizeof(float));
    return room;
  }
  for (uint32_t i = 0; i < count; i++, at += array->stride)
    memcpy(&room[i], at, sizeof(float));
  return room;
}

static inline void fill_row(float *row, uint32_t count, float value) {
  for (uint32_t i = 0; i < count; i += V_LANES)
    v_store(row + i, v_set(value));
}

static inline float power_of_two(int exponent) {
  return bits_float((uint32_t)(127 + exponent) << 23);
}

static inline v_float powers_of_two(lane_bits exponents) {
  return (v_float)((exponents + 127) << 23);
}

static void load_one_origin(const scene_frame *frame, const whittle_rays *rays, uint32_t count,
                            ray_chunk *chunk, odd_lanes odd) {
  const double factor = power_of_two(-frame->exponent);
  float origin[3];
  bool fine = true;
  for (int axis = 0; axis < 3; axis++) {
    memcpy(&origin[axis], (const char *)rays->origins.data + axis * rays->origins.component_stride,
           sizeof(float));
    origin[axis] = (float)(((double)origin[axis] - frame->center[axis]) * factor);
    fine = fine && fabsf(origin[axis]) <= FLT_MAX;
  }
  for (uint32_t i = 0; i < count; i += V_LANES)
    for (int axis = 0; axis < 3; axis++)
      v_store(chunk->origin[axis] + i, v_set(origin[axis]));
  for (uint32_t g = 0; !fine && g * V_LANES < count; g++)
    odd[g] = UINT32_MAX;
}

/* (from - center) * factor, in double precision. */
static inline void rebase(const float *from, double center, double factor, float *to) {
  for (uint32_t i = 0; i < V_LANES; i += FOUR) {
    four_floats four;
    memcpy(&four, from + i, sizeof four);
    four = NARROWED((WIDENED(four) - center) * factor);
    memcpy(to + i, &four, sizeof four);
  }
}

static void load_origins(const scene_frame *frame, const whittle_rays *rays, size_t first,
                         uint32_t count, ray_chunk *chunk, odd_lanes odd) {
  const float factor = power_of_two(-frame->exponent);
  for (int axis = 0; axis < 3; axis++) {
    float *to = chunk->origin[axis];
    const float *from = row_of(&rays->origins, first, count, axis, to);
    const double center = frame->center[axis];
    for (uint32_t i = 0; i < count; i += V_LANES) {
      if (center == 0.0)
        v_store(to + i, v_load(from + i) * v_set(factor));
      else
        rebase(from + i, center, factor, to + i);
      odd[i / V_LANES] |= ~v_bits(v_le(v_abs(v_load(to + i)), v_set(FLT_MAX)));
    }
  }
}

static void load_directions(const scene_frame *frame, const whittle_rays *rays, size_t first,
                            uint32_t count, ray_chunk *chunk, odd_lanes odd) {
  const float *from[3];
  for (int axis = 0; axis < 3; axis++)
    from[axis] = row_of(&rays->directions, first, count, axis, chunk->direction[axis]);
  for (uint32_t i = 0; i < count; i += V_LANES) {
    for (int axis = 0; axis < 3; axis++)
      whittle_prefetch(from[axis] + i + RAY_CHUNK);
    const v_float x = v_load(from[0] + i), y = v_load(from[1] + i), z = v_load(from[2] + i);
    const v_float largest = v_max(v_max(v_abs(x), v_abs(y)), v_abs(z));
    const v_float sum = (v_abs(x) + v_abs(y)) + v_abs(z);
    const v_mask fine =
        v_and(v_le(v_set(ORDINARY_LEAST), largest), v_le(sum, v_set(ORDINARY_MOST)));
    const lane_bits above = (lane_bits)largest >> 23;
    const v_float factor = (v_float)((254 - above) << 23);
    const lane_bits exponent = (uint32_t)(frame->exponent + 127) - above;
    v_store(chunk->direction[0] + i, x * factor);
    v_store(chunk->direction[1] + i, y * factor);
    v_store(chunk->direction[2] + i, z * factor);
    memcpy(chunk->t_exponent + i, &exponent, sizeof exponent);
    odd[i / V_LANES] |= ~v_bits(fine);
  }
}

static inline lane_bits exponents_at(const ray_chunk *chunk, uint32_t i) {
  lane_bits exponents;
  memcpy(&exponents, chunk->t_exponent + i, sizeof exponents);
  return exponents;
}

/* One of the limits of t. A negative one is odd: rounding down matters to it. */
static void load_limits(const whittle_array *array, float missing, size_t first, uint32_t count,
                        const ray_chunk *chunk, float *limits, odd_lanes odd) {
  const bool one = !array->data || array->stride == 0;
  const float *from = limits;
  if (one) {
    if (array->data)
      memcpy(&missing, array->data, sizeof missing);
    fill_row(limits, count, missing);
    if (missing == 0.0f || missing == INFINITY)
      return;
  } else {
    from = row_of(array, first, count, 0, limits);
  }
  for (uint32_t i = 0; i < count; i += V_LANES) {
    const v_float limit = v_load(from + i), scaled = limit * powers_of_two(-exponents_at(chunk, i));
    const v_mask end = v_or(v_eq(limit, v_set(0.0f)), v_eq(limit, v_set(INFINITY)));
    const v_mask normal = v_and(v_le(v_set(FLT_MIN), scaled), v_le(scaled, v_set(FLT_MAX)));
    v_store(limits + i, scaled);
    odd[i / V_LANES] |= ~v_bits(v_or(end, normal));
  }
}

static void kernel_load(const scene_frame *frame, const whittle_rays *rays, size_t first,
                        uint32_t count, ray_chunk *chunk) {
  odd_lanes odd = {0};
  uint32_t any = 0;
  chunk->count = count;
  chunk->one_origin = false;
  if (!is_ordinary(frame, rays)) {
    whittle_rays_load(frame, rays, first, count, chunk);
    return;
  }
  chunk->one_origin = rays->origins.stride == 0;
  if (chunk->one_origin)
    load_one_origin(frame, rays, count, chunk, odd);
  else
    load_origins(frame, rays, first, count, chunk, odd);
  load_directions(frame, rays, first, count, chunk, odd);
  load_limits(&rays->t_min, 0.0f, first, count, chunk, chunk->t_min, odd);
  load_limits(&rays->t_max, INFINITY, first, count, chunk, chunk->t_max, odd);
  for (uint32_t g = 0; g * V_LANES < count; g++)
    any |= odd[g] & (uint32_t)((1ull << V_LANES) - 1);
  for (uint32_t i = 0; any && i < count; i++)
    if (odd[i / V_LANES] >> i % V_LANES & 1) {
      whittle_ray_load(frame, rays, first + i, chunk, i);
      chunk->one_origin = false; /* what cannot hit stands elsewhere */
    }
  whittle_rays_pad(chunk);
}

/* ---- Hits ------------------------------------------------------------------------------------ */

/* Rows for the lanes of a group that is not full. */
typedef struct given_lanes {
  float t[V_LANES], u[V_LANES], v[V_LANES];
  int32_t instance[V_LANES], triangle[V_LANES];
} given_lanes;

static inline void copy_row(void *to, const void *from, uint32_t count) {
  if (to)
    memcpy(to, from, count * sizeof(uint32_t));
}

/* Whether the powers of two of a chunk's distances are floats, and do not overflow the sum here. */
static bool has_plain_exponents(const ray_chunk *chunk) {
  lane_bits all = {0};
  for (uint32_t i = 0; i < chunk->count; i += V_LANES)
    all |= exponents_at(chunk, i) + 64;
  return lane_bits_any(all) < 128;
}

/* whittle_rays_t of a group. */
static inline v_float give_distances(const ray_chunk *chunk, uint32_t i, bool plain) {
  if (plain)
    return v_min(v_load(chunk->t_max + i) * powers_of_two(exponents_at(chunk, i)), v_set(FLT_MAX));
  float each[V_LANES];
  for (uint32_t lane = 0; lane < V_LANES; lane++)
    each[lane] = whittle_rays_t(chunk, i + lane, chunk->t_max[i + lane]);
  return v_load(each);
}

/* Ray i and its neighbours, to entry `at` of the arrays that there are. */
static inline __attribute__((always_inline)) void
give_group(const uint32_t *ids, const ray_chunk *chunk, const ray_stream *rays, uint32_t i,
           bool plain, const whittle_hits *to, size_t at) {
  const v_uint record = v_loadu(rays->record + i), none = v_setu(WHITTLE_NONE);
  const v_mask missed = v_equ(record, none);
  const v_float nothing = v_set(0.0f);
  if (to->t)
    v_store(to->t + at, v_select(missed, v_set(INFINITY), give_distances(chunk, i, plain)));
  if (to->u)
    v_store(to->u + at, v_select(missed, nothing, v_load(rays->u + i)));
  if (to->v)
    v_store(to->v + at, v_select(missed, nothing, v_load(rays->v + i)));
  if (to->instance)
    v_storeu((uint32_t *)to->instance + at, v_pick(missed, none, ids, 2, record));
  if (to->triangle)
    v_storeu((uint32_t *)to->triangle + at, v_pick(missed, none, ids + 1, 2, record));
}

static void kernel_give(const whittle_scene *scene, const ray_chunk *chunk, const ray_stream *rays,
                        const whittle_hits *hits, size_t first) {
  const uint32_t last = chunk->count % V_LANES, full = chunk->count - last;
  const uint32_t *ids = (const uint32_t *)scene->triangles.ids;
  const ray_stream from = *rays; /* copies, which what is stored cannot change */
  const whittle_hits to = *hits;
  if (has_plain_exponents(chunk))
    for (uint32_t i = 0; i < full; i += V_LANES)
      give_group(ids, chunk, &from, i, true, &to, first + i);
  else
    for (uint32_t i = 0; i < full; i += V_LANES)
      give_group(ids, chunk, &from, i, false, &to, first + i);
  if (last == 0)
    return;
  given_lanes l;
  const whittle_hits row = {
      .t = l.t, .u = l.u, .v = l.v, .instance = l.instance, .triangle = l.triangle};
  const size_t at = first + full;
  for (uint32_t i = chunk->count; i % V_LANES != 0; i++)
    from.record[i] = WHITTLE_NONE;
  give_group(ids, chunk, &from, full, false, &row, 0);
  copy_row(to.t ? to.t + at : NULL, l.t, last);
  copy_row(to.u ? to.u + at : NULL, l.u, last);
  copy_row(to.v ? to.v + at : NULL, l.v, last);
  copy_row(to.instance ? to.instance + at : NULL, l.instance, last);
  copy_row(to.triangle ? to.triangle + at : NULL, l.triangle, last);
}

static void kernel_give_blocked(const ray_stream *rays, uint8_t *blocked) {
  const v_uint none = v_setu(WHITTLE_NONE);
  const uint32_t full = rays->count - rays->count % V_LANES;
  for (uint32_t i = 0; i < full; i += V_LANES)
    v_store_bytes(blocked + i,
                  v_select(v_equ(v_loadu(rays->record + i), none), v_set(0.0f), v_set(1.0f)));
  for (uint32_t i = full; i < rays->count; i++)
    blocked[i] = rays->record[i] != WHITTLE_NONE;
}
