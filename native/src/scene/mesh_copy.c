/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Filling a mesh: its indices checked and its vertices looked at while they pass by, in pieces that
 * threads share, for a render begins with nothing else to do. */

#include "base/memory.h"
#include "base/threads.h"
#include "scene/mesh.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { PIECES = 64, BLOCK = 4096, LARGE = 1 << 16, MOST_COPIERS = 8 };

typedef struct copying {
  const whittle_mesh *source;
  mesh *made;
  size_t normals; /* vectors */
  uint32_t pieces;
  atomic_uint next;
  atomic_int bad_index, not_finite;
} copying;

/* Piece k of so many elements of this size. */
static void copy_part(void *to, const void *from, size_t count, size_t size, uint32_t k,
                      uint32_t pieces) {
  const size_t begin = count * k / pieces, end = count * (k + 1) / pieces;
  if (to && end > begin)
    memcpy((char *)to + begin * size, (const char *)from + begin * size, (end - begin) * size);
}

/* Whether any of the numbers is an infinity or not a number: all bits of its exponent are set. */
static bool any_not_finite(const float *numbers, size_t count) {
  uint32_t found = 0;
  for (size_t i = 0; i < count; i++) {
    uint32_t bits;
    memcpy(&bits, &numbers[i], sizeof bits);
    found |= (uint32_t)((bits & 0x7f800000u) == 0x7f800000u);
  }
  return found;
}

/* Whether all of the numbers are below the limit. Below 2^31 signs tell it, four at a time. */
static bool all_below(size_t limit, const uint32_t *indices, size_t count) {
  uint32_t beyond = 0;
  if (limit && limit <= INT32_MAX) {
    const uint32_t last = (uint32_t)limit - 1;
    for (size_t i = 0; i < count; i++)
      beyond |= indices[i] | (last - indices[i]);
    return beyond <= INT32_MAX;
  }
  for (size_t i = 0; i < count; i++)
    beyond |= indices[i] >= limit;
  return !beyond;
}

/* The vertices of so many corners of triangles from `first` on; false if an index is too large. */
static bool copy_indices(const whittle_mesh *from, mesh *to, size_t first, size_t count) {
  const uint32_t *indices = from->triangles + first;
  if (!from->corners) {
    if (to->own.triangles)
      memcpy(to->own.triangles + first, indices, count * sizeof *indices);
    return all_below(from->vertex_count, indices, count);
  }
  uint32_t *copy = to->own.triangles + first;
  if (!all_below(from->corner_count, indices, count))
    return false;
  for (size_t k = 0; k < count; k++)
    copy[k] = from->corners[indices[k]];
  for (size_t k = 0; to->normals_by_corner && k < count; k++)
    memcpy(to->own.normals + 3 * (first + k), from->normals + 3 * (size_t)indices[k],
           3 * sizeof(float));
  return all_below(from->vertex_count, copy, count);
}

/* As if all vertices were finite: if not, they are marked again. Threads may write the same byte,
 * all of them 1. */
static void copy_triangles(copying *c, size_t begin, size_t end) {
  uint8_t *const used = c->made->used;
  for (size_t i = 3 * begin; i < 3 * end; i += BLOCK) {
    const size_t count = 3 * end - i < BLOCK ? 3 * end - i : BLOCK;
    if (!copy_indices(c->source, c->made, i, count)) {
      atomic_store(&c->bad_index, 1);
      return;
    }
    const uint32_t *indices = c->made->triangles + i;
    for (size_t k = 0; k < count; k++)
      if (!__atomic_load_n(&used[indices[k]], __ATOMIC_RELAXED))
        __atomic_store_n(&used[indices[k]], 1, __ATOMIC_RELAXED);
  }
}

static void copy_piece(copying *c, uint32_t k) {
  const whittle_mesh *from = c->source;
  mesh *to = c->made;
  const uint32_t pieces = c->pieces;
  mesh_memory *own = &to->own;
  copy_part(own->positions, from->positions, to->vertex_count, 3 * sizeof(float), k, pieces);
  copy_part(own->materials, from->materials, to->triangle_count, sizeof(uint32_t), k, pieces);
  if (!from->corners || !to->normals_by_corner)
    copy_part(own->normals, from->normals, c->normals, 3 * sizeof(float), k, pieces);
  const size_t begin = to->vertex_count * k / pieces, end = to->vertex_count * (k + 1) / pieces;
  if (any_not_finite(to->positions + 3 * begin, 3 * (end - begin)))
    atomic_store(&c->not_finite, 1);
  copy_triangles(c, to->triangle_count * k / pieces, to->triangle_count * (k + 1) / pieces);
}

static void copy_pieces(void *context, uint32_t worker, whittle_run_state *state) {
  (void)worker;
  (void)state;
  copying *c = context;
  for (uint32_t k = atomic_fetch_add(&c->next, 1); k < c->pieces; k = atomic_fetch_add(&c->next, 1))
    copy_piece(c, k);
}

static bool finite_vertex(const mesh *m, uint32_t vertex) {
  const float *p = m->positions + 3 * (size_t)vertex;
  return fabsf(p[0]) <= FLT_MAX && fabsf(p[1]) <= FLT_MAX && fabsf(p[2]) <= FLT_MAX;
}

static void mark_corners_of_finite(mesh *m) {
  memset(m->used, 0, m->vertex_count);
  for (size_t i = 0; i < m->triangle_count; i++) {
    const uint32_t *corner = m->triangles + 3 * i;
    if (finite_vertex(m, corner[0]) && finite_vertex(m, corner[1]) && finite_vertex(m, corner[2]))
      for (int k = 0; k < 3; k++)
        m->used[corner[k]] = 1;
  }
}

static whittle_status name_bad_corner(const whittle_mesh *source, size_t i, whittle_error *error) {
  const uint32_t corner = source->triangles[i];
  if (corner >= source->corner_count)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "triangles",
                        "Triangle %zu names corner %u, but there are %zu, counted from 0.", i / 3,
                        corner, source->corner_count);
  return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "corners",
                      "Corner %u names vertex %u, but the mesh has %zu vertices, counted from 0.",
                      corner, source->corners[corner], source->vertex_count);
}

static bool is_good(const whittle_mesh *source, size_t i) {
  const uint32_t index = source->triangles[i];
  if (!source->corners)
    return index < source->vertex_count;
  return index < source->corner_count && source->corners[index] < source->vertex_count;
}

static whittle_status name_bad_index(const whittle_mesh *source, whittle_error *error) {
  size_t i = 0;
  while (is_good(source, i))
    i++;
  if (source->corners)
    return name_bad_corner(source, i, error);
  return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "triangles",
                      "Triangle %zu names vertex %u, but the mesh has %zu vertices, counted "
                      "from 0.",
                      i / 3, source->triangles[i], source->vertex_count);
}

/* Stray vertices must not stretch the scene's frame, which would cost the others precision. */
static void keep_used_if_any_is_not(mesh *m) {
  if (m->vertex_count && memchr(m->used, 0, m->vertex_count))
    return;
  whittle_release(m->used);
  m->used = NULL;
}

whittle_status whittle_mesh_fill(mesh *m, const whittle_mesh *source, size_t normals,
                                 whittle_error *error) {
  const bool large = m->triangle_count >= LARGE || m->vertex_count >= LARGE;
  copying c = {.source = source, .made = m, .normals = normals, .pieces = large ? PIECES : 1};
  memset(m->used, 0, m->vertex_count);
  const uint32_t threads = large ? whittle_default_threads() : 1;
  if (threads > 1) {
    whittle_run_state state = {0};
    const whittle_status status = whittle_run(threads < MOST_COPIERS ? threads : MOST_COPIERS,
                                              copy_pieces, &c, &state, NULL, error);
    if (status != WHITTLE_OK)
      return status;
  } else
    copy_pieces(&c, 0, NULL);
  if (atomic_load(&c.bad_index))
    return name_bad_index(source, error);
  if (atomic_load(&c.not_finite))
    mark_corners_of_finite(m);
  keep_used_if_any_is_not(m);
  return WHITTLE_OK;
}
