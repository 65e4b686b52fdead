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

/* The slots of samples first .. first + count of every pixel, and where in the image each lies: in
 * the middle of its cell of the pixel, or at a hashed point of it. */
static void sample_points(const tile_context *context, tile_worker *w, uint32_t first,
                          uint32_t count) {
  const float grid = (float)context->grid;
  const uint32_t seed = context->settings.seed;
  const bool regular = context->settings.pattern == WHITTLE_REGULAR;
  w->slots = 0;
  for (uint32_t i = 0; i < w->pixels; i++)
    for (uint32_t s = first; s < first + count; s++) {
      const uint32_t slot = w->slots++;
      w->slot_x[slot] = w->pixel_x[i], w->slot_y[slot] = w->pixel_y[i], w->slot_sample[slot] = s;
      w->column[slot] = (float)(s % context->grid), w->row[slot] = (float)(s / context->grid);
    }
  for (uint32_t i = 0; i < w->slots; i++) {
    const uint32_t x = w->slot_x[i], y = w->slot_y[i];
    const uint32_t hash = whittle_hash(x, y, w->slot_sample[i], seed);
    const float dx = regular ? 0.5f : (float)(hash >> 16) * 0x1p-16f + 0x1p-17f;
    const float dy = regular ? 0.5f : (float)(hash & 0xffff) * 0x1p-16f + 0x1p-17f;
    w->sample_x[i] = (float)x + (w->column[i] + dx) / grid;
    w->sample_y[i] = (float)y + (w->row[i] + dy) / grid;
  }
}

/* The pixels of a tile in Z order, so that consecutive rays form squares at every size. */
static void tile_pixels(const tile_context *context, tile_worker *w, uint32_t tile) {
  const uint32_t edge = context->tile_edge;
  const uint32_t x0 = context->region[0] + tile % context->tiles_x * edge;
  const uint32_t y0 = context->region[1] + tile / context->tiles_x * edge;
  w->pixels = 0;
  for (uint32_t i = 0; i < edge * edge; i++) {
    uint32_t dx = 0, dy = 0;
    for (uint32_t bit = 0; 1u << bit < edge; bit++) {
      dx |= (i >> (2 * bit) & 1) << bit;
      dy |= (i >> (2 * bit + 1) & 1) << bit;
    }
    if (x0 + dx >= context->region[2] || y0 + dy >= context->region[3])
      continue;
    w->pixel_x[w->pixels] = x0 + dx;
    w->pixel_y[w->pixels++] = y0 + dy;
  }
}

/* base + x dx + y dy on one axis, for every slot. */
static void affine(float *out, const tile_worker *w, float base, float dx, float dy) {
  for (uint32_t i = 0; i < w->slots; i += V_LANES) {
    const v_float x = v_load(w->sample_x + i), y = v_load(w->sample_y + i);
    v_store(out + i, (v_set(base) + x * v_set(dx)) + y * v_set(dy));
  }
}

static bool primary_rays(const tile_context *context, tile_worker *w) {
  const camera_rays *camera = &context->camera;
  ray_batch *batch = &w->primary;
  if (!ray_batch_reserve(batch, w->slots))
    return false;
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
  const uint32_t x = w->slot_x[s->slot[i]], y = w->slot_y[s->slot[i]];
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
      pixel_of(context, pass, w->slot_x[slot], w->slot_y[slot], whittle_pass_channels(pass))[k] =
          nothing[pass];
}

/* Whether a slot is the sample in the middle of its pixel, which the geometry passes show. */
static inline bool is_middle(const tile_context *context, const tile_worker *w, uint32_t slot) {
  return w->slot_sample[slot] == context->grid / 2 * context->grid + context->grid / 2;
}

/* What the rays of a lane group see that hit nothing, those of `set`. */
static void shade_misses(const tile_context *context, tile_worker *w, const ray_batch *batch,
                         uint32_t at, uint32_t set, bool primary, bool geometry) {
  const v_vector sky = vec_set(context->scene->world.color);
  const bool seen = !(primary && context->settings.transparent);
  if (seen)
    add_light(w, batch->slot + at, set, vec_mul(sky, vec_load(batch->weight, at)));
  for (; (geometry || !seen) && set; set &= set - 1) {
    const uint32_t slot = batch->slot[at + (uint32_t)__builtin_ctz(set)];
    if (!seen)
      w->sample[3][slot] = 0.0f;
    if (geometry && is_middle(context, w, slot))
      write_miss(context, w, slot);
  }
}

/* Lists the rays of a lane group that hit, those of `set`, as surfaces. */
static void list_hits(surface_batch *s, const ray_batch *batch, uint32_t at, uint32_t set) {
  const ray_stream *rays = &batch->rays;
  const uint32_t n = s->count;
  for (int i = 0; i < 3; i++) {
    v_store_packed(s->weight[i] + n, v_load(batch->weight[i] + at), set);
    v_store_packed(s->view[i] + n, v_load(rays->direction[i] + at), set);
  }
  v_store_packed(s->u + n, v_load(rays->u + at), set);
  v_store_packed(s->v + n, v_load(rays->v + at), set);
  v_storeu_packed(s->ray + n, v_from(at), set);
  v_storeu_packed(s->slot + n, v_loadu(batch->slot + at), set);
  v_storeu_packed(s->record + n, v_loadu(rays->record + at), set);
  s->count = n + (uint32_t)__builtin_popcount(set);
}

/* Shades misses, and lists the hits of a batch as surfaces. */
static void sort_hits(const tile_context *context, tile_worker *w, const ray_batch *batch,
                      bool primary, bool geometry) {
  for (uint32_t at = 0; at < batch->rays.count; at += V_LANES) {
    const uint32_t left = batch->rays.count - at, count = left < V_LANES ? left : V_LANES;
    const uint32_t all = (uint32_t)((1ull << count) - 1);
    const v_mask none = v_equ(v_loadu(batch->rays.record + at), v_setu(WHITTLE_NONE));
    const uint32_t misses = v_bits(none) & all;
    if (misses != 0)
      shade_misses(context, w, batch, at, misses, primary, geometry);
    if (misses != all)
      list_hits(&w->surfaces, batch, at, all & ~misses);
  }
}

/* Shades a batch; with `geometry`, of primary rays, also writes the geometry passes. */
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
    fetch_ahead(context->scene, s, at);
    const v_mask outside = load_surfaces(context->scene, count, smooth, s, at);
    for (uint32_t i = at; geometry && i < at + count; i++)
      if (is_middle(context, w, s->slot[i]))
        write_hit(context, w, i, batch->rays.t[s->ray[i]]);
    if (!shade(context, w, at, count, outside, reflection, refraction))
      return false;
  }
  return true;
}

/* The rays of every surface of the last shaded batch that ask about one light; false if there is
 * no memory. */
static bool shadow_rays(const tile_context *context, tile_worker *w, const light_record *l) {
  const surface_batch *s = &w->surfaces;
  ray_batch *batch = &w->shadow;
  /* What touches the light itself, to rounding, does not shadow it. */
  const float t_max = l->kind == WHITTLE_POINT ? 1.0f - 0x1p-20f : __builtin_inff();
  w->stats.shadow_rays_left_out += s->count;
  batch->rays.count = 0;
  for (uint32_t i = 0; i < s->lit_groups; i++) {
    const uint32_t at = s->lit[i], count = s->count - at < V_LANES ? s->count - at : V_LANES;
    const v_vector origin = vec_load(s->origin, at);
    v_vector light, to_light;
    const uint32_t arrives = light_arrives(context, s, at, l, origin, &light, &to_light) &
                             (uint32_t)((1ull << count) - 1);
    w->stats.shadow_rays_left_out -= (uint32_t)__builtin_popcount(arrives);
    if (!l->shadow)
      add_light(w, s->slot + at, arrives, light);
    else if (!append_rays(batch, arrives, s, at, origin, to_light, light, t_max))
      return false;
  }
  return true;
}

/* Asks every surface of the last shaded batch about one light. */
static bool light_batch(const tile_context *context, tile_worker *w, const light_record *l) {
  ray_batch *batch = &w->shadow;
  if (!shadow_rays(context, w, l))
    return false;
  if (batch->rays.count == 0)
    return true;
  if (!trace_batch(context, w, batch, WHITTLE_RAY_SHADOW))
    return false;
  for (uint32_t at = 0; at < batch->rays.count; at += V_LANES) {
    const uint32_t left = batch->rays.count - at, count = left < V_LANES ? left : V_LANES;
    const v_mask open = v_equ(v_loadu(batch->rays.record + at), v_setu(WHITTLE_NONE));
    const uint32_t set = v_bits(open) & (uint32_t)((1ull << count) - 1);
    if (set != 0)
      add_light(w, batch->slot + at, set, vec_load(batch->weight, at));
  }
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

/* Whether a pass is wanted that shows where the middle of a pixel meets the scene. */
static bool wants_geometry(const whittle_image *image) {
  for (whittle_pass pass = WHITTLE_PASS_DEPTH; pass < WHITTLE_PASS_NODES; pass++)
    if (image->pass[pass] != NULL)
      return true;
  return false;
}

/* Adds the slots' samples to their pixels, in order. */
static void add_samples(tile_worker *w, uint32_t count) {
  for (int channel = 0; channel < 4; channel++)
    for (uint32_t i = 0; i < w->pixels; i++) {
      float sum = w->sum[channel][i];
      for (uint32_t s = 0; s < count; s++)
        sum += w->sample[channel][i * count + s];
      w->sum[channel][i] = sum;
    }
}

/* All generations of samples first .. first + count of every pixel of the tile. */
static bool run_samples(const tile_context *context, tile_worker *w, uint32_t first,
                        uint32_t count) {
  sample_points(context, w, first, count);
  for (uint32_t slot = 0; slot < w->slots; slot++) {
    w->sample[0][slot] = w->sample[1][slot] = w->sample[2][slot] = 0.0f;
    w->sample[3][slot] = 1.0f;
  }
  if (!primary_rays(context, w) ||
      !run_batch(context, w, &w->primary, WHITTLE_RAY_PRIMARY, 0, wants_geometry(context->image)))
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
  add_samples(w, count);
  return true;
}

static void write_tile(const tile_context *context, tile_worker *w) {
  const float share = 1.0f / (float)context->settings.samples;
  for (uint32_t i = 0; i < w->pixels; i++) {
    if (context->image->pass[WHITTLE_PASS_COMBINED]) {
      float *pixel = pixel_of(context, WHITTLE_PASS_COMBINED, w->pixel_x[i], w->pixel_y[i], 4);
      for (int channel = 0; channel < 4; channel++)
        pixel[channel] = w->sum[channel][i] * share;
    }
    if (context->count)
      write_counters(context, w, i);
    if (context->coherence)
      write_coherence(context, w, i);
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
  const uint32_t samples = context->settings.samples;
  for (uint32_t first = 0, count; first < samples; first += count) {
    count = samples - first < context->together ? samples - first : context->together;
    if (atomic_load_explicit(context->cancelled, memory_order_relaxed))
      return true;
    if (!run_samples(context, w, first, count))
      return false;
  }
  write_tile(context, w);
  const double seconds = whittle_seconds() - start;
  if (context->image->pass[WHITTLE_PASS_SECONDS])
    write_seconds(context, w, seconds);
  w->stats.seconds_shade += seconds;
  return true;
}
