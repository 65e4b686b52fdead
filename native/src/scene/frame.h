/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Scene space: chosen from the bounds of the world, and the way into it. */

#pragma once

#include "scene/scene.h"

#include <math.h>

/* A box in world space; empty while lo > hi. */
typedef struct world_bounds {
  double lo[3], hi[3];
} world_bounds;

#define WORLD_EMPTY                                                                                \
  (world_bounds) {                                                                                 \
    {INFINITY, INFINITY, INFINITY}, {                                                              \
      -INFINITY, -INFINITY, -INFINITY                                                              \
    }                                                                                              \
  }

static inline void world_extend(world_bounds *bounds, const double p[3]) {
  for (int i = 0; i < 3; i++) {
    bounds->lo[i] = p[i] < bounds->lo[i] ? p[i] : bounds->lo[i];
    bounds->hi[i] = p[i] > bounds->hi[i] ? p[i] : bounds->hi[i];
  }
}

static inline void world_unite(world_bounds *bounds, const world_bounds *other) {
  if (!(other->lo[0] <= other->hi[0]))
    return; /* the corners of an empty box are infinitely far away */
  world_extend(bounds, other->lo);
  world_extend(bounds, other->hi);
}

/* The frame of a scene with these bounds: all of it then lies in [-1, 1] on each axis. The centre
 * moves only in steps of at least the scene's extent, so that moving one object leaves the bits of
 * the others alone as long as the extent stays between the same two powers of two. */
scene_frame whittle_frame_of(const world_bounds *bounds);
