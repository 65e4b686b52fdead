/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Reading .ply files. */

#ifndef BENCH_PLY_H
#define BENCH_PLY_H

#include "mesh.h"

/* Reads the vertices' x, y, z and the faces' vertex_indices of an ASCII or binary file, of either
 * byte order; polygons become fans, all else is passed over. Comments may bring its view: see
 * file_comment. Fails with a sentence on what is malformed. */
mesh ply_read(const char *path);

#endif
