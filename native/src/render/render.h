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

/* whittle_render with the state of the run in the caller's hands. */
whittle_status whittle_render_run(const whittle_scene *scene, const whittle_camera *camera,
                                  const whittle_settings *settings, const whittle_image *image,
                                  whittle_render_stats *stats, whittle_run_state *state,
                                  whittle_error *error);
