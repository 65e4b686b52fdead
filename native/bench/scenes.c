/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Generated scenes, and the names of all scenes. */

#include "scenes.h"

#include "fail.h"
#include "obj.h"
#include "random.h"

#include <stdlib.h>
#include <string.h>

const char scenes_help[] =
    "FILE.obj, spheres, terrain:N, slivers:N (about N triangles), any with +ground behind";

static void put_vertex(mesh *m, size_t index, float x, float y, float z) {
  float *p = m->positions + index * 3;
  p[0] = x;
  p[1] = y;
  p[2] = z;
}

static void put_triangle(mesh *m, size_t index, size_t a, size_t b, size_t c) {
  uint32_t *t = m->triangles + index * 3;
  t[0] = (uint32_t)a;
  t[1] = (uint32_t)b;
  t[2] = (uint32_t)c;
}

/* Two triangles for each cell of a grid of `across` x `down` vertices from `vertex` on. */
static size_t put_grid(mesh *m, size_t triangle, size_t vertex, size_t across, size_t down) {
  for (size_t j = 0; j + 1 < down; j++)
    for (size_t i = 0; i + 1 < across; i++) {
      size_t a = vertex + j * across + i, b = a + 1, c = a + across, d = c + 1;
      put_triangle(m, triangle++, a, c, b);
      put_triangle(m, triangle++, b, c, d);
    }
  return triangle;
}

enum { SPHERES = 49, SPHERE_ACROSS = 97, SPHERE_DOWN = 49 };

static void put_sphere(mesh *m, size_t index, vector centre, float radius) {
  const float pi = 3.14159265f;
  size_t vertex = index * SPHERE_ACROSS * SPHERE_DOWN;
  for (size_t j = 0; j < SPHERE_DOWN; j++)
    for (size_t i = 0; i < SPHERE_ACROSS; i++) {
      float theta = pi * (float)j / (SPHERE_DOWN - 1);
      float phi = 2 * pi * (float)(i % (SPHERE_ACROSS - 1)) / (SPHERE_ACROSS - 1);
      float ring = j == 0 || j == SPHERE_DOWN - 1 ? 0 : radius * sinf(theta);
      put_vertex(m, vertex + j * SPHERE_ACROSS + i, centre.x + ring * cosf(phi),
                 centre.y + radius * cosf(theta), centre.z - ring * sinf(phi));
    }
  put_grid(m, index * 2 * (SPHERE_ACROSS - 1) * (SPHERE_DOWN - 1), vertex, SPHERE_ACROSS,
           SPHERE_DOWN);
}

/* 7 x 7 spheres of various sizes standing on a square floor. */
static mesh make_spheres(void) {
  size_t cells = 2 * (SPHERE_ACROSS - 1) * (SPHERE_DOWN - 1);
  mesh m = mesh_new(SPHERES * SPHERE_ACROSS * SPHERE_DOWN + 4, SPHERES * cells + 2);
  random_state state = random_seed(1);
  for (size_t i = 0; i < SPHERES; i++) {
    float radius = 0.25f + 0.22f * random_unit(&state);
    vector centre = {(float)(i % 7) - 3, radius, (float)(i / 7) - 3};
    put_sphere(&m, i, centre, radius);
  }
  size_t floor = m.vertex_count - 4;
  for (size_t i = 0; i < 4; i++)
    put_vertex(&m, floor + i, i & 1 ? 6 : -6, 0, i & 2 ? 6 : -6);
  put_grid(&m, m.triangle_count - 2, floor, 2, 2);
  m.camera = (camera){{3.4f, 3.2f, 6.2f}, {0, 0.1f, 0.4f}, {0, 1, 0}, 45};
  m.light = (vector){-4, 7, 3};
  m.has_camera = m.has_light = 1;
  return m;
}

/* A random number of a lattice point, the same for every call. */
static float lattice(int32_t x, int32_t y) {
  random_state state = random_seed(((uint64_t)(uint32_t)x << 32) | (uint32_t)y);
  return random_unit(&state);
}

static float value_noise(float x, float y) {
  float fx = floorf(x), fy = floorf(y), u = x - fx, v = y - fy;
  int32_t i = (int32_t)fx, j = (int32_t)fy;
  u = u * u * (3 - 2 * u);
  v = v * v * (3 - 2 * v);
  float low = lattice(i, j) * (1 - u) + lattice(i + 1, j) * u;
  float high = lattice(i, j + 1) * (1 - u) + lattice(i + 1, j + 1) * u;
  return low * (1 - v) + high * v;
}

/* Fractal hills: eight octaves of value noise on a square of side 2. */
static mesh make_terrain(size_t triangles) {
  size_t side = (size_t)sqrt((double)triangles / 2) + 1;
  if (side < 2)
    side = 2;
  mesh m = mesh_new(side * side, 2 * (side - 1) * (side - 1));
  for (size_t j = 0; j < side; j++)
    for (size_t i = 0; i < side; i++) {
      float x = (float)i / (float)(side - 1), z = (float)j / (float)(side - 1), height = 0;
      float amplitude = 0.35f, frequency = 3;
      for (int octave = 0; octave < 8; octave++, amplitude *= 0.48f, frequency *= 2)
        height += amplitude * value_noise(x * frequency, z * frequency);
      put_vertex(&m, j * side + i, 2 * x - 1, height, 2 * z - 1);
    }
  put_grid(&m, 0, 0, side, side);
  m.camera = (camera){{0.9f, 0.95f, 1.1f}, {0, 0.2f, 0}, {0, 1, 0}, 50};
  m.light = (vector){-1.5f, 1.6f, 0.5f};
  m.has_camera = m.has_light = 1;
  return m;
}

/* A ball of hairs a thousand times as long as wide, in all directions. */
static mesh make_slivers(size_t triangles) {
  mesh m = mesh_new(triangles * 3, triangles);
  random_state state = random_seed(2);
  for (size_t i = 0; i < triangles; i++) {
    vector start = scale(random_direction(&state), random_unit(&state));
    vector along = scale(random_direction(&state), 0.4f);
    vector across = scale(random_direction(&state), 0.0004f);
    vector end = add(start, along), side = add(start, across);
    put_vertex(&m, i * 3, start.x, start.y, start.z);
    put_vertex(&m, i * 3 + 1, end.x, end.y, end.z);
    put_vertex(&m, i * 3 + 2, side.x, side.y, side.z);
    put_triangle(&m, i, i * 3, i * 3 + 1, i * 3 + 2);
  }
  return m;
}

static int ends_with(const char *text, const char *end) {
  size_t n = strlen(text), k = strlen(end);
  return n >= k && strcmp(text + n - k, end) == 0;
}

/* The N of "kind:N", or 0 if the name is of another kind. */
static size_t count_of(const char *name, const char *kind) {
  size_t n = strlen(kind);
  if (strncmp(name, kind, n) != 0 || name[n] != ':')
    return 0;
  char *end;
  unsigned long count = strtoul(name + n + 1, &end, 10);
  if (*end != '\0' || count < 2 || count > 100000000)
    fail("%s: the number of triangles must be from 2 to 100000000", name);
  return count;
}

static mesh load_named(const char *name) {
  size_t count;
  if (ends_with(name, ".obj"))
    return obj_read(name);
  if (strcmp(name, "spheres") == 0)
    return make_spheres();
  if ((count = count_of(name, "terrain")) != 0)
    return make_terrain(count);
  if ((count = count_of(name, "slivers")) != 0)
    return make_slivers(count);
  fail("no scene is called %s; scenes are %s", name, scenes_help);
}

mesh scenes_load(const char *name, float aspect) {
  char *base = strdup(name);
  int ground = ends_with(name, "+ground");
  if (ground)
    base[strlen(base) - strlen("+ground")] = '\0';
  mesh m = load_named(base);
  free(base);
  if (ground) {
    if (!m.has_camera)
      mesh_complete(&m, aspect); /* so that the camera looks at the mesh, not at the ground */
    mesh_add_ground(&m);
  }
  mesh_complete(&m, aspect);
  return m;
}

char *scenes_label(const char *name) {
  const char *slash = strrchr(name, '/');
  char *label = strdup(slash ? slash + 1 : name);
  char *obj = strstr(label, ".obj");
  if (obj)
    memmove(obj, obj + 4, strlen(obj + 4) + 1);
  return label;
}
