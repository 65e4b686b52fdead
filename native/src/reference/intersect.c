/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The oracle: every triangle against every ray in double precision, by signed volumes, no tree. */

#include "base/cpu.h"
#include "base/threads.h"
#include "scene/rays.h"
#include "scene/triangles.h"

#define NO_HIT UINT32_MAX

/* A chunk of rays in double, and the nearest hit of each so far. */
typedef struct oracle_chunk {
  double origin[3][RAY_CHUNK], direction[3][RAY_CHUNK];
  int64_t inside[RAY_CHUNK]; /* of the triangle at hand: 1 where the ray's line passes through */
  float t[RAY_CHUNK], u[RAY_CHUNK], v[RAY_CHUNK];
  uint32_t hit[RAY_CHUNK]; /* NO_HIT, or which triangle */
  ray_chunk rays;
} oracle_chunk;

typedef struct oracle {
  const whittle_scene *scene;
  const whittle_rays *rays;
  const whittle_hits *hits;
  uint32_t visibility;
  bool wide; /* the same code compiled for 4 doubles at once */
  atomic_size_t next;
} oracle;

/* d . (p x q) for the ends p, q of an edge seen from the ray's origin, as d . ((p - q) x (p + q)):
 * the edge itself is a difference of floats, which double holds, so small far triangles keep their
 * shape; and swapping p and q negates the volume exactly, so that triangles which share an edge
 * agree on its side. Twice the volume, which is a factor that cancels. */
static inline __attribute__((always_inline)) double
edge_volume(const double d[3], const float p[3], const float q[3], const double origin[3]) {
  double e[3], s[3];
  for (int axis = 0; axis < 3; axis++) {
    e[axis] = (double)p[axis] - (double)q[axis];
    s[axis] = ((double)p[axis] - origin[axis]) + ((double)q[axis] - origin[axis]);
  }
  return (d[0] * (e[1] * s[2] - e[2] * s[1]) + d[1] * (e[2] * s[0] - e[0] * s[2])) +
         d[2] * (e[0] * s[1] - e[1] * s[0]);
}

/* The weights of v0, v1 and v2 where the ray's line meets the triangle, times their sum. */
static inline __attribute__((always_inline)) void
volumes(const oracle_chunk *chunk, const triangle_record *triangle, uint32_t i, double weight[3]) {
  double origin[3], d[3];
  for (int axis = 0; axis < 3; axis++) {
    origin[axis] = chunk->origin[axis][i];
    d[axis] = chunk->direction[axis][i];
  }
  weight[0] = edge_volume(d, triangle->v2, triangle->v1, origin);
  weight[1] = edge_volume(d, triangle->v0, triangle->v2, origin);
  weight[2] = edge_volume(d, triangle->v1, triangle->v0, origin);
}

static inline __attribute__((always_inline)) int64_t mark_inside(oracle_chunk *chunk,
                                                                 const triangle_record *triangle,
                                                                 uint32_t count) {
  int64_t any = 0;
  for (uint32_t i = 0; i < count; i++) {
    double w[3];
    volumes(chunk, triangle, i, w);
    const int64_t front = (w[0] >= 0.0) & (w[1] >= 0.0) & (w[2] >= 0.0);
    const int64_t back = (w[0] <= 0.0) & (w[1] <= 0.0) & (w[2] <= 0.0);
    chunk->inside[i] = front | back;
    any |= front | back;
  }
  return any;
}

static int64_t mark_inside_narrow(oracle_chunk *chunk, const triangle_record *triangle,
                                  uint32_t count) {
  return mark_inside(chunk, triangle, count);
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) static int64_t
mark_inside_wide(oracle_chunk *chunk, const triangle_record *triangle, uint32_t count) {
  return mark_inside(chunk, triangle, count);
}
#else
#define mark_inside_wide mark_inside_narrow
#endif

/* Distance along a ray whose line passes through the triangle: n.(v0 - o) / n.d, rounded to float
 * as the answer will be, so that equal answers are ties. Replaces a farther hit. */
static void keep_nearest(const triangle_store *store, oracle_chunk *chunk,
                         const triangle_record *triangle, uint32_t index, uint32_t i) {
  double w[3], e1[3], e2[3], from[3];
  volumes(chunk, triangle, i, w);
  const double sum = (w[0] + w[1]) + w[2];
  if (sum == 0.0)
    return;
  for (int axis = 0; axis < 3; axis++) {
    e1[axis] = (double)triangle->v1[axis] - triangle->v0[axis];
    e2[axis] = (double)triangle->v2[axis] - triangle->v0[axis];
    from[axis] = triangle->v0[axis] - chunk->origin[axis][i];
  }
  double above = 0.0, along = 0.0;
  for (int axis = 0; axis < 3; axis++) {
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    const double normal = e1[next] * e2[last] - e1[last] * e2[next];
    above += normal * from[axis];
    along += normal * chunk->direction[axis][i];
  }
  const float t = (float)(above / along);
  if (!(t > chunk->rays.t_min[i] && t <= chunk->rays.t_max[i] && t <= chunk->t[i] && t < INFINITY))
    return;
  if (t == chunk->t[i] && chunk->hit[i] != NO_HIT &&
      whittle_comes_first(store, chunk->hit[i], index))
    return;
  chunk->t[i] = t;
  chunk->u[i] = (float)(w[1] / sum) + 0.0f;
  chunk->v[i] = (float)(w[2] / sum) + 0.0f;
  chunk->hit[i] = index;
}

static void test_all(const oracle *all, oracle_chunk *chunk) {
  const whittle_scene *scene = all->scene;
  const uint32_t count = chunk->rays.count;
  const triangle_store *store = &scene->triangles;
  for (uint32_t index = 0; index < scene->triangle_count; index++) {
    if (!(scene->instances[store->ids[index].instance].visibility & all->visibility))
      continue;
    const triangle_record triangle = whittle_take_triangle(store, index);
    const int64_t any = all->wide ? mark_inside_wide(chunk, &triangle, count)
                                  : mark_inside_narrow(chunk, &triangle, count);
    for (uint32_t i = 0; any && i < count; i++)
      if (chunk->inside[i])
        keep_nearest(store, chunk, &triangle, index, i);
  }
}

static void write_hits(const oracle *all, const oracle_chunk *chunk, size_t first) {
  const whittle_hits *hits = all->hits;
  for (uint32_t i = 0; i < chunk->rays.count; i++) {
    const bool hit = chunk->hit[i] != NO_HIT;
    const triangle_id id = hit ? all->scene->triangles.ids[chunk->hit[i]] : (triangle_id){0};
    const size_t ray = first + i;
    if (hits->t)
      hits->t[ray] = whittle_rays_t(&chunk->rays, i, hit ? chunk->t[i] : INFINITY);
    if (hits->instance)
      hits->instance[ray] = hit ? (int32_t)id.instance : -1;
    if (hits->triangle)
      hits->triangle[ray] = hit ? (int32_t)id.triangle : -1;
    if (hits->u)
      hits->u[ray] = hit ? chunk->u[i] : 0.0f;
    if (hits->v)
      hits->v[ray] = hit ? chunk->v[i] : 0.0f;
  }
}

static void oracle_worker(void *context, uint32_t worker, whittle_run_state *state) {
  oracle *all = context;
  oracle_chunk chunk;
  (void)worker;
  (void)state;
  for (;;) {
    const size_t first = atomic_fetch_add(&all->next, RAY_CHUNK);
    if (first >= all->rays->count)
      return;
    const size_t left = all->rays->count - first;
    whittle_rays_load(&all->scene->frame, all->rays, first,
                      left < RAY_CHUNK ? (uint32_t)left : RAY_CHUNK, &chunk.rays);
    for (uint32_t i = 0; i < chunk.rays.count; i++) {
      for (int axis = 0; axis < 3; axis++) {
        chunk.origin[axis][i] = chunk.rays.origin[axis][i];
        chunk.direction[axis][i] = chunk.rays.direction[axis][i];
      }
      chunk.t[i] = INFINITY;
      chunk.hit[i] = NO_HIT;
    }
    test_all(all, &chunk);
    write_hits(all, &chunk, first);
  }
}

whittle_status whittle_reference_intersect(const whittle_scene *scene, const whittle_rays *rays,
                                           const whittle_hits *hits,
                                           const whittle_trace_options *options,
                                           whittle_error *error) {
  whittle_status status = whittle_rays_check(rays, error);
  const int level = status ? -1 : whittle_cpu_level(error);
  if (status || level < 0)
    return status ? status : WHITTLE_UNSUPPORTED;
  status = whittle_scene_read_begin(scene, error);
  if (status)
    return status;
  oracle all = {
      scene, rays, hits, rays->visibility ? rays->visibility : WHITTLE_ALL, level >= WHITTLE_AVX2,
      0};
  const uint32_t wanted =
      options && options->threads ? options->threads : whittle_default_threads();
  const size_t chunks = rays->count / RAY_CHUNK + 1;
  whittle_run_state state = {.total = rays->count};
  status = whittle_run(chunks < wanted ? (uint32_t)chunks : wanted, oracle_worker, &all, &state,
                       NULL, error);
  whittle_scene_read_end(scene);
  return status;
}
