/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The scenes of the benchmark: files and generated ones, by name. */

#ifndef BENCH_SCENES_H
#define BENCH_SCENES_H

#include "mesh.h"

/* What `scenes_load` understands, for usage texts. */
extern const char scenes_help[];

/* Makes a scene from its name: a path ending in .obj or .ply, "stadium", "stadium-near", "atrium",
 * "spheres", "terrain:N" or "slivers:N" for about N triangles; "+ground" at the end stands it on a
 * large square. */
mesh scenes_load(const char *name, float aspect);

/* What to call it in tables: the name without its folder and its ending. Free it. */
char *scenes_label(const char *name);

#endif
