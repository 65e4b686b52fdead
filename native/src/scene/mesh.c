/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Meshes: checked and copied once, when they are added. */

#include "scene/mesh.h"
#include "base/memory.h"

#include <float.h>
#include <math.h>
#include <string.h>

void whittle_mesh_free(mesh *m) {
  whittle_release(m->positions);
  whittle_release(m->triangles);
  whittle_release(m->normals);
  whittle_release(m->materials);
  whittle_release(m->used);
  memset(m, 0, sizeof *m);
}

size_t whittle_mesh_bytes(const mesh *m) {
  const size_t normals = m->normals_by_corner ? 3 * m->triangle_count : m->vertex_count;
  return 3 * sizeof(float) * m->vertex_count + 3 * sizeof(uint32_t) * m->triangle_count +
         (m->normals ? 3 * sizeof(float) * normals : 0) +
         (m->materials ? sizeof(uint32_t) * m->triangle_count : 0) +
         (m->used ? m->vertex_count : 0);
}

static bool same(const void *a, const void *b, size_t bytes) {
  return bytes == 0 || memcmp(a, b, bytes) == 0;
}

bool whittle_mesh_same_surface(const mesh *a, const mesh *b) {
  return a->vertex_count == b->vertex_count && a->triangle_count == b->triangle_count &&
         same(a->positions, b->positions, a->vertex_count * 3 * sizeof(float)) &&
         same(a->triangles, b->triangles, a->triangle_count * 3 * sizeof(uint32_t));
}

static whittle_status check(const whittle_mesh *source, whittle_error *error) {
  if (!source)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "mesh", "The mesh is missing.");
  if (source->vertex_count > MOST_VERTICES || (source->vertex_count && !source->positions))
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "positions",
                        source->positions ? "%zu vertices: a mesh holds at most 4294967295."
                                          : "%zu vertices, but no positions.",
                        source->vertex_count);
  if (source->triangle_count > MOST_TRIANGLES || (source->triangle_count && !source->triangles))
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "triangles",
                        source->triangles ? "%zu triangles: a mesh holds at most 2147483647."
                                          : "%zu triangles, but no indices.",
                        source->triangle_count);
  for (size_t i = 0; i < 3 * source->triangle_count; i++)
    if (source->triangles[i] >= source->vertex_count)
      return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "triangles",
                          "Triangle %zu names vertex %u, but the mesh has %zu vertices, counted "
                          "from 0.",
                          i / 3, source->triangles[i], source->vertex_count);
  return WHITTLE_OK;
}

/* A copy of `count` elements, or NULL; `*failed` is set if that is for want of memory. */
static void *copy(const void *source, size_t count, size_t size, bool *failed) {
  if (!source)
    return NULL;
  void *memory = whittle_allocate(count, size);
  if (!memory)
    *failed = true;
  else if (count)
    memcpy(memory, source, count * size);
  return memory;
}

static bool finite_vertex(const mesh *m, uint32_t vertex) {
  const float *p = m->positions + 3 * (size_t)vertex;
  return fabsf(p[0]) <= FLT_MAX && fabsf(p[1]) <= FLT_MAX && fabsf(p[2]) <= FLT_MAX;
}

/* Stray vertices must not stretch the scene's frame, which would cost the others precision. */
static bool mark_used(mesh *m) {
  size_t unused = m->vertex_count;
  m->used = whittle_allocate(m->vertex_count, 1);
  if (!m->used)
    return false;
  memset(m->used, 0, m->vertex_count);
  for (size_t i = 0; i < m->triangle_count; i++) {
    const uint32_t *corner = m->triangles + 3 * i;
    if (!finite_vertex(m, corner[0]) || !finite_vertex(m, corner[1]) ||
        !finite_vertex(m, corner[2]))
      continue;
    for (int k = 0; k < 3; k++) {
      unused -= !m->used[corner[k]];
      m->used[corner[k]] = 1;
    }
  }
  if (unused == 0) {
    whittle_release(m->used);
    m->used = NULL;
  }
  return true;
}

whittle_status whittle_mesh_copy(mesh *m, const whittle_mesh *source, whittle_error *error) {
  memset(m, 0, sizeof *m);
  const whittle_status status = check(source, error);
  if (status != WHITTLE_OK)
    return status;
  bool failed = false;
  m->vertex_count = source->vertex_count;
  m->triangle_count = source->triangle_count;
  m->normals_by_corner = source->normals && source->normals_by_corner;
  const size_t normals = m->normals_by_corner ? 3 * m->triangle_count : m->vertex_count;
  m->positions = copy(source->positions, m->vertex_count, 3 * sizeof(float), &failed);
  m->triangles = copy(source->triangles, m->triangle_count, 3 * sizeof(uint32_t), &failed);
  m->normals = copy(source->normals, normals, 3 * sizeof(float), &failed);
  m->materials = copy(source->materials, m->triangle_count, sizeof(uint32_t), &failed);
  if (failed || !mark_used(m)) {
    whittle_mesh_free(m);
    return whittle_out_of_memory(error, "a mesh");
  }
  return WHITTLE_OK;
}
