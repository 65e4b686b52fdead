/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Meshes: checked once, when they are added, and copied or kept. */

#include "scene/mesh.h"
#include "base/memory.h"

#include <string.h>

void whittle_mesh_free(mesh *m) {
  whittle_release(m->own.positions);
  whittle_release(m->own.triangles);
  whittle_release(m->own.normals);
  whittle_release(m->own.materials);
  whittle_release(m->used);
  if (m->release)
    m->release(m->owner);
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

/* The arrays of `m`: room for copies, or the source's own. */
static bool provide(mesh *m, const whittle_mesh *source, size_t normals) {
  bool failed = false;
  const bool copy = !source->release, resolve = copy || source->corners;
  const size_t vector = 3 * sizeof(float), triangle = 3 * sizeof(uint32_t);
  mesh_memory *own = &m->own;
  own->positions = room_for(copy ? source->positions : NULL, m->vertex_count, vector, &failed);
  own->triangles =
      room_for(resolve ? source->triangles : NULL, m->triangle_count, triangle, &failed);
  own->normals = room_for(resolve ? source->normals : NULL, normals, vector, &failed);
  own->materials =
      room_for(copy ? source->materials : NULL, m->triangle_count, sizeof(uint32_t), &failed);
  m->positions = own->positions ? own->positions : source->positions;
  m->triangles = own->triangles ? own->triangles : source->triangles;
  m->normals = own->normals ? own->normals : source->normals;
  m->materials = own->materials ? own->materials : source->materials;
  m->used = whittle_allocate(m->vertex_count, 1);
  return !failed && m->used;
}

whittle_status whittle_mesh_take(mesh *m, const whittle_mesh *source, whittle_error *error) {
  memset(m, 0, sizeof *m);
  whittle_status status = check(source, error);
  if (status != WHITTLE_OK)
    return status;
  m->vertex_count = source->vertex_count;
  m->triangle_count = source->triangle_count;
  m->normals_by_corner = source->normals && source->normals_by_corner;
  const size_t normals = m->normals_by_corner ? 3 * m->triangle_count : m->vertex_count;
  if (!provide(m, source, normals))
    status = whittle_out_of_memory(error, "a mesh");
  else
    status = whittle_mesh_fill(m, source, normals, error);
  if (status != WHITTLE_OK) {
    whittle_mesh_free(m);
    return status;
  }
  m->release = source->release;
  m->owner = source->owner;
  return WHITTLE_OK;
}
