/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Generated hills. */

#ifndef BENCH_TERRAIN_H
#define BENCH_TERRAIN_H

#include "mesh.h"

/* Fractal hills of about so many triangles: the same hills for any number, only finer. */
mesh terrain_make(size_t triangles);

#endif
