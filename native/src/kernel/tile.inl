/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* A tile from camera rays to pixels: generations of rays, traced and shaded one after the other. */

/* No recursion: each generation is a stream of reflected and one of refracted rays. What a pixel
 * adds up, and in which order, depends on its own rays alone, never on tiles or packets. */

typedef bool shade_function(const tile_context *, tile_worker *, uint32_t, uint32_t, v_mask,
                            ray_batch *, ray_batch *);

/* The specialised variants: mirror 1, glass 2, highlight 4. */
#define VARIANT(n)                                                                                 \
  static bool shade_##n(const tile_context *context, tile_worker *w, uint32_t at, uint32_t count,  \
                        v_mask outside, ray_batch *reflection, ray_batch *refraction) {            \
    return shade_group(context, w, at, count, outside, reflection, refraction,                     \
                       ((n) & 3) | ((n) & 4 ? WHITTLE_NEED_HIGHLIGHT : 0));                        \
  }
/* clang-format off */
VARIANT(0) VARIANT(1) VARIANT(2) VARIANT(3) VARIANT(4) VARIANT(5) VARIANT(6) VARIANT(7)
    /* clang-format on */
    static shade_function *const shade_variants[8] = {shade_0, shade_1, shade_2, shade_3,
                                                      shade_4, shade_5, shade_6, shade_7};

static inline uint32_t variant_of(uint32_t needs) {
  return (needs & (WHITTLE_NEED_MIRROR | WHITTLE_NEED_GLASS)) |
         (needs & WHITTLE_NEED_HIGHLIGHT ? 4 : 0);
}

/* Where sample `s` of each pixel lies: in the middle of its cell, or at a hashed point of it. */
static void sample_points(const tile_context *context, tile_worker *w, uint32_t s) {
  const float grid = (float)context->grid;
  const float column = (float)(s % context->grid), row = (float)(s / context->grid);
  if (context->settings.pattern == WHITTLE_REGULAR) {
    const float dx = (column + 0.5f) / grid, dy = (row + 0.5f) / grid;
    for (uint32_t i = 0; i < w->slots; i++) {
      w->sample_x[i] = (float)w->pixel_x[i] + dx;
      w->sample_y[i] = (float)w->pixel_y[i] + dy;
    }
    return;
  }
  for (uint32_t i = 0; i < w->slots; i++) {
    const uint32_t x = w->pixel_x[i], y = w->pixel_y[i];
    const uint32_t hash = whittle_hash(x, y, s, context->settings.seed);
    const float dx = (float)(hash >> 16) * 0x1p-16f + 0x1p-17f;
    const float dy = (float)(hash & 0xffff) * 0x1p-16f + 0x1p-17f;
    w->sample_x[i] = (float)x + (column + dx) / grid;
    w->sample_y[i] = (float)y + (row + dy) / grid;
  }
}

/* The pixels of a tile in Z order, so that consecutive rays form squares at every size. */
static void tile_pixels(const tile_context *context, tile_worker *w, uint32_t tile) {
  const uint32_t edge = context->tile_edge;
  const uint32_t x0 = context->region[0] + tile % context->tiles_x * edge;
  const uint32_t y0 = context->region[1] + tile / context->tiles_x * edge;
  w->slots = 0;
  for (uint32_t i = 0; i < edge * edge; i++) {
    uint32_t dx = 0, dy = 0;
    for (uint32_t bit = 0; 1u << bit < edge; bit++) {
      dx |= (i >> (2 * bit) & 1) << bit;
      dy |= (i >> (2 * bit + 1) & 1) << bit;
    }
    if (x0 + dx >= context->region[2] || y0 + dy >= context->region[3])
      continue;
    w->pixel_x[w->slots] = x0 + dx;
    w->pixel_y[w->slots++] = y0 + dy;
  }
}

/* base + x dx + y dy on one axis, for every slot. */
static void affine(float *out, const tile_worker *w, float base, float dx, float dy) {
  for (uint32_t i = 0; i < w->slots; i += V_LANES) {
    const v_float x = v_load(w->sample_x + i), y = v_load(w->sample_y + i);
    v_store(out + i, (v_set(base) + x * v_set(dx)) + y * v_set(dy));
  }
}

static bool primary_rays(const tile_context *context, tile_worker *w, uint32_t sample) {
  const camera_rays *camera = &context->camera;
  ray_batch *batch = &w->primary;
  if (!ray_batch_reserve(batch, w->slots))
    return false;
  sample_points(context, w, sample);
  for (int axis = 0; axis < 3; axis++) {
    affine(batch->rays.origin[axis], w, camera->origin[axis], camera->origin_x[axis],
           camera->origin_y[axis]);
    affine(batch->rays.direction[axis], w, camera->direction[axis], camera->direction_x[axis],
           camera->direction_y[axis]);
  }
  for (uint32_t i = 0; i < w->slots; i++) {
    for (int axis = 0; axis < 3; axis++)
      batch->weight[axis][i] = 1.0f;
    batch->rays.t_min[i] = camera->t_min;
    batch->rays.t[i] = camera->t_max;
    batch->rays.skip[i] = WHITTLE_NONE;
    batch->slot[i] = i;
  }
  batch->rays.count = w->slots;
  return true;
}

/* Writes what the passes show of primary hit `i` of the surfaces. */
static void write_hit(const tile_context *context, const tile_worker *w, uint32_t i, float t) {
  const whittle_scene *scene = context->scene;
  const surface_batch *s = &w->surfaces;
  float *const *pass = context->image->pass;
  const uint32_t x = w->pixel_x[s->slot[i]], y = w->pixel_y[s->slot[i]];
  if (pass[WHITTLE_PASS_DEPTH])
    *pixel_of(context, WHITTLE_PASS_DEPTH, x, y, 1) = (float)((double)t * context->depth_scale);
  if (pass[WHITTLE_PASS_OBJECT_INDEX])
    *pixel_of(context, WHITTLE_PASS_OBJECT_INDEX, x, y, 1) =
        (float)scene->instances[scene->triangles.ids[s->record[i]].instance].object_id;
  for (int k = 0; k < 3; k++) {
    if (pass[WHITTLE_PASS_POSITION])
      pixel_of(context, WHITTLE_PASS_POSITION, x, y, 3)[k] =
          (float)((double)s->point[k][i] * context->depth_scale + scene->frame.center[k]);
    if (pass[WHITTLE_PASS_NORMAL])
      pixel_of(context, WHITTLE_PASS_NORMAL, x, y, 3)[k] = s->normal[k][i];
  }
}

/* What the passes show where nothing is hit. */
static void write_miss(const tile_context *context, const tile_worker *w, uint32_t slot) {
  static const float nothing[WHITTLE_PASS_NODES] = {[WHITTLE_PASS_DEPTH] = 1e10f};
  for (whittle_pass pass = WHITTLE_PASS_DEPTH; pass < WHITTLE_PASS_NODES; pass++)
    for (uint32_t k = 0; context->image->pass[pass] && k < whittle_pass_channels(pass); k++)
      pixel_of(context, pass, w->pixel_x[slot], w->pixel_y[slot], whittle_pass_channels(pass))[k] =
          nothing[pass];
}

static void shade_miss(const tile_context *context, tile_worker *w, const ray_batch *batch,
                       uint32_t i, bool primary, bool geometry) {
  const uint32_t slot = batch->slot[i];
  const bool seen = !(primary && context->settings.transparent);
  for (int channel = 0; channel < 3 && seen; channel++)
    w->sample[channel][slot] += context->scene->world.color[channel] * batch->weight[channel][i];
  if (!seen)
    w->sample[3][slot] = 0.0f;
  if (geometry)
    write_miss(context, w, slot);
}

/* Shades misses, and lists the hits of a batch as surfaces. */
static void sort_hits(const tile_context *context, tile_worker *w, const ray_batch *batch,
                      bool primary, bool geometry) {
  surface_batch *s = &w->surfaces;
  for (uint32_t i = 0; i < batch->rays.count; i++) {
    if (batch->rays.record[i] == WHITTLE_NONE) {
      shade_miss(context, w, batch, i, primary, geometry);
      continue;
    }
    const uint32_t n = s->count++;
    s->ray[n] = i;
    s->slot[n] = batch->slot[i];
    s->record[n] = batch->rays.record[i];
    for (int channel = 0; channel < 3; channel++)
      s->weight[channel][n] = batch->weight[channel][i];
  }
}

/* Shades a batch; for the sample in the middle of primary rays (`geometry`) also writes the
 * geometry passes. */
static bool shade_batch(const tile_context *context, tile_worker *w, ray_batch *batch,
                        ray_batch *reflection, ray_batch *refraction, bool primary, bool geometry) {
  const bool smooth = context->needs & WHITTLE_NEED_SMOOTH;
  shade_function *shade = shade_variants[variant_of(context->needs)];
  surface_batch *s = &w->surfaces;
  if (!surface_batch_reserve(s, batch->rays.count))
    return false;
  sort_hits(context, w, batch, primary, geometry);
  for (uint32_t at = 0; at < s->count; at += V_LANES) {
    const uint32_t count = s->count - at < V_LANES ? s->count - at : V_LANES;
    const v_mask outside =
        load_surfaces(context->scene, &batch->rays, s->ray + at, count, smooth, s, at);
    for (uint32_t i = at; geometry && i < at + count; i++)
      write_hit(context, w, i, batch->rays.t[s->ray[i]]);
    if (!shade(context, w, at, count, outside, reflection, refraction))
      return false;
  }
  return true;
}

/* Asks every surface of the last shaded batch about one light. */
static bool light_batch(const tile_context *context, tile_worker *w, const light_record *l) {
  const surface_batch *s = &w->surfaces;
  ray_batch *batch = &w->shadow;
  batch->rays.count = 0;
  /* What touches the light itself, to rounding, does not shadow it. */
  const float t_max = l->kind == WHITTLE_POINT ? 1.0f - 0x1p-20f : __builtin_inff();
  for (uint32_t at = 0; at < s->count; at += V_LANES) {
    const uint32_t count = s->count - at < V_LANES ? s->count - at : V_LANES;
    const v_vector origin = surface_origins(s, at, 1.0f);
    v_vector light, to_light;
    const uint32_t arrives = light_arrives(context, s, at, l, origin, &light, &to_light) &
                             (uint32_t)((1ull << count) - 1);
    w->stats.shadow_rays_left_out += count - (uint32_t)__builtin_popcount(arrives);
    if (!l->shadow)
      add_light(w, s->slot + at, arrives, light);
    else if (!append_rays(batch, arrives, s, at, origin, to_light, light, t_max))
      return false;
  }
  if (batch->rays.count == 0)
    return true;
  if (!trace_batch(context, w, batch, WHITTLE_RAY_SHADOW))
    return false;
  for (uint32_t i = 0; i < batch->rays.count; i++)
    if (batch->rays.record[i] == WHITTLE_NONE)
      for (int channel = 0; channel < 3; channel++)
        w->sample[channel][batch->slot[i]] += batch->weight[channel][i];
  return true;
}

/* Traces and shades one batch, then its shadows; what it sends on goes to the next generation. */
static bool run_batch(const tile_context *context, tile_worker *w, ray_batch *batch, uint32_t kind,
                      uint32_t depth, bool geometry) {
  if (batch->rays.count == 0)
    return true;
  ray_batch *next = w->secondary[(depth + 1) % 2];
  const bool deeper = depth < context->settings.max_depth;
  w->depth = depth;
  w->surfaces.first_ray = context->log ? (uint32_t)context->log->count : 0;
  if (!trace_batch(context, w, batch, kind) ||
      !shade_batch(context, w, batch, deeper ? &next[0] : NULL, deeper ? &next[1] : NULL,
                   kind == WHITTLE_RAY_PRIMARY, geometry))
    return false;
  batch->rays.count = 0;
  for (w->light = 0; w->light < context->light_count; w->light++)
    if (!light_batch(context, w, &context->lights[w->light]))
      return false;
  return true;
}

/* All generations of one sample of every pixel of the tile. */
static bool run_sample(const tile_context *context, tile_worker *w, uint32_t sample) {
  const uint32_t grid = context->grid;
  const bool geometry = sample == grid / 2 * grid + grid / 2;
  w->sample_number = sample;
  for (uint32_t slot = 0; slot < w->slots; slot++) {
    w->sample[0][slot] = w->sample[1][slot] = w->sample[2][slot] = 0.0f;
    w->sample[3][slot] = 1.0f;
  }
  if (!primary_rays(context, w, sample) ||
      !run_batch(context, w, &w->primary, WHITTLE_RAY_PRIMARY, 0, geometry))
    return false;
  for (uint32_t depth = 1; depth <= context->settings.max_depth; depth++) {
    ray_batch *now = w->secondary[depth % 2];
    if (now[0].rays.count + now[1].rays.count == 0)
      break;
    if (atomic_load_explicit(context->cancelled, memory_order_relaxed))
      return true;
    if (!run_batch(context, w, &now[0], WHITTLE_RAY_REFLECTION, depth, false) ||
        !run_batch(context, w, &now[1], WHITTLE_RAY_REFRACTION, depth, false))
      return false;
  }
  for (int channel = 0; channel < 4; channel++)
    for (uint32_t slot = 0; slot < w->slots; slot++)
      w->sum[channel][slot] += w->sample[channel][slot];
  return true;
}

static void write_tile(const tile_context *context, tile_worker *w) {
  const float share = 1.0f / (float)context->settings.samples;
  for (uint32_t slot = 0; slot < w->slots; slot++) {
    if (context->image->pass[WHITTLE_PASS_COMBINED]) {
      float *pixel =
          pixel_of(context, WHITTLE_PASS_COMBINED, w->pixel_x[slot], w->pixel_y[slot], 4);
      for (int channel = 0; channel < 4; channel++)
        pixel[channel] = w->sum[channel][slot] * share;
    }
    if (context->count)
      write_counters(context, w, slot);
    if (context->coherence)
      write_coherence(context, w, slot);
  }
}

static bool kernel_render_tile(const tile_context *context, tile_worker *w, uint32_t tile) {
  const double start = whittle_seconds();
  tile_pixels(context, w, tile);
  memset(w->sum, 0, sizeof w->sum);
  if (context->count) {
    memset(w->nodes, 0, sizeof w->nodes);
    memset(w->triangles, 0, sizeof w->triangles);
    memset(w->leaf_depth, 0, sizeof w->leaf_depth);
  }
  if (context->coherence)
    memset(w->shares, 0, sizeof w->shares);
  for (int even = 0; even < 2; even++)
    w->secondary[even][0].rays.count = w->secondary[even][1].rays.count = 0;
  for (uint32_t sample = 0; sample < context->settings.samples; sample++) {
    if (atomic_load_explicit(context->cancelled, memory_order_relaxed))
      return true;
    if (!run_sample(context, w, sample))
      return false;
  }
  write_tile(context, w);
  const double seconds = whittle_seconds() - start;
  if (context->image->pass[WHITTLE_PASS_SECONDS])
    write_seconds(context, w, seconds);
  w->stats.seconds_shade += seconds;
  return true;
}
