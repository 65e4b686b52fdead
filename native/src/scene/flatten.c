/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* From instances of meshes to one list of triangles in scene space. */

#include "scene/flatten.h"
#include "base/memory.h"
#include "scene/place.h"

#include <string.h>

enum { GRAIN = 8192, PLACE_UNITS = 4, RECORD_UNITS = 4 };

typedef struct flatten {
  whittle_team *team;
  const whittle_scene *scene;
  flat_scene *flat;
  double scale;
  uint32_t *kept; /* by piece of GRAIN triangles */
} flatten;

typedef struct bounding {
  const whittle_scene *scene;
  const flat_index *index;
  pthread_mutex_t lock;
  world_bounds bounds;
} bounding;

uint64_t whittle_flat_units(uint64_t triangles) {
  return (PLACE_UNITS + RECORD_UNITS) * triangles;
}

/* Which of the instances holds a rank: the last one that starts at or below it. */
static size_t holder_of(const uint64_t *first, size_t count, uint64_t rank) {
  size_t low = 0, high = count;
  while (high - low > 1) {
    const size_t middle = low + (high - low) / 2;
    if (first[middle] <= rank)
      low = middle;
    else
      high = middle;
  }
  return low;
}

static whittle_status number(const whittle_scene *scene, flat_index *index, whittle_error *error) {
  const size_t count = index->instances;
  index->first_triangle = whittle_allocate(count + 1, sizeof *index->first_triangle);
  index->first_vertex = whittle_allocate(count + 1, sizeof *index->first_vertex);
  if (!index->first_triangle || !index->first_vertex)
    return whittle_out_of_memory(error, "the list of instances");
  for (size_t i = 0; i < count; i++) {
    const instance *where = &scene->instances[index->first_instance + i];
    const mesh *m = &scene->meshes[where->mesh];
    index->first_triangle[i] = index->triangles;
    index->first_vertex[i] = index->vertices;
    index->triangles += where->removed ? 0 : m->triangle_count;
    index->vertices += where->removed ? 0 : m->vertex_count;
  }
  index->first_triangle[count] = index->triangles;
  index->first_vertex[count] = index->vertices;
  if (index->triangles > INT32_MAX)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "instances",
                        "The instances have %llu triangles together; a scene holds at most "
                        "2147483647.",
                        (unsigned long long)index->triangles);
  return WHITTLE_OK;
}

whittle_status whittle_flat_begin(const whittle_scene *scene, size_t first_instance,
                                  size_t instances, flat_scene *flat, whittle_error *error) {
  memset(flat, 0, sizeof *flat);
  flat->index.first_instance = first_instance;
  flat->index.instances = instances;
  const whittle_status status = number(scene, &flat->index, error);
  if (status != WHITTLE_OK)
    return status;
  flat->drops = whittle_allocate(instances, sizeof *flat->drops);
  if (!flat->drops)
    return whittle_out_of_memory(error, "the counts of dropped triangles");
  for (size_t i = 0; i < instances; i++) {
    atomic_init(&flat->drops[i].non_finite, 0);
    atomic_init(&flat->drops[i].zero_area, 0);
  }
  return WHITTLE_OK;
}

void whittle_flat_free(flat_scene *flat) {
  whittle_release(flat->index.first_triangle);
  whittle_release(flat->index.first_vertex);
  whittle_release(flat->vertices);
  whittle_release(flat->block);
  whittle_release(flat->drops);
  memset(flat, 0, sizeof *flat);
}

static void bound_vertices(void *context, uint64_t begin, uint64_t end) {
  bounding *b = context;
  const flat_index *index = b->index;
  const uint64_t *first = index->first_vertex;
  world_bounds bounds = WORLD_EMPTY;
  size_t i = holder_of(first, index->instances, begin);
  for (uint64_t rank = begin; rank < end; i++) {
    const instance *where = &b->scene->instances[index->first_instance + i];
    const mesh *m = &b->scene->meshes[where->mesh];
    for (; rank < end && rank < first[i + 1]; rank++) {
      const uint32_t vertex = (uint32_t)(rank - first[i]);
      double world[3];
      if ((!m->used || m->used[vertex]) && whittle_place_vertex(m, where, vertex, world))
        world_extend(&bounds, world);
    }
  }
  pthread_mutex_lock(&b->lock);
  world_unite(&b->bounds, &bounds);
  pthread_mutex_unlock(&b->lock);
}

static void place_vertices(void *context, uint64_t begin, uint64_t end) {
  const flatten *f = context;
  const flat_index *index = &f->flat->index;
  const uint64_t *first = index->first_vertex;
  size_t i = holder_of(first, index->instances, begin);
  for (uint64_t rank = begin; rank < end; i++) {
    const instance *where = &f->scene->instances[index->first_instance + i];
    const mesh *m = &f->scene->meshes[where->mesh];
    for (; rank < end && rank < first[i + 1]; rank++)
      whittle_place_in_scene(m, where, (uint32_t)(rank - first[i]), &f->flat->frame, f->scale,
                             f->flat->vertices + 3 * rank);
  }
}

/* The three vertices of a triangle of the i-th instance. */
static inline void corners_of(const flat_scene *flat, const mesh *m, size_t i, uint32_t triangle,
                              const float *corner[3]) {
  const float *vertices = flat->vertices + 3 * flat->index.first_vertex[i];
  const uint32_t *index = m->triangles + 3 * (size_t)triangle;
  for (int k = 0; k < 3; k++)
    corner[k] = vertices + 3 * (size_t)index[k];
}

static inline void set_fragment(whittle_fragment *fragment, const float *const corner[3]) {
  for (int i = 0; i < 3; i++) {
    const float a = corner[0][i], b = corner[1][i], c = corner[2][i];
    const float lo = a < b ? a : b, hi = a < b ? b : a;
    fragment->lo[i] = lo < c ? lo : c;
    fragment->hi[i] = hi > c ? hi : c;
  }
}

static void count_drop(flat_drops *drops, placement why) {
  atomic_fetch_add_explicit(why == PLACED_NON_FINITE ? &drops->non_finite : &drops->zero_area, 1,
                            memory_order_relaxed);
}

/* Writes the good triangles of a piece to the piece's own start, packed. */
static void place_triangles(void *context, uint64_t begin, uint64_t end) {
  flatten *f = context;
  const flat_index *index = &f->flat->index;
  const uint64_t *first = index->first_triangle;
  whittle_fragment *out = f->flat->fragments + begin;
  size_t i = holder_of(first, index->instances, begin);
  for (uint64_t rank = begin; rank < end; i++) {
    const size_t number = index->first_instance + i;
    const mesh *m = &f->scene->meshes[f->scene->instances[number].mesh];
    for (; rank < end && rank < first[i + 1]; rank++) {
      const uint32_t triangle = (uint32_t)(rank - first[i]);
      const float *corner[3];
      corners_of(f->flat, m, i, triangle, corner);
      const placement result = whittle_judge_triangle(corner[0], corner[1], corner[2]);
      if (result != PLACED) {
        count_drop(&f->flat->drops[i], result);
        continue;
      }
      out->triangle = triangle;
      out->instance = (uint32_t)number;
      set_fragment(out++, corner);
    }
  }
  f->kept[begin / GRAIN] = (uint32_t)(out - (f->flat->fragments + begin));
  whittle_advance(f->team->state, PLACE_UNITS * (end - begin));
}

/* Closes the gaps that dropped triangles left. */
static void close_gaps(flatten *f) {
  uint64_t count = 0;
  const uint64_t total = f->flat->index.triangles;
  for (uint64_t begin = 0; begin < total && !whittle_cancelled(f->team->state); begin += GRAIN) {
    const uint32_t kept = f->kept[begin / GRAIN];
    if (count != begin)
      memmove(f->flat->fragments + count, f->flat->fragments + begin,
              kept * sizeof *f->flat->fragments);
    count += kept;
  }
  f->flat->count = count;
}

world_bounds whittle_flat_bounds(whittle_team *team, const whittle_scene *scene,
                                 const flat_scene *flat) {
  bounding b = {.scene = scene, .index = &flat->index, .bounds = WORLD_EMPTY};
  pthread_mutex_init(&b.lock, NULL);
  whittle_team_for(team, flat->index.vertices, GRAIN, bound_vertices, &b);
  pthread_mutex_destroy(&b.lock);
  return b.bounds;
}

whittle_status whittle_flatten(whittle_team *team, const whittle_scene *scene, flat_scene *flat,
                               whittle_error *error) {
  flatten f = {.team = team, .scene = scene, .flat = flat};
  const uint64_t total = flat->index.triangles;
  flat->block = whittle_allocate(2 * (total + 1), sizeof *flat->fragments);
  flat->vertices = whittle_allocate(flat->index.vertices, 3 * sizeof(float));
  f.kept = whittle_allocate(total / GRAIN + 1, sizeof *f.kept);
  if (!flat->block || !flat->vertices || !f.kept) {
    whittle_release(f.kept);
    return whittle_out_of_memory(error, "the triangles to build from");
  }
  flat->spare = flat->block;
  flat->fragments = flat->spare + total + 1;
  f.scale = ldexp(1.0, -flat->frame.exponent);
  whittle_team_for(team, flat->index.vertices, GRAIN, place_vertices, &f);
  whittle_team_for(team, total, GRAIN, place_triangles, &f);
  if (!whittle_cancelled(team->state))
    close_gaps(&f);
  whittle_release(f.kept);
  return WHITTLE_OK;
}

typedef struct triangle_writer {
  whittle_team *team;
  const whittle_scene *scene;
  const flat_scene *flat;
  triangle_store *store;
} triangle_writer;

static void write_triangles(void *context, uint64_t begin, uint64_t end) {
  const triangle_writer *w = context;
  for (uint64_t i = begin; i < end; i++) {
    const whittle_fragment *fragment = &w->flat->fragments[i];
    const instance *where = &w->scene->instances[fragment->instance];
    const size_t holder = fragment->instance - w->flat->index.first_instance;
    const float *corner[3];
    corners_of(w->flat, &w->scene->meshes[where->mesh], holder, fragment->triangle, corner);
    const uint32_t index = w->store->places[i] >> 4, size = w->store->places[i] & 15;
    float *out = w->store->rows + 9 * (i - index) + index;
    for (uint32_t k = 0; k < 9; k++)
      out[k * size] = corner[k / 3][k % 3];
    w->store->ids[i] = (triangle_id){fragment->instance, fragment->triangle};
  }
  whittle_advance(w->team->state, RECORD_UNITS * (end - begin));
}

void whittle_flat_triangles(whittle_team *team, const whittle_scene *scene, const flat_scene *flat,
                            triangle_store *store) {
  triangle_writer w = {team, scene, flat, store};
  whittle_team_for(team, flat->count, GRAIN, write_triangles, &w);
}
