/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What the core measured, as Python dicts. */

#pragma once

#include "module.h"

/* What the kinds of rays are called. */
extern const char *const ray_kinds[WHITTLE_RAY_KINDS];

/* By the names of whittle_build_stats, and `dropped`. */
PyObject *stats_of_build(const whittle_scene *scene, const whittle_build_stats *stats);

/* By the names of whittle_render_stats, and `left_out`. */
PyObject *stats_of_render(const whittle_render_stats *stats);
