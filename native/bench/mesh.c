/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Bounds, smooth normals, default camera and light of a mesh. */

#include "mesh.h"

#include "fail.h"

#include <stdlib.h>
#include <string.h>

mesh mesh_new(size_t vertex_count, size_t triangle_count) {
  mesh m = {.vertex_count = vertex_count, .triangle_count = triangle_count};
  m.positions = allocate(vertex_count * 3, sizeof(float));
  m.triangles = allocate(triangle_count * 3, sizeof(uint32_t));
  return m;
}

void mesh_free(mesh *m) {
  free(m->positions);
  free(m->triangles);
  free(m->normals);
  memset(m, 0, sizeof(*m));
}

void mesh_bounds(const mesh *m, vector *low, vector *high) {
  *low = (vector){INFINITY, INFINITY, INFINITY};
  *high = (vector){-INFINITY, -INFINITY, -INFINITY};
  for (size_t i = 0; i < m->vertex_count; i++) {
    vector p = vector_from(m->positions + i * 3);
    *low = (vector){fminf(low->x, p.x), fminf(low->y, p.y), fminf(low->z, p.z)};
    *high = (vector){fmaxf(high->x, p.x), fmaxf(high->y, p.y), fmaxf(high->z, p.z)};
  }
}

float mesh_size(const mesh *m) {
  vector low, high;
  mesh_bounds(m, &low, &high);
  return length(subtract(high, low));
}

static void choose_view(mesh *m, float aspect) {
  vector low, high;
  mesh_bounds(m, &low, &high);
  vector centre = scale(add(low, high), 0.5f);
  vector forward = normalise((vector){-0.45f, -0.35f, -0.82f});
  vector right = normalise(cross(forward, (vector){0, 1, 0}));
  vector up = cross(right, forward);
  float fov = 40, tall = tanf(fov * 3.14159265f / 360), wide = tall * aspect;
  float distance = 0;
  for (size_t i = 0; i < m->vertex_count; i++) {
    vector q = subtract(vector_from(m->positions + i * 3), centre);
    float needed = fmaxf(fabsf(dot(q, up)) / tall, fabsf(dot(q, right)) / wide) - dot(q, forward);
    distance = fmaxf(distance, needed);
  }
  distance *= 1.02f;
  m->camera = (camera){subtract(centre, scale(forward, distance)), centre, {0, 1, 0}, fov};
  m->has_camera = 1;
}

void mesh_add_ground(mesh *m) {
  vector low, high;
  mesh_bounds(m, &low, &high);
  vector centre = scale(add(low, high), 0.5f);
  float half = 2 * length(subtract(high, low));
  mesh grown = mesh_new(m->vertex_count + 4, m->triangle_count + 2);
  memcpy(grown.positions, m->positions, m->vertex_count * 3 * sizeof(float));
  memcpy(grown.triangles, m->triangles, m->triangle_count * 3 * sizeof(uint32_t));
  uint32_t first = (uint32_t)m->vertex_count;
  for (uint32_t i = 0; i < 4; i++) {
    float *p = grown.positions + (first + i) * (size_t)3;
    p[0] = centre.x + (i & 1 ? half : -half);
    p[1] = low.y;
    p[2] = centre.z + (i & 2 ? half : -half);
  }
  const uint32_t quad[6] = {first, first + 2, first + 1, first + 1, first + 2, first + 3};
  memcpy(grown.triangles + m->triangle_count * 3, quad, sizeof(quad));
  grown.camera = m->camera;
  grown.light = m->light;
  grown.has_camera = m->has_camera;
  grown.has_light = m->has_light;
  mesh_free(m);
  *m = grown;
}

static void smooth_normals(mesh *m) {
  free(m->normals);
  m->normals = allocate(m->vertex_count * 3, sizeof(float));
  for (size_t i = 0; i < m->triangle_count; i++) {
    vector a = mesh_vertex(m, i, 0);
    vector n = cross(subtract(mesh_vertex(m, i, 1), a), subtract(mesh_vertex(m, i, 2), a));
    for (unsigned corner = 0; corner < 3; corner++) {
      float *sum = m->normals + (size_t)m->triangles[i * 3 + corner] * 3;
      sum[0] += n.x;
      sum[1] += n.y;
      sum[2] += n.z;
    }
  }
  for (size_t i = 0; i < m->vertex_count; i++) {
    vector n = normalise(vector_from(m->normals + i * 3));
    memcpy(m->normals + i * 3, &n, sizeof(n));
  }
}

void mesh_complete(mesh *m, float aspect) {
  if (!m->has_camera)
    choose_view(m, aspect);
  if (!m->has_light) {
    vector low, high;
    mesh_bounds(m, &low, &high);
    vector offset = scale((vector){-0.5f, 1.1f, 0.7f}, length(subtract(high, low)));
    m->light = add(scale(add(low, high), 0.5f), offset);
    m->has_light = 1;
  }
  smooth_normals(m);
}
