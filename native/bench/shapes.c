/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Grids over surfaces, and what is made of them. */

#include "shapes.h"

#include "fail.h"

#include <stdlib.h>
#include <string.h>

static const float pi = 3.14159265f;

/* An array of `used` elements of three numbers with room for `more`. */
static void *with_room(void *old, size_t used, size_t more, size_t *capacity) {
  if (used + more <= *capacity)
    return old;
  *capacity = 2 * *capacity > used + more ? 2 * *capacity : used + more;
  void *grown = allocate(*capacity * 3, sizeof(float));
  if (old)
    memcpy(grown, old, used * 3 * sizeof(float));
  free(old);
  return grown;
}

static void reserve(shapes *s, size_t vertices, size_t triangles) {
  mesh *m = &s->mesh;
  m->positions = with_room(m->positions, m->vertex_count, vertices, &s->vertex_capacity);
  m->triangles = with_room(m->triangles, m->triangle_count, triangles, &s->triangle_capacity);
}

static void add_vertex(mesh *m, vector p) {
  memcpy(m->positions + m->vertex_count++ * 3, &p, sizeof(p));
}

/* Leaves out what has no area, such as half of the cells at a pole. */
static void add_triangle(mesh *m, size_t a, size_t b, size_t c) {
  uint32_t *t = m->triangles + m->triangle_count * 3;
  t[0] = (uint32_t)a;
  t[1] = (uint32_t)b;
  t[2] = (uint32_t)c;
  vector corner = mesh_vertex(m, m->triangle_count, 0);
  vector n = cross(subtract(mesh_vertex(m, m->triangle_count, 1), corner),
                   subtract(mesh_vertex(m, m->triangle_count, 2), corner));
  if (dot(n, n) > 0)
    m->triangle_count++;
}

void shapes_add_surface(shapes *s, surface_map map, size_t across, size_t down) {
  mesh *m = &s->mesh;
  size_t first = m->vertex_count;
  reserve(s, (across + 1) * (down + 1), 2 * across * down);
  for (size_t j = 0; j <= down; j++)
    for (size_t i = 0; i <= across; i++)
      add_vertex(m, map.at(map.shape, (float)i / (float)across, (float)j / (float)down));
  for (size_t j = 0; j < down; j++)
    for (size_t i = 0; i < across; i++) {
      size_t a = first + j * (across + 1) + i, b = a + 1, c = a + across + 1, d = c + 1;
      add_triangle(m, a, c, b);
      add_triangle(m, b, c, d);
    }
}

typedef struct quad {
  vector corner, first, second;
} quad;

static vector quad_at(const void *shape, float u, float v) {
  const quad *q = shape;
  return add(q->corner, add(scale(q->first, u), scale(q->second, v)));
}

void shapes_add_quad(shapes *s, vector corner, vector first, vector second) {
  quad q = {corner, first, second};
  shapes_add_surface(s, (surface_map){quad_at, &q}, 1, 1);
}

void shapes_add_box(shapes *s, vector low, vector high) {
  vector x = {high.x - low.x, 0, 0}, y = {0, high.y - low.y, 0}, z = {0, 0, high.z - low.z};
  shapes_add_quad(s, low, x, y);
  shapes_add_quad(s, low, y, z);
  shapes_add_quad(s, low, z, x);
  shapes_add_quad(s, add(low, z), x, y);
  shapes_add_quad(s, add(low, x), y, z);
  shapes_add_quad(s, add(low, y), z, x);
}

/* The profile at v in [0, 1], by cubic Hermite pieces whose tangents are those of Catmull-Rom. */
static float profile_at(const lathe *l, float v, int axis) {
  float place = v * (float)(l->rings - 1);
  size_t i = (size_t)place;
  i = i + 2 > l->rings ? l->rings - 2 : i;
  float t = place - (float)i;
  float p1 = l->profile[i][axis], p2 = l->profile[i + 1][axis];
  float p0 = i > 0 ? l->profile[i - 1][axis] : p1;
  float p3 = i + 2 < l->rings ? l->profile[i + 2][axis] : p2;
  float m1 = (p2 - p0) / 2, m2 = (p3 - p1) / 2;
  return ((2 * p1 - 2 * p2 + m1 + m2) * t - 3 * p1 + 3 * p2 - 2 * m1 - m2) * t * t + m1 * t + p1;
}

static vector lathe_at(const void *shape, float u, float v) {
  const lathe *l = shape;
  float angle = u < 1 ? 2 * pi * u : 0, radius = fmaxf(0, profile_at(l, v, 0)) * l->size;
  radius *= 1 - l->depth * (0.5f - 0.5f * cosf(l->flutes * angle));
  return add(l->foot,
             (vector){radius * cosf(angle), profile_at(l, v, 1) * l->size, -radius * sinf(angle)});
}

void shapes_add_lathe(shapes *s, const lathe *l, size_t around, size_t along) {
  shapes_add_surface(s, (surface_map){lathe_at, l}, around, along);
}

static vector arch_at(const void *shape, float u, float v) {
  const arch *a = shape;
  float along = pi * u, around = 2 * pi * v, radius = a->radius + a->thickness * cosf(around);
  return add(a->centre,
             (vector){radius * cosf(along), radius * sinf(along), a->thickness * sinf(around)});
}

void shapes_add_arch(shapes *s, const arch *a, size_t along, size_t around) {
  shapes_add_surface(s, (surface_map){arch_at, a}, along, around);
}

typedef struct sphere {
  vector centre;
  float radius;
} sphere;

static vector sphere_at(const void *shape, float u, float v) {
  const sphere *s = shape;
  float phi = u < 1 ? 2 * pi * u : 0, theta = pi * v;
  float ring = v > 0 && v < 1 ? s->radius * sinf(theta) : 0;
  return add(s->centre, (vector){ring * cosf(phi), s->radius * cosf(theta), -ring * sinf(phi)});
}

void shapes_add_sphere(shapes *s, vector centre, float radius, size_t around, size_t down) {
  sphere ball = {centre, radius};
  shapes_add_surface(s, (surface_map){sphere_at, &ball}, around, down);
}
