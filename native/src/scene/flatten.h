/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* From instances of meshes to one list of triangles in scene space. */

#pragma once

#include "base/team.h"
#include "bvh/bvh.h"
#include "scene/frame.h"

/* The numbering of everything that is placed: the i-th of the instances, counted from the first
 * one, holds the ranks from first_triangle[i] to below first_triangle[i + 1], and so on. Both lists
 * have one entry more than there are instances. A triangle's rank orders by (instance, triangle).
 */
typedef struct flat_index {
  size_t first_instance, instances;
  uint64_t *first_triangle, *first_vertex;
  uint64_t triangles, vertices;
} flat_index;

typedef struct flat_drops {
  atomic_uint_fast64_t non_finite, zero_area;
} flat_drops;

/* What flattening makes of some instances that follow each other. */
typedef struct flat_scene {
  flat_index index;
  scene_frame frame;
  float *vertices;             /* x, y, z in scene space by placed vertex; NaN: not finite */
  void *block;                 /* memory of the two below */
  whittle_fragment *fragments; /* behind the spare ones */
  whittle_fragment *spare;
  uint64_t count;
  flat_drops *drops; /* by instance */
} flat_scene;

whittle_status whittle_flat_begin(const whittle_scene *scene, size_t first_instance,
                                  size_t instances, flat_scene *flat, whittle_error *error);
void whittle_flat_free(flat_scene *flat);

/* Led by one worker of the team, as what follows: the bounds in world space. */
world_bounds whittle_flat_bounds(whittle_team *team, const whittle_scene *scene,
                                 const flat_scene *flat);

/* Places all triangles in `flat->frame` and drops the bad ones. */
whittle_status whittle_flatten(whittle_team *team, const whittle_scene *scene, flat_scene *flat,
                               whittle_error *error);

/* Writes the triangles of the fragments, in their order, to the places that `store` has set. */
void whittle_flat_triangles(whittle_team *team, const whittle_scene *scene, const flat_scene *flat,
                            triangle_store *store);

/* How many units these add to the run's `done`. */
uint64_t whittle_flat_units(uint64_t triangles);
