/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Hills of value noise. */

#include "terrain.h"

#include "random.h"
#include "shapes.h"

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

/* Eight octaves of value noise on a square of side 2. */
static vector hills_at(const void *shape, float u, float v) {
  (void)shape;
  float height = 0, amplitude = 0.35f, frequency = 3;
  for (int octave = 0; octave < 8; octave++, amplitude *= 0.48f, frequency *= 2)
    height += amplitude * value_noise(u * frequency, v * frequency);
  return (vector){2 * u - 1, height, 2 * v - 1};
}

mesh terrain_make(size_t triangles) {
  size_t cells = (size_t)sqrt((double)triangles / 2);
  shapes s = {0};
  shapes_add_surface(&s, (surface_map){hills_at, NULL}, cells, cells);
  mesh m = s.mesh;
  m.camera = (camera){{0.9f, 0.95f, 1.1f}, {0, 0.2f, 0}, {0, 1, 0}, 50};
  m.light = (vector){-1.5f, 1.6f, 0.5f};
  m.has_camera = m.has_light = 1;
  return m;
}
