/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The stadium and the atrium. */

#include "buildings.h"

#include "shapes.h"

static const float pi = 3.14159265f;

/* A pot with a lid, a handle over it and a loop for a spout, 3.2 sizes high. */
static void add_pot(shapes *s, vector foot, float size) {
  static const float profile[][2] = {{0, 0},        {1.4f, 0},     {1.8f, 0.5f},   {2, 1},
                                     {1.9f, 1.5f},  {1.6f, 2},     {1.35f, 2.35f}, {1.2f, 2.45f},
                                     {0.3f, 2.75f}, {0.2f, 2.85f}, {0.35f, 3.05f}, {0, 3.2f}};
  lathe body = {.foot = foot, .profile = profile, .rings = 12, .size = size};
  shapes_add_lathe(s, &body, 160, 72);
  arch handle = {add(foot, (vector){0, 1.8f * size, 0}), 1.9f * size, 0.12f * size};
  shapes_add_arch(s, &handle, 96, 24);
  arch spout = {add(foot, (vector){2.3f * size, 1.3f * size, 0}), 0.6f * size, 0.2f * size};
  shapes_add_arch(s, &spout, 64, 24);
}

/* One step of the stands: a strip around an oval, from one height and distance to the next. */
typedef struct strip {
  float from[2], to[2]; /* distance from the field's edge, height */
} strip;

static vector strip_at(const void *shape, float u, float v) {
  const strip *s = shape;
  float angle = 2 * pi * u, out = s->from[0] + (s->to[0] - s->from[0]) * v;
  return (vector){(60 + out) * cosf(angle), s->from[1] + (s->to[1] - s->from[1]) * v,
                  -(40 + out) * sinf(angle)};
}

enum { TIERS = 24, SECTORS = 56 };

mesh buildings_stadium(int near) {
  shapes s = {0};
  shapes_add_quad(&s, (vector){-300, 0, -300}, (vector){0, 0, 600}, (vector){600, 0, 0});
  for (int i = 0; i < TIERS; i++) {
    float out = (float)i * 1.2f, height = 1 + (float)i * 0.8f;
    strip riser = {{out, height - 0.8f}, {out, height}};
    strip tread = {{out, height}, {out + 1.2f, height}};
    shapes_add_surface(&s, (surface_map){strip_at, &riser}, SECTORS, 1);
    shapes_add_surface(&s, (surface_map){strip_at, &tread}, SECTORS, 1);
  }
  shapes_add_box(&s, (vector){-1.5f, 0, -1}, (vector){1.5f, 0.8f, 1});
  add_pot(&s, (vector){0, 0.8f, 0}, 0.3f);
  mesh m = s.mesh;
  m.camera = near ? (camera){{1.6f, 2.3f, 2.6f}, {0, 1.2f, 0}, {0, 1, 0}, 45}
                  : (camera){{30, 19, 45}, {0, 0.5f, -4}, {0, 1, 0}, 50};
  m.light = (vector){-25, 60, 30};
  m.has_camera = m.has_light = 1;
  return m;
}

static void add_column(shapes *s, vector foot) {
  static const float profile[][2] = {{0.55f, 0},    {0.55f, 0.2f}, {0.42f, 0.3f}, {0.4f, 1},
                                     {0.38f, 2},    {0.37f, 3},    {0.36f, 4},    {0.4f, 4.6f},
                                     {0.52f, 4.7f}, {0.52f, 5}};
  lathe column = {foot, profile, 10, 1, 16, 0.12f};
  shapes_add_lathe(s, &column, 64, 44);
}

/* Cloth between two columns. */
static vector curtain_at(const void *shape, float u, float v) {
  const vector *corner = shape;
  float folds = 0.22f * sinf(u * 26 + corner->x) * (0.3f + 0.7f * v);
  float sag = 0.25f * sinf(pi * u) * (1 - v);
  return add(*corner, (vector){4 * u, -4.4f * v - sag, folds + 0.1f * sinf(9 * v + 5 * u)});
}

/* Columns, arches and every second curtain of one row; z tells which side of the hall. */
static void add_row(shapes *s, float floor, float z) {
  for (int i = 0; i < 7; i++) {
    float x = (float)i * 5 - 15;
    add_column(s, (vector){x, floor, z});
    if (i == 6)
      continue;
    arch over = {{x + 2.5f, floor + 5, z}, 2.3f, 0.28f};
    if (floor > 0)
      over.centre.y -= 1.6f;
    shapes_add_arch(s, &over, 48, 20);
    vector corner = {x + 0.5f, floor + 4.9f, z};
    if (i % 3 == 1)
      shapes_add_surface(s, (surface_map){curtain_at, &corner}, 90, 90);
  }
}

mesh buildings_atrium(void) {
  shapes s = {0};
  shapes_add_box(&s, (vector){-20, 0, -8}, (vector){20, 14, 8});
  for (int side = -1; side <= 1; side += 2) {
    float z = 4.5f * (float)side;
    add_row(&s, 0, z);
    add_row(&s, 7.8f, z);
    float low = side > 0 ? 4 : -8;
    shapes_add_box(&s, (vector){-20, 7.6f, low}, (vector){20, 7.8f, low + 4});
  }
  for (int i = 0; i < 12; i++)
    shapes_add_sphere(&s, (vector){(float)i * 3 - 16, 0.5f, i % 2 ? 2.2f : -2.2f}, 0.5f, 64, 32);
  shapes_add_box(&s, (vector){-2, 0, -1.2f}, (vector){2, 0.9f, 1.2f});
  add_pot(&s, (vector){0, 0.9f, 0}, 0.45f);
  mesh m = s.mesh;
  m.camera = (camera){{-17.5f, 2.4f, 0.9f}, {10, 4.4f, -0.6f}, {0, 1, 0}, 62};
  m.light = (vector){3, 12.5f, 1};
  m.has_camera = m.has_light = 1;
  return m;
}
