/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Shapes that generated scenes are put together from. */

#ifndef BENCH_SHAPES_H
#define BENCH_SHAPES_H

#include "mesh.h"

/* A mesh that grows; its counts are what is in it, its capacities what fits. */
typedef struct shapes {
  mesh mesh;
  size_t vertex_capacity, triangle_capacity;
} shapes;

/* A surface over the unit square. */
typedef struct surface_map {
  vector (*at)(const void *shape, float u, float v);
  const void *shape;
} surface_map;

/* A grid of `across` x `down` cells, two triangles each; those without area are left out. */
void shapes_add_surface(shapes *s, surface_map map, size_t across, size_t down);

/* A parallelogram: two triangles. */
void shapes_add_quad(shapes *s, vector corner, vector first, vector second);

/* The six sides of a box along the axes. */
void shapes_add_box(shapes *s, vector low, vector high);

/* Rings of `radius` (y as it rises), joined by cones: what a lathe makes around the axis through
 * `foot`. The profile has `rings` pairs (radius, height); between them it is smoothed `smooth`
 * times. Flutes are grooves in the side, this deep a share of the radius. */
typedef struct lathe {
  vector foot;
  const float (*profile)[2];
  size_t rings;
  float size;   /* of the profile's unit */
  float flutes; /* how many, 0: round */
  float depth;
} lathe;
void shapes_add_lathe(shapes *s, const lathe *l, size_t around, size_t along);

/* Half a ring of a round bar: an arch from one foot to the other, seen along z. */
typedef struct arch {
  vector centre;
  float radius, thickness;
} arch;
void shapes_add_arch(shapes *s, const arch *a, size_t along, size_t around);

void shapes_add_sphere(shapes *s, vector centre, float radius, size_t around, size_t down);

#endif
