/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Reading Wavefront .obj files. */

#ifndef BENCH_OBJ_H
#define BENCH_OBJ_H

#include "mesh.h"

/* Reads vertices and faces; polygons become fans. Comments may bring its view: see file_comment.
 * Fails with the line's number on what is malformed. */
mesh obj_read(const char *path);

#endif
