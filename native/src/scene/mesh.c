/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Meshes: checked and copied once, when they are added. */

#include "scene/mesh.h"
#include "base/memory.h"

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
  return WHITTLE_OK;
}

/* Room for `count` elements of the source, or NULL; `*failed` is set if that is for want of memory.
 */
static void *room_for(const void *source, size_t count, size_t size, bool *failed) {
  void *memory = source ? whittle_allocate(count, size) : NULL;
  *failed |= source && !memory;
  return memory;
}

whittle_status whittle_mesh_copy(mesh *m, const whittle_mesh *source, whittle_error *error) {
  memset(m, 0, sizeof *m);
  whittle_status status = check(source, error);
  if (status != WHITTLE_OK)
    return status;
  bool failed = false;
  m->vertex_count = source->vertex_count;
  m->triangle_count = source->triangle_count;
  m->normals_by_corner = source->normals && source->normals_by_corner;
  const size_t normals = m->normals_by_corner ? 3 * m->triangle_count : m->vertex_count;
  m->positions = room_for(source->positions, m->vertex_count, 3 * sizeof(float), &failed);
  m->triangles = room_for(source->triangles, m->triangle_count, 3 * sizeof(uint32_t), &failed);
  m->normals = room_for(source->normals, normals, 3 * sizeof(float), &failed);
  m->materials = room_for(source->materials, m->triangle_count, sizeof(uint32_t), &failed);
  m->used = whittle_allocate(m->vertex_count, 1);
  if (failed || !m->used)
    status = whittle_out_of_memory(error, "a mesh");
  else
    status = whittle_mesh_fill(m, source, normals, error);
  if (status != WHITTLE_OK)
    whittle_mesh_free(m);
  return status;
}
