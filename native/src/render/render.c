/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* A render: settings checked, tiles shared out from a queue, statistics added up. */

#define _POSIX_C_SOURCE 200809L

#include "render/render.h"

#include "base/clock.h"
#include "base/memory.h"
#include "render/cost.h"

#include <math.h>
#include <string.h>

typedef struct render_run {
  tile_context context;
  tile_worker *workers;
  uint32_t worker_count;
  cost_owners owners;
  atomic_uint_fast32_t next_tile;
  atomic_int out_of_memory;
} render_run;

static uint32_t grid_of(uint32_t samples) {
  uint32_t grid = 1;
  while (grid * grid < samples)
    grid++;
  return grid;
}

/* Fills in the defaults and refuses what makes no sense. */
static whittle_status settle(whittle_settings *s, whittle_error *error) {
  const whittle_status invalid = WHITTLE_INVALID_ARGUMENT;
  s->samples = s->samples ? s->samples : 1;
  if (s->samples > 4096 || grid_of(s->samples) * grid_of(s->samples) != s->samples)
    return whittle_fail(error, invalid, "samples",
                        "samples must be a square number from 1 to 4096, not %u", s->samples);
  if (s->pattern != WHITTLE_REGULAR && s->pattern != WHITTLE_STRATIFIED)
    return whittle_fail(error, invalid, "pattern", "pattern must be regular or stratified");
  if (s->max_depth > 64)
    return whittle_fail(error, invalid, "max_depth", "max_depth must be at most 64, not %u",
                        s->max_depth);
  s->max_depth = s->no_bounces ? 0 : s->max_depth ? s->max_depth : 8;
  if (!(s->cutoff >= 0.0f && s->cutoff <= 1.0f))
    return whittle_fail(error, invalid, "cutoff", "cutoff must be between 0 and 1");
  s->cutoff = s->no_cutoff ? 0.0f : s->cutoff > 0.0f ? s->cutoff : 1.0f / 1024;
  if (s->mode != WHITTLE_FAST && s->mode != WHITTLE_LECTURE && s->mode != WHITTLE_SINGLE)
    return whittle_fail(error, invalid, "mode", "mode must be fast, lecture or single");
  const uint32_t p = s->packet;
  if (p != 0 && p != 1 && p != 16 && p != 64 && p != 256 && p != 1024)
    return whittle_fail(error, invalid, "packet", "packet must be 1, 16, 64, 256 or 1024, not %u",
                        p);
  s->threads = s->threads ? s->threads : whittle_default_threads();
  return WHITTLE_OK;
}

whittle_status whittle_materials_exist(const whittle_scene *scene, whittle_error *error) {
  for (size_t i = 0; i < scene->mesh_count; i++) {
    const mesh *m = &scene->meshes[i];
    if (m->materials == NULL)
      continue;
    for (size_t t = 0; t < m->triangle_count; t++)
      if (m->materials[t] >= scene->material_count)
        return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "materials",
                            "mesh %zu, triangle %zu: material %u of %zu does not exist", i, t,
                            m->materials[t], scene->material_count);
  }
  return WHITTLE_OK;
}

/* Lights in scene space, with intensities for distances measured there. */
static light_record *prepare_lights(const whittle_scene *scene) {
  light_record *lights = whittle_allocate(scene->light_count, sizeof *lights);
  if (lights == NULL)
    return NULL;
  for (size_t i = 0; i < scene->light_count; i++) {
    const whittle_light *from = &scene->lights[i];
    light_record *to = &lights[i];
    const bool point = from->kind == WHITTLE_POINT;
    double length = 0.0;
    for (int axis = 0; axis < 3; axis++)
      length = fmax(length, fabs(from->direction[axis]));
    double sum = 0.0;
    for (int axis = 0; axis < 3 && !point; axis++)
      sum += from->direction[axis] / length * (from->direction[axis] / length);
    for (int axis = 0; axis < 3; axis++) {
      to->place[axis] = (float)(point ? ldexp(from->position[axis] - scene->frame.center[axis],
                                              -scene->frame.exponent)
                                      : -(from->direction[axis] / length) / sqrt(sum));
      to->intensity[axis] = (float)(point ? ldexp(from->intensity[axis], -2 * scene->frame.exponent)
                                          : from->intensity[axis]);
    }
    to->kind = from->kind;
    to->shadow = !from->no_shadow;
  }
  return lights;
}

/* What is wanted of each ray, and who is charged, if anyone is. */
static whittle_status prepare_watch(render_run *run, const whittle_image *image, ray_log *log,
                                    whittle_error *error) {
  tile_context *c = &run->context;
  c->log = log;
  c->coherence = image->pass[WHITTLE_PASS_COHERENCE] != NULL;
  c->watch = log != NULL || image->cost != NULL || c->coherence ||
             image->pass[WHITTLE_PASS_LEAF_DEPTH] != NULL;
  if (c->coherence && c->settings.mode != WHITTLE_LECTURE)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "passes",
                        "passes: coherence is counted in the lecture mode only: choose that mode, "
                        "or leave the pass out");
  if (image->cost == NULL)
    return WHITTLE_OK;
  c->owners = &run->owners;
  const whittle_status status = whittle_cost_check(c->scene, image->cost, error);
  return status == WHITTLE_OK ? whittle_cost_begin(c->scene, &run->owners, error) : status;
}

/* How many rays make a packet of each kind, unless the settings say: measured, see benchmarks. */
static void choose_packets(tile_context *context) {
  static const uint32_t fast[WHITTLE_RAY_KINDS] = {256, 64, 256, 256};
  static const uint32_t lecture[WHITTLE_RAY_KINDS] = {256, 256, 64, 64};
  const whittle_settings *s = &context->settings;
  const uint32_t *chosen = s->mode == WHITTLE_LECTURE ? lecture : fast;
  for (int kind = 0; kind < WHITTLE_RAY_KINDS; kind++)
    context->packets[kind] = s->packet ? s->packet : chosen[kind];
}

/* Tiles that leave each thread enough of them to end with the others. */
#define TILES_A_THREAD 16

static uint32_t tiles_along(const tile_context *c, int axis) {
  return (c->region[axis + 2] - c->region[axis] + c->tile_edge - 1) / c->tile_edge;
}

/* What is counted by pixel, and the lecture's packets, have one sample of a pixel at a time. Tiles
 * whose seconds are told stay small. */
static void choose_tiles(tile_context *c) {
  const bool one = c->count || c->watch || c->settings.mode == WHITTLE_LECTURE;
  const uint32_t most = one ? 1 : WHITTLE_TILE_SLOTS, samples = c->settings.samples;
  const uint32_t least = TILES_A_THREAD * c->settings.threads;
  c->together = samples < most ? samples : most;
  const bool small = (one || c->image->pass[WHITTLE_PASS_SECONDS]) && c->settings.packet != 1024;
  c->tile_edge = small ? WHITTLE_TILE_EDGE / 2 : WHITTLE_TILE_EDGE;
  while (c->tile_edge * c->tile_edge * c->together > WHITTLE_TILE_SLOTS ||
         (c->tile_edge > 16 && c->settings.packet == 0 &&
          tiles_along(c, 0) * tiles_along(c, 1) < least))
    c->tile_edge /= 2;
  c->tiles_x = tiles_along(c, 0);
  c->tiles = c->tiles_x * tiles_along(c, 1);
}

static whittle_status prepare(render_run *run, const whittle_scene *scene,
                              const whittle_camera *camera, const whittle_settings *settings,
                              const whittle_image *image, ray_log *log, whittle_error *error) {
  tile_context *c = &run->context;
  c->settings = *settings;
  whittle_status status = settle(&c->settings, error);
  if (status == WHITTLE_OK)
    status = whittle_camera_rays(scene, camera, &c->camera, error);
  if (status == WHITTLE_OK)
    status = whittle_materials_exist(scene, error);
  if (status != WHITTLE_OK)
    return status;
  c->kernels = whittle_kernels(error);
  if (c->kernels == NULL)
    return WHITTLE_UNSUPPORTED;
  c->scene = scene;
  c->image = image;
  c->needs = whittle_needs(scene, &c->settings, image);
  if (log != NULL)
    c->needs |= WHITTLE_NEED_COUNTERS;
  c->count = c->needs & WHITTLE_NEED_COUNTERS;
  if (c->count || c->settings.mode == WHITTLE_LECTURE)
    status = whittle_scene_has_binary(
        scene, c->count ? "Counters are" : "The packets of the lecture mode are", error);
  if (status != WHITTLE_OK)
    return status;
  if (c->settings.generic)
    c->needs |= WHITTLE_NEED_ALL & ~WHITTLE_NEED_COUNTERS;
  c->depth_scale = ldexp(1.0, scene->frame.exponent);
  c->width = camera->width, c->height = camera->height;
  memcpy(c->region, camera->region, sizeof c->region);
  if (!(c->region[0] | c->region[1] | c->region[2] | c->region[3]))
    c->region[2] = camera->width, c->region[3] = camera->height;
  c->grid = grid_of(c->settings.samples);
  choose_packets(c);
  c->light_count = (uint32_t)scene->light_count;
  c->lights = prepare_lights(scene);
  if (c->lights == NULL)
    return whittle_out_of_memory(error, "the lights");
  status = prepare_watch(run, image, log, error);
  choose_tiles(c);
  return status;
}

static void work(void *context, uint32_t worker, whittle_run_state *state) {
  render_run *run = context;
  const tile_context *c = &run->context;
  for (;;) {
    const uint32_t tile = (uint32_t)atomic_fetch_add(&run->next_tile, 1);
    if (tile >= c->tiles || whittle_cancelled(state) || atomic_load(&run->out_of_memory))
      return;
    if (!c->kernels->render_tile(c, &run->workers[worker], tile))
      atomic_store(&run->out_of_memory, 1);
    whittle_advance(state, 1);
  }
}

static size_t worker_bytes(const tile_worker *w) {
  size_t bytes = sizeof *w + ray_batch_bytes(&w->primary) + ray_batch_bytes(&w->shadow) +
                 surface_batch_bytes(&w->surfaces);
  for (int i = 0; i < 4; i++)
    bytes += ray_batch_bytes(&w->secondary[i / 2][i % 2]);
  return bytes;
}

/* Workers with nothing in them yet. */
static whittle_status prepare_workers(render_run *run, whittle_error *error) {
  const tile_context *c = &run->context;
  const uint32_t count = c->settings.threads < c->tiles ? c->settings.threads : c->tiles;
  run->workers = whittle_allocate(count, sizeof *run->workers);
  if (run->workers == NULL)
    return whittle_out_of_memory(error, "the threads' ray buffers");
  memset(run->workers, 0, count * sizeof *run->workers);
  run->worker_count = count;
  for (uint32_t i = 0; i < count; i++) {
    tile_worker *w = &run->workers[i];
    w->shadow.logged = c->log != NULL;
    for (int batch = 0; batch < 4; batch++)
      w->secondary[batch / 2][batch % 2].logged = c->log != NULL;
    if (c->owners != NULL && !whittle_cost_worker_begin(c->owners, w))
      return whittle_out_of_memory(error, "the threads' tables of cost");
  }
  return WHITTLE_OK;
}

static void release_worker(tile_worker *w) {
  whittle_cost_worker_end(w);
  ray_batch_release(&w->primary);
  ray_batch_release(&w->shadow);
  for (int i = 0; i < 4; i++)
    ray_batch_release(&w->secondary[i / 2][i % 2]);
  surface_batch_release(&w->surfaces);
}

/* Adds what one worker counted to the whole. */
static void add_stats(whittle_render_stats *sum, const tile_worker *w) {
  const whittle_render_stats *s = &w->stats;
  for (int kind = 0; kind < WHITTLE_RAY_KINDS; kind++) {
    sum->rays[kind] += s->rays[kind];
    sum->nodes[kind] += s->nodes[kind];
    sum->triangles[kind] += s->triangles[kind];
  }
  sum->shadow_rays_left_out += s->shadow_rays_left_out;
  sum->secondary_rays_left_out += s->secondary_rays_left_out;
  sum->dropped_weight += s->dropped_weight;
  sum->own_box_misses += s->own_box_misses;
  sum->packets += w->packet_counters.packets;
  sum->packet_nodes += w->packet_counters.nodes;
  sum->packet_rays += w->packet_counters.rays;
  sum->decided_first += w->packet_counters.decided_first;
  sum->decided_frustum += w->packet_counters.decided_frustum;
  sum->decided_brute_force += w->packet_counters.decided_brute_force;
  sum->active_rays += w->packet_counters.active_rays;
  sum->visited_rays += w->packet_counters.visited_rays;
  sum->node_lanes += w->packet_counters.node_lanes;
  sum->node_lanes_used += w->packet_counters.node_lanes_used;
  sum->triangle_lanes += w->packet_counters.triangle_lanes;
  sum->triangle_lanes_used += w->packet_counters.triangle_lanes_used;
  sum->seconds_primary += s->seconds_primary;
  sum->seconds_shadow += s->seconds_shadow;
  sum->seconds_secondary += s->seconds_secondary;
  sum->seconds_shade += s->seconds_shade;
  sum->bytes += worker_bytes(w);
}

static void collect(const render_run *run, double start, whittle_render_stats *stats) {
  const tile_context *c = &run->context;
  *stats = (whittle_render_stats){.threads = run->worker_count,
                                  .lanes = c->kernels->lanes,
                                  .needs = whittle_needs(c->scene, &c->settings, c->image),
                                  .kernel_needs = c->needs};
  for (uint32_t i = 0; i < run->worker_count; i++)
    add_stats(stats, &run->workers[i]);
  if (c->owners != NULL)
    stats->bytes += whittle_cost_owner_bytes(c->owners, c->scene) +
                    run->worker_count * whittle_cost_worker_bytes(c->owners);
  const double pixels = (double)(c->region[2] - c->region[0]) * (c->region[3] - c->region[1]);
  stats->dropped_weight /= pixels * c->settings.samples;
  stats->seconds = whittle_seconds() - start;
}

/* Renders all tiles of a run that is prepared. */
static whittle_status run_tiles(render_run *run, const whittle_progress *progress,
                                whittle_run_state *state, whittle_error *error) {
  whittle_status status = prepare_workers(run, error);
  if (status != WHITTLE_OK)
    return status;
  state->total = run->context.tiles;
  status = whittle_run(run->worker_count, work, run, state, progress, error);
  if (status == WHITTLE_OK && atomic_load(&run->out_of_memory))
    status = whittle_fail(
        error, WHITTLE_OUT_OF_MEMORY, "max_depth",
        "the rays of one tile do not fit into memory: lower max_depth or raise cutoff");
  return status;
}

whittle_status whittle_render_run(const whittle_scene *scene, const whittle_camera *camera,
                                  const whittle_settings *settings, const whittle_image *image,
                                  ray_log *log, whittle_render_stats *stats,
                                  whittle_run_state *state, whittle_error *error) {
  whittle_status status = whittle_scene_read_begin(scene, error);
  if (status != WHITTLE_OK)
    return status;
  const double start = whittle_seconds();
  render_run run = {.context = {.cancelled = &state->cancelled}};
  status = prepare(&run, scene, camera, settings, image, log, error);
  if (status == WHITTLE_OK)
    status = run_tiles(&run, &settings->progress, state, error);
  if (status == WHITTLE_OK && image->cost != NULL)
    whittle_cost_sum(&run.owners, run.workers, run.worker_count, image->cost);
  if (status == WHITTLE_OK && stats != NULL)
    collect(&run, start, stats);
  for (uint32_t i = 0; i < run.worker_count; i++)
    release_worker(&run.workers[i]);
  whittle_release(run.workers);
  whittle_release((void *)run.context.lights);
  whittle_cost_end(&run.owners);
  whittle_scene_read_end(scene);
  return status;
}

whittle_status whittle_render(const whittle_scene *scene, const whittle_camera *camera,
                              const whittle_settings *settings, const whittle_image *image,
                              whittle_render_stats *stats, whittle_error *error) {
  whittle_run_state state = {0};
  return whittle_render_run(scene, camera, settings, image, NULL, stats, &state, error);
}
