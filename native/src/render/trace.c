/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The caller's rays through the kernels, in chunks shared out from a queue. */

#define _POSIX_C_SOURCE 200809L

#include "base/threads.h"
#include "kernel/kernel.h"
#include "scene/rays.h"

#include <math.h>
#include <string.h>

/* Below this many rays a thread costs more than it saves. */
#define RAYS_WORTH_A_THREAD 4096

typedef struct trace_run {
  const whittle_scene *scene;
  const whittle_rays *rays;
  const whittle_hits *hits; /* NULL: only whether anything is hit */
  uint8_t *blocked;
  const kernel_table *kernels;
  uint32_t packet, visibility; /* packet 0: chosen for each chunk */
  bool count, masked;
  atomic_size_t next;
} trace_run;

typedef struct chunk_results {
  float u[RAY_CHUNK], v[RAY_CHUNK];
  uint32_t record[RAY_CHUNK], skip[RAY_CHUNK], nodes[RAY_CHUNK], triangles[RAY_CHUNK];
} chunk_results;

static ray_stream stream_of(ray_chunk *chunk, chunk_results *results) {
  ray_stream rays = {.count = chunk->count,
                     .one_origin = chunk->one_origin,
                     .t_min = chunk->t_min,
                     .t = chunk->t_max,
                     .u = results->u,
                     .v = results->v,
                     .record = results->record,
                     .skip = results->skip,
                     .nodes = results->nodes,
                     .triangles = results->triangles};
  for (int axis = 0; axis < 3; axis++) {
    rays.origin[axis] = chunk->origin[axis];
    rays.direction[axis] = chunk->direction[axis];
  }
  return rays;
}

static void give_counts(const whittle_hits *hits, const chunk_results *results, size_t first,
                        uint32_t count) {
  if (hits->nodes)
    memcpy(hits->nodes + first, results->nodes, count * sizeof(uint32_t));
  if (hits->triangles)
    memcpy(hits->triangles + first, results->triangles, count * sizeof(uint32_t));
}

/* Every so many rays are looked at when a packet size is chosen. */
enum { SAMPLE = 8 };

/* Two neighbours, and all that were looked at so far. */
typedef struct likeness {
  float low[3], high[3]; /* of the origins */
  float steps;           /* between neighbours' origins, summed over all axes */
  uint32_t pairs, alike; /* that look into the same octant */
} likeness;

static void compare_neighbours(likeness *l, const ray_chunk *chunk, uint32_t i) {
  bool same = true;
  for (int axis = 0; axis < 3; axis++) {
    const float *origin = chunk->origin[axis] + i, *direction = chunk->direction[axis] + i;
    l->low[axis] = origin[0] < l->low[axis] ? origin[0] : l->low[axis];
    l->high[axis] = origin[0] > l->high[axis] ? origin[0] : l->high[axis];
    l->steps += fabsf(origin[1] - origin[0]);
    same = same && (direction[0] < 0.0f) == (direction[1] < 0.0f);
  }
  l->pairs++;
  l->alike += same;
}

/* How many rays make a packet: the whole chunk, if most neighbours look into the same octant and
 * start close to each other. In random order an eighth do, and their origins lie a third of the
 * extent apart on average. What that cannot tell, packets find out: they give up. */
static uint32_t packet_for(const ray_chunk *chunk) {
  likeness l = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, 0, 0, 0};
  for (uint32_t i = 0; i + 1 < chunk->count; i += SAMPLE)
    compare_neighbours(&l, chunk, i);
  float extent = 0.0f;
  for (int axis = 0; axis < 3; axis++)
    extent += l.high[axis] - l.low[axis];
  const bool close = 4.0f * l.steps <= (float)l.pairs * extent;
  return close && 2 * l.alike > l.pairs ? RAY_CHUNK : 1;
}

static void work(void *context, uint32_t worker, whittle_run_state *state) {
  (void)worker, (void)state;
  trace_run *run = context;
  uint64_t own_box_misses = 0;
  packet_memory memory = {0};
  trace_context trace = {.scene = run->scene,
                         .mode = WHITTLE_FAST,
                         .packet = run->packet,
                         .visibility = run->visibility,
                         .masked = run->masked,
                         .count = run->count,
                         .memory = &memory,
                         .own_box_misses = &own_box_misses};
  ray_chunk chunk;
  chunk_results results;
  memset(results.skip, 0xff, sizeof results.skip); /* none */
  for (;;) {
    const size_t first = atomic_fetch_add(&run->next, RAY_CHUNK);
    if (first >= run->rays->count)
      return;
    const size_t left = run->rays->count - first;
    run->kernels->load(&run->scene->frame, run->rays, first,
                       (uint32_t)(left < RAY_CHUNK ? left : RAY_CHUNK), &chunk);
    if (run->packet == 0)
      trace.packet = packet_for(&chunk);
    ray_stream rays = stream_of(&chunk, &results);
    if (run->hits != NULL) {
      run->kernels->closest(&trace, &rays);
      run->kernels->give(run->scene, &chunk, &rays, run->hits, first);
      give_counts(run->hits, &results, first, chunk.count);
    } else {
      run->kernels->any(&trace, &rays);
      run->kernels->give_blocked(&rays, run->blocked + first);
    }
  }
}

static whittle_status trace(trace_run *run, const whittle_trace_options *options,
                            whittle_error *error) {
  const whittle_scene *scene = run->scene;
  const uint32_t packet = options ? options->packet : 0;
  if (packet > RAY_CHUNK)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "packet",
                        "packet must be at most %d, not %u", RAY_CHUNK, packet);
  whittle_status status = whittle_rays_check(run->rays, error);
  if (status != WHITTLE_OK)
    return status;
  status = whittle_scene_read_begin(scene, error);
  if (status != WHITTLE_OK)
    return status;
  if (run->count)
    status = whittle_scene_has_binary(scene, "Counters are", error);
  if (status != WHITTLE_OK) {
    whittle_scene_read_end(scene);
    return status;
  }
  run->kernels = whittle_kernels(error);
  run->packet = packet;
  run->visibility = run->rays->visibility ? run->rays->visibility : WHITTLE_ALL;
  for (size_t i = 0; i < scene->instance_count; i++)
    run->masked |= scene->instances[i].visibility != WHITTLE_ALL || run->visibility != WHITTLE_ALL;
  uint32_t threads = options && options->threads ? options->threads : whittle_default_threads();
  const size_t useful = run->rays->count / RAYS_WORTH_A_THREAD + 1;
  threads = threads < useful ? threads : (uint32_t)useful;
  whittle_run_state state = {.total = run->rays->count};
  status = run->kernels == NULL ? WHITTLE_UNSUPPORTED
                                : whittle_run(threads, work, run, &state, NULL, error);
  whittle_scene_read_end(scene);
  return status;
}

whittle_status whittle_intersect(const whittle_scene *scene, const whittle_rays *rays,
                                 const whittle_hits *hits, const whittle_trace_options *options,
                                 whittle_error *error) {
  trace_run run = {.scene = scene, .rays = rays, .hits = hits};
  run.count = hits->nodes != NULL || hits->triangles != NULL;
  return trace(&run, options, error);
}

whittle_status whittle_occluded(const whittle_scene *scene, const whittle_rays *rays,
                                uint8_t *blocked, const whittle_trace_options *options,
                                whittle_error *error) {
  trace_run run = {.scene = scene, .rays = rays, .blocked = blocked};
  return trace(&run, options, error);
}
