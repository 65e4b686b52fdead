/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* From flattened instances to a tree that can be traced: of a whole scene or of one instance. */

#pragma once

#include "bvh/wide.h"
#include "scene/flatten.h"
#include "scene/triangles.h"

/* Numbers in nodes count from the first of each array. */
typedef struct grown_tree {
  whittle_bvh bvh;
  wide_node *wide;
  uint32_t wide_count;
  triangle_store triangles;
  size_t triangle_count;
} grown_tree;

/* The binary tree, and room for the triangles. Led by one worker of the team. On failure, or once
 * the run is cancelled, what is there is whittle_grown_free's to release. */
whittle_status whittle_grow(whittle_team *team, flat_scene *flat,
                            const whittle_bvh_options *options, grown_tree *grown,
                            whittle_error *error);

/* Adds the wide tree and cuts its leaves into blocks: whittle_flat_triangles can follow. */
whittle_status whittle_grow_wide(whittle_team *team, grown_tree *grown, whittle_error *error);
void whittle_grown_free(grown_tree *grown);

/* How many units flattening and growing add to the run's `done`. */
uint64_t whittle_grow_units(uint64_t triangles);
