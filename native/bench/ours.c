/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Building and tracing with Whittle. */

#include "ours.h"

#include "clock.h"
#include "fail.h"

#include <stdlib.h>
#include <string.h>

static void check(whittle_status status, const whittle_error *error, const char *what) {
  if (status != WHITTLE_OK)
    fail("Whittle fails to %s: %s%s%s", what, error->argument, error->argument[0] ? ": " : "",
         error->message);
}

/* Lean: as a render that counts nothing asks for it. */
static double build(ours *o, const mesh *m, unsigned threads, int lean) {
  static const double identity[16] = {[0] = 1, [5] = 1, [10] = 1, [15] = 1};
  whittle_error error;
  memset(o, 0, sizeof(*o));
  check(whittle_scene_create(&o->scene, &error), &error, "make a scene");
  whittle_mesh arrays = {.positions = m->positions,
                         .vertex_count = m->vertex_count,
                         .triangles = m->triangles,
                         .triangle_count = m->triangle_count};
  uint32_t index;
  check(whittle_scene_add_mesh(o->scene, &arrays, &index, &error), &error, "take the mesh");
  check(whittle_scene_add_instance(o->scene, index, identity, 0, WHITTLE_ALL, NULL, &error), &error,
        "place the mesh");
  whittle_build_options options = {.threads = threads, .lean = lean};
  double start = clock_seconds();
  check(whittle_scene_build(o->scene, &options, &o->stats, &error), &error, "build");
  return clock_seconds() - start;
}

double ours_build(ours *o, const mesh *m, unsigned threads) {
  return build(o, m, threads, 1);
}

uint64_t ours_bytes_to_count(const mesh *m, unsigned threads) {
  ours whole;
  build(&whole, m, threads, 0);
  const uint64_t bytes = whole.stats.bytes_binary;
  ours_release(&whole);
  return bytes;
}

void ours_release(ours *o) {
  whittle_scene_destroy(o->scene);
  o->scene = NULL;
}

static whittle_rays rays_of(const stream *s) {
  const ptrdiff_t step = sizeof(float), plane = (ptrdiff_t)(s->count * sizeof(float));
  whittle_rays rays = {.count = s->count};
  rays.origins = s->one_origin ? (whittle_array){s->origins, 0, 0, step}
                               : (whittle_array){s->origins, 0, step, plane};
  rays.directions = (whittle_array){s->directions, 0, step, plane};
  rays.t_max = (whittle_array){&s->t_max, 0, 0, 0};
  return rays;
}

void ours_trace(const ours *o, const stream *s, const hits *h, unsigned threads) {
  whittle_rays rays = rays_of(s);
  whittle_trace_options options = {.threads = threads};
  whittle_error error;
  if (s->any_hit) {
    check(whittle_occluded(o->scene, &rays, h->blocked, &options, &error), &error, "trace");
    return;
  }
  whittle_hits out = {.t = h->t, .triangle = h->triangle, .u = h->u, .v = h->v};
  check(whittle_intersect(o->scene, &rays, &out, &options, &error), &error, "trace");
}

static double mean_of(const uint32_t *counts, size_t count) {
  double sum = 0;
  for (size_t i = 0; i < count; i++)
    sum += counts[i];
  return sum / (double)count;
}

void ours_count(const mesh *m, const stream *s, unsigned threads, double *nodes,
                double *triangles) {
  ours whole;
  build(&whole, m, threads, 0);
  whittle_rays rays = rays_of(s);
  whittle_trace_options options = {.threads = threads};
  whittle_error error;
  uint32_t *counts = allocate(s->count * 2, sizeof(uint32_t));
  whittle_hits out = {.nodes = counts, .triangles = counts + s->count};
  check(whittle_intersect(whole.scene, &rays, &out, &options, &error), &error, "count");
  ours_release(&whole);
  *nodes = mean_of(counts, s->count);
  *triangles = mean_of(counts + s->count, s->count);
  free(counts);
}

const char *ours_isa(int *is_widest) {
  whittle_error error;
  const char *isa = whittle_isa(&error);
  if (!isa)
    fail("%s", error.message);
  const char *widest = isa;
  for (const char *const *each = whittle_isas(); *each; each++)
    widest = *each;
  *is_widest = strcmp(isa, widest) == 0;
  return isa;
}
