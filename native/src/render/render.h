/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The parts of a render: camera, needs and the run over tiles. */

#pragma once

#include "base/threads.h"
#include "kernel/tile.h"

/* Checks a camera and turns it into rays of scene space. */
whittle_status whittle_camera_rays(const whittle_scene *scene, const whittle_camera *camera,
                                   camera_rays *rays, whittle_error *error);

/* What the scene, the settings and the wanted passes need. */
uint32_t whittle_needs(const whittle_scene *scene, const whittle_settings *settings,
                       const whittle_image *image);

bool whittle_wants_counters(const whittle_image *image);

/* Whether every triangle's material does. */
whittle_status whittle_materials_exist(const whittle_scene *scene, whittle_error *error);

/* whittle_render with the state of the run in the caller's hands, and a log of one thread's rays
 * (NULL: none), which makes the render count. */
whittle_status whittle_render_run(const whittle_scene *scene, const whittle_camera *camera,
                                  const whittle_settings *settings, const whittle_image *image,
                                  ray_log *log, whittle_render_stats *stats,
                                  whittle_run_state *state, whittle_error *error);
