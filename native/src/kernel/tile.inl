/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* A tile from camera rays to pixels: generations of rays, traced and shaded one after the other. */

/* No recursion: each generation is a stream of reflected and one of refracted rays. What a pixel
 * adds up, and in which order, depends on its own rays alone, never on tiles or packets. */

typedef bool shade_function(const tile_context *, tile_worker *, surface *, bool, ray_batch *,
                            ray_batch *);

#define SHADE_NEEDS                                                                                \
  (WHITTLE_NEED_MIRROR | WHITTLE_NEED_GLASS | WHITTLE_NEED_SMOOTH | WHITTLE_NEED_HIGHLIGHT)

/* The specialised variants: mirror 1, glass 2, smooth 4, highlight 8. */
#define VARIANT(n)                                                                                 \
  static bool shade_##n(const tile_context *context, tile_worker *w, surface *s, bool outside,     \
                        ray_batch *reflection, ray_batch *refraction) {                            \
    return shade_hit(context, w, s, outside, reflection, refraction,                               \
                     ((n) & 7) | ((n) & 8 ? WHITTLE_NEED_HIGHLIGHT : 0));                          \
  }
VARIANT(0) VARIANT(1) VARIANT(2) VARIANT(3) VARIANT(4) VARIANT(5) VARIANT(6) VARIANT(7)
VARIANT(8) VARIANT(9) VARIANT(10) VARIANT(11) VARIANT(12) VARIANT(13) VARIANT(14) VARIANT(15)
static shade_function *const shade_variants[16] = {
    shade_0, shade_1, shade_2,  shade_3,  shade_4,  shade_5,  shade_6,  shade_7,
    shade_8, shade_9, shade_10, shade_11, shade_12, shade_13, shade_14, shade_15};

static inline uint32_t variant_of(uint32_t needs) {
  return (needs & 7) | (needs & WHITTLE_NEED_HIGHLIGHT ? 8 : 0);
}

/* Where in a pixel sample `s` lies: the middle of its cell, or a hashed point of it. */
static inline void sample_point(const tile_context *context, uint32_t x, uint32_t y, uint32_t s,
                                float *px, float *py) {
  const uint32_t grid = context->grid;
  float dx = 0.5f, dy = 0.5f;
  if (context->settings.pattern == WHITTLE_STRATIFIED) {
    const uint32_t hash = whittle_hash(x, y, s, context->settings.seed);
    dx = (float)(hash >> 16) * 0x1p-16f + 0x1p-17f;
    dy = (float)(hash & 0xffff) * 0x1p-16f + 0x1p-17f;
  }
  *px = (float)x + ((float)(s % grid) + dx) / (float)grid;
  *py = (float)y + ((float)(s / grid) + dy) / (float)grid;
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

static bool primary_rays(const tile_context *context, tile_worker *w, uint32_t sample) {
  const camera_rays *camera = &context->camera;
  ray_batch *batch = &w->primary;
  if (!ray_batch_reserve(batch, w->slots))
    return false;
  for (uint32_t i = 0; i < w->slots; i++) {
    float x, y;
    sample_point(context, w->pixel_x[i], w->pixel_y[i], sample, &x, &y);
    for (int axis = 0; axis < 3; axis++) {
      batch->rays.origin[axis][i] =
          (camera->origin[axis] + x * camera->origin_x[axis]) + y * camera->origin_y[axis];
      batch->rays.direction[axis][i] =
          (camera->direction[axis] + x * camera->direction_x[axis]) + y * camera->direction_y[axis];
      batch->weight[axis][i] = 1.0f;
    }
    batch->rays.t_min[i] = camera->t_min;
    batch->rays.t[i] = camera->t_max;
    batch->rays.skip[i] = WHITTLE_NONE;
    batch->slot[i] = i;
  }
  batch->rays.count = w->slots;
  return true;
}

static void trace_batch(const tile_context *context, tile_worker *w, ray_batch *batch,
                        uint32_t kind) {
  static const uint32_t sees_bit[WHITTLE_RAY_KINDS] = {WHITTLE_CAMERA, WHITTLE_SHADOW,
                                                       WHITTLE_REFLECTION, WHITTLE_REFRACTION};
  const trace_context trace = {.scene = context->scene,
                               .mode = context->settings.mode,
                               .packet = context->packets[kind],
                               .visibility = sees_bit[kind],
                               .masked = context->needs & WHITTLE_NEED_VISIBILITY,
                               .count = context->count,
                               .packets = &w->packet_counters,
                               .own_box_misses = &w->stats.own_box_misses};
  const double start = whittle_seconds();
  trace_stream(&trace, &batch->rays, kind == WHITTLE_RAY_SHADOW);
  const double seconds = whittle_seconds() - start;
  w->stats.rays[kind] += batch->rays.count;
  double *spent[WHITTLE_RAY_KINDS] = {&w->stats.seconds_primary, &w->stats.seconds_shadow,
                                      &w->stats.seconds_secondary, &w->stats.seconds_secondary};
  *spent[kind] += seconds;
  w->stats.seconds_shade -= seconds;
  if (!context->count)
    return;
  for (uint32_t i = 0; i < batch->rays.count; i++) {
    w->nodes[kind][batch->slot[i]] += batch->rays.nodes[i];
    w->triangles[kind][batch->slot[i]] += batch->rays.triangles[i];
  }
}

static inline float *pixel_of(const tile_context *context, whittle_pass pass, uint32_t x,
                              uint32_t y, uint32_t channels) {
  const uint32_t *region = context->region;
  const size_t at = (size_t)(y - region[1]) * (region[2] - region[0]) + (x - region[0]);
  return context->image->pass[pass] + at * channels;
}

/* Writes what the passes show of a primary hit, or of nothing (s NULL). */
static void write_geometry(const tile_context *context, const tile_worker *w, uint32_t slot,
                           const surface *s, float t) {
  const whittle_scene *scene = context->scene;
  float *const *pass = context->image->pass;
  const uint32_t x = w->pixel_x[slot], y = w->pixel_y[slot];
  if (pass[WHITTLE_PASS_DEPTH])
    *pixel_of(context, WHITTLE_PASS_DEPTH, x, y, 1) =
        s ? (float)((double)t * context->depth_scale) : 1e10f;
  if (pass[WHITTLE_PASS_OBJECT_INDEX])
    *pixel_of(context, WHITTLE_PASS_OBJECT_INDEX, x, y, 1) =
        s ? (float)scene->instances[scene->triangles[s->record].instance].object_id : 0.0f;
  for (int i = 0; i < 3; i++) {
    if (pass[WHITTLE_PASS_POSITION])
      pixel_of(context, WHITTLE_PASS_POSITION, x, y, 3)[i] =
          s ? (float)((double)s->point[i] * context->depth_scale + scene->frame.center[i]) : 0.0f;
    if (pass[WHITTLE_PASS_NORMAL])
      pixel_of(context, WHITTLE_PASS_NORMAL, x, y, 3)[i] = s ? s->normal[i] : 0.0f;
  }
}

static bool surfaces_reserve(tile_worker *w, uint32_t count) {
  w->surface_count = 0;
  if (count <= w->surface_capacity)
    return true;
  surface *surfaces = whittle_allocate(count, sizeof *surfaces);
  if (surfaces == NULL)
    return false;
  whittle_release(w->surfaces);
  w->surfaces = surfaces;
  w->surface_capacity = count;
  return true;
}

/* Shades the hits of a batch; primary rays (`geometry`) also write the geometry passes. */
static bool shade_batch(const tile_context *context, tile_worker *w, ray_batch *batch,
                        ray_batch *reflection, ray_batch *refraction, bool primary, bool geometry) {
  const whittle_scene *scene = context->scene;
  const bool smooth = context->needs & WHITTLE_NEED_SMOOTH;
  shade_function *shade = shade_variants[variant_of(context->needs)];
  if (!surfaces_reserve(w, batch->rays.count))
    return false;
  for (uint32_t i = 0; i < batch->rays.count; i++) {
    const uint32_t slot = batch->slot[i];
    if (batch->rays.record[i] == WHITTLE_NONE) {
      const vector weight = vec(batch->weight[0][i], batch->weight[1][i], batch->weight[2][i]);
      if (!(primary && context->settings.transparent))
        add_light(w, slot, vec_mul(vec_from(scene->world.color), weight));
      else
        w->sample[3][slot] = 0.0f;
      if (geometry)
        write_geometry(context, w, slot, NULL, 0.0f);
      continue;
    }
    surface *s = &w->surfaces[w->surface_count++];
    s->slot = slot;
    for (int axis = 0; axis < 3; axis++)
      s->weight[axis] = batch->weight[axis][i];
    const bool outside = surface_load(scene, &batch->rays, i, smooth, s);
    if (geometry)
      write_geometry(context, w, slot, s, batch->rays.t[i]);
    if (!shade(context, w, s, outside, reflection, refraction))
      return false;
  }
  return true;
}

/* Asks every surface of the last shaded batch about one light. */
static bool light_batch(const tile_context *context, tile_worker *w, const light_record *l) {
  ray_batch *batch = &w->shadow;
  if (!ray_batch_reserve(batch, w->surface_count))
    return false;
  uint32_t n = 0;
  for (uint32_t k = 0; k < w->surface_count; k++) {
    const surface *s = &w->surfaces[k];
    vector light, to_light;
    float origin[3], d[3], share[3];
    if (!light_arrives(s, l, &light, &to_light, origin)) {
      w->stats.shadow_rays_left_out++;
      continue;
    }
    if (!l->shadow) {
      add_light(w, s->slot, light);
      continue;
    }
    vec_to(to_light, d);
    vec_to(light, share);
    for (int axis = 0; axis < 3; axis++) {
      batch->rays.origin[axis][n] = origin[axis];
      batch->rays.direction[axis][n] = d[axis];
      batch->weight[axis][n] = share[axis];
    }
    batch->rays.t_min[n] = 0.0f;
    /* What touches the light itself, to rounding, does not shadow it. */
    batch->rays.t[n] = l->kind == WHITTLE_POINT ? 1.0f - 0x1p-20f : __builtin_inff();
    batch->rays.skip[n] = s->record;
    batch->slot[n++] = s->slot;
  }
  batch->rays.count = n;
  trace_batch(context, w, batch, WHITTLE_RAY_SHADOW);
  for (uint32_t i = 0; i < n; i++)
    if (batch->rays.record[i] == WHITTLE_NONE)
      add_light(w, batch->slot[i],
                vec(batch->weight[0][i], batch->weight[1][i], batch->weight[2][i]));
  return true;
}

/* Traces and shades one batch, then its shadows; what it sends on goes to the next generation. */
static bool run_batch(const tile_context *context, tile_worker *w, ray_batch *batch, uint32_t kind,
                      uint32_t depth, bool geometry) {
  if (batch->rays.count == 0)
    return true;
  ray_batch *next = w->secondary[(depth + 1) % 2];
  const bool deeper = depth < context->settings.max_depth;
  trace_batch(context, w, batch, kind);
  if (!shade_batch(context, w, batch, deeper ? &next[0] : NULL, deeper ? &next[1] : NULL,
                   kind == WHITTLE_RAY_PRIMARY, geometry))
    return false;
  batch->rays.count = 0;
  for (uint32_t l = 0; l < context->light_count; l++)
    if (!light_batch(context, w, &context->lights[l]))
      return false;
  return true;
}

/* All generations of one sample of every pixel of the tile. */
static bool run_sample(const tile_context *context, tile_worker *w, uint32_t sample) {
  const uint32_t grid = context->grid;
  const bool geometry = sample == grid / 2 * grid + grid / 2;
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

static void write_counters(const tile_context *context, tile_worker *w, uint32_t slot) {
  const uint32_t x = w->pixel_x[slot], y = w->pixel_y[slot];
  uint32_t nodes = 0, triangles = 0;
  for (uint32_t kind = 0; kind < WHITTLE_RAY_KINDS; kind++) {
    const whittle_pass of_nodes = (whittle_pass)(WHITTLE_PASS_NODES_PRIMARY + kind);
    const whittle_pass of_triangles = (whittle_pass)(WHITTLE_PASS_TRIANGLES_PRIMARY + kind);
    if (context->image->pass[of_nodes])
      *pixel_of(context, of_nodes, x, y, 1) = (float)w->nodes[kind][slot];
    if (context->image->pass[of_triangles])
      *pixel_of(context, of_triangles, x, y, 1) = (float)w->triangles[kind][slot];
    nodes += w->nodes[kind][slot];
    triangles += w->triangles[kind][slot];
    w->stats.nodes[kind] += w->nodes[kind][slot];
    w->stats.triangles[kind] += w->triangles[kind][slot];
  }
  if (context->image->pass[WHITTLE_PASS_NODES])
    *pixel_of(context, WHITTLE_PASS_NODES, x, y, 1) = (float)nodes;
  if (context->image->pass[WHITTLE_PASS_TRIANGLES])
    *pixel_of(context, WHITTLE_PASS_TRIANGLES, x, y, 1) = (float)triangles;
}

static void write_tile(const tile_context *context, tile_worker *w) {
  const float share = 1.0f / (float)context->settings.samples;
  for (uint32_t slot = 0; slot < w->slots; slot++) {
    if (context->image->pass[WHITTLE_PASS_COMBINED]) {
      float *pixel = pixel_of(context, WHITTLE_PASS_COMBINED, w->pixel_x[slot], w->pixel_y[slot], 4);
      for (int channel = 0; channel < 4; channel++)
        pixel[channel] = w->sum[channel][slot] * share;
    }
    if (context->count)
      write_counters(context, w, slot);
  }
}

static bool kernel_render_tile(const tile_context *context, tile_worker *w, uint32_t tile) {
  const double start = whittle_seconds();
  tile_pixels(context, w, tile);
  memset(w->sum, 0, sizeof w->sum);
  if (context->count) {
    memset(w->nodes, 0, sizeof w->nodes);
    memset(w->triangles, 0, sizeof w->triangles);
  }
  for (int even = 0; even < 2; even++)
    w->secondary[even][0].rays.count = w->secondary[even][1].rays.count = 0;
  for (uint32_t sample = 0; sample < context->settings.samples; sample++) {
    if (atomic_load_explicit(context->cancelled, memory_order_relaxed))
      return true;
    if (!run_sample(context, w, sample))
      return false;
  }
  write_tile(context, w);
  w->stats.seconds_shade += whittle_seconds() - start;
  return true;
}
