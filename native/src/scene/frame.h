/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Scene space: chosen from the bounds of the world, and the way into it. */

#pragma once

#include "scene/scene.h"

/* A box in world space; empty while lo > hi. */
typedef struct world_bounds {
  double lo[3], hi[3];
} world_bounds;

/* The frame of a scene with these bounds: all of it then lies in [-1, 1] on each axis. The centre
 * moves only in steps of at least the scene's extent, so that moving one object leaves the bits of
 * the others alone as long as the extent stays between the same two powers of two. */
scene_frame whittle_frame_of(const world_bounds *bounds);
