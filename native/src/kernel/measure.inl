/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* A batch traced, and what it took: time, counts by pixel, charges to owners, the log. */

/* Writes down the rays of a batch before they are traced; false if there is no memory. */
static __attribute__((cold)) bool log_rays(const tile_context *context, const tile_worker *w,
                                           const ray_batch *batch, uint32_t kind) {
  const ray_stream *rays = &batch->rays;
  logged_ray *to = ray_log_add(context->log, rays->count);
  if (to == NULL)
    return false;
  for (uint32_t i = 0; i < rays->count; i++) {
    const bool primary = kind == WHITTLE_RAY_PRIMARY, shadow = kind == WHITTLE_RAY_SHADOW;
    to[i] = (logged_ray){.kind = kind,
                         .sample = w->slot_sample[batch->slot[i]],
                         .depth = w->depth,
                         .parent = primary ? WHITTLE_NONE : batch->parent[i],
                         .light = shadow ? w->light : WHITTLE_NONE,
                         .t_min = rays->t_min[i],
                         .t_max = rays->t[i]};
    for (int axis = 0; axis < 3; axis++) {
      to[i].origin[axis] = rays->origin[axis][i];
      to[i].direction[axis] = rays->direction[axis][i];
    }
  }
  return true;
}

/* Adds what the rays just traced have found; false if the log lost something. */
static __attribute__((cold)) bool log_hits(const tile_context *context, const ray_batch *batch) {
  const ray_stream *rays = &batch->rays;
  logged_ray *to = context->log->rays + context->log->count - rays->count;
  for (uint32_t i = 0; i < rays->count; i++) {
    to[i].t = rays->t[i], to[i].u = rays->u[i], to[i].v = rays->v[i];
    to[i].record = rays->record[i];
    to[i].nodes = rays->nodes[i], to[i].triangles = rays->triangles[i];
  }
  return !context->log->full;
}

static void add_seconds(tile_worker *w, uint32_t kind, double seconds) {
  double *spent[WHITTLE_RAY_KINDS] = {&w->stats.seconds_primary, &w->stats.seconds_shadow,
                                      &w->stats.seconds_secondary, &w->stats.seconds_secondary};
  *spent[kind] += seconds;
  w->stats.seconds_shade -= seconds;
}

/* Traces rays that are about to be counted in packets, for the coherence of these. */
static __attribute__((cold)) void trace_together(const trace_context *counting, ray_stream *rays,
                                                 uint32_t kind) {
  uint64_t counted_again = 0;
  trace_context together = *counting;
  together.count = false;
  together.own_box_misses = &counted_again;
  const float limit = rays->count > 0 ? rays->t[0] : 0.0f; /* that of all rays of a batch */
  trace_stream(&together, rays, kind == WHITTLE_RAY_SHADOW);
  for (uint32_t i = 0; i < rays->count; i++)
    rays->t[i] = limit;
}

/* Traces rays of one kind; false if memory for the log ran out. */
static bool trace_batch(const tile_context *context, tile_worker *w, ray_batch *batch,
                        uint32_t kind) {
  static const uint32_t sees_bit[WHITTLE_RAY_KINDS] = {WHITTLE_CAMERA, WHITTLE_SHADOW,
                                                       WHITTLE_REFLECTION, WHITTLE_REFRACTION};
  const ray_watch watch = {.slot = batch->slot,
                           .leaf_depth = w->leaf_depth,
                           .owners = context->owners,
                           .charged = &w->cost[kind],
                           .log = context->log,
                           .shares = context->coherence ? w->shares : NULL};
  const trace_context trace = {.scene = context->scene,
                               .mode = context->settings.mode,
                               .packet = context->packets[kind],
                               .visibility = sees_bit[kind],
                               .masked = context->needs & WHITTLE_NEED_VISIBILITY,
                               .count = context->count,
                               .watch = context->watch ? &watch : NULL,
                               .packets = &w->packet_counters,
                               .memory = &w->packet_memory[kind],
                               .own_box_misses = &w->stats.own_box_misses};
  if (context->log && !log_rays(context, w, batch, kind))
    return false;
  const double start = whittle_seconds();
  if (context->coherence && context->count)
    trace_together(&trace, &batch->rays, kind);
  trace_stream(&trace, &batch->rays, kind == WHITTLE_RAY_SHADOW);
  add_seconds(w, kind, whittle_seconds() - start);
  w->stats.rays[kind] += batch->rays.count;
  for (uint32_t i = 0; context->count && i < batch->rays.count; i++) {
    w->nodes[kind][batch->slot[i]] += batch->rays.nodes[i];
    w->triangles[kind][batch->slot[i]] += batch->rays.triangles[i];
  }
  return context->log == NULL || log_hits(context, batch);
}

static inline float *pixel_of(const tile_context *context, whittle_pass pass, uint32_t x,
                              uint32_t y, uint32_t channels) {
  const uint32_t *region = context->region;
  const size_t at = (size_t)(y - region[1]) * (region[2] - region[0]) + (x - region[0]);
  return context->image->pass[pass] + at * channels;
}

/* Writes a pass of one number, if it is wanted. */
static inline void write_number(const tile_context *context, whittle_pass pass, uint32_t x,
                                uint32_t y, float number) {
  if (context->image->pass[pass])
    *pixel_of(context, pass, x, y, 1) = number;
}

static void write_counters(const tile_context *context, tile_worker *w, uint32_t pixel) {
  const uint32_t x = w->pixel_x[pixel], y = w->pixel_y[pixel];
  uint32_t nodes = 0, triangles = 0;
  for (uint32_t kind = 0; kind < WHITTLE_RAY_KINDS; kind++) {
    const uint32_t of_nodes = w->nodes[kind][pixel], of_triangles = w->triangles[kind][pixel];
    write_number(context, (whittle_pass)(WHITTLE_PASS_NODES_PRIMARY + kind), x, y, (float)of_nodes);
    write_number(context, (whittle_pass)(WHITTLE_PASS_TRIANGLES_PRIMARY + kind), x, y,
                 (float)of_triangles);
    nodes += of_nodes, w->stats.nodes[kind] += of_nodes;
    triangles += of_triangles, w->stats.triangles[kind] += of_triangles;
  }
  write_number(context, WHITTLE_PASS_NODES, x, y, (float)nodes);
  write_number(context, WHITTLE_PASS_TRIANGLES, x, y, (float)triangles);
  write_number(context, WHITTLE_PASS_LEAF_DEPTH, x, y, (float)w->leaf_depth[pixel]);
}

static void write_coherence(const tile_context *context, const tile_worker *w, uint32_t pixel) {
  const packet_share *s = &w->shares[pixel];
  const double share = s->visited ? (double)s->active / (double)s->visited : 1.0;
  write_number(context, WHITTLE_PASS_COHERENCE, w->pixel_x[pixel], w->pixel_y[pixel], (float)share);
}

/* The same for all pixels of a tile: nothing finer can be measured. */
static void write_seconds(const tile_context *context, const tile_worker *w, double seconds) {
  const float each = (float)(seconds / w->pixels);
  for (uint32_t i = 0; i < w->pixels; i++)
    write_number(context, WHITTLE_PASS_SECONDS, w->pixel_x[i], w->pixel_y[i], each);
}
