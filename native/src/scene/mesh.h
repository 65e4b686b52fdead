/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Meshes: checked once, when they are added, and copied or kept. */

#pragma once

#include "scene/scene.h"

/* Hits carry a triangle's index as int32_t. */
#define MOST_TRIANGLES ((size_t)INT32_MAX)
#define MOST_VERTICES ((size_t)UINT32_MAX)

whittle_status whittle_mesh_take(mesh *m, const whittle_mesh *source, whittle_error *error);
void whittle_mesh_free(mesh *m);

/* Part of whittle_mesh_take: fills the copies of `m`, which have their room, and checks the
 * indices; `normals` is how many there are. */
whittle_status whittle_mesh_fill(mesh *m, const whittle_mesh *source, size_t normals,
                                 whittle_error *error);

/* Whether two meshes have the same positions and triangles, bit for bit. */
bool whittle_mesh_same_surface(const mesh *a, const mesh *b);

size_t whittle_mesh_bytes(const mesh *m);
