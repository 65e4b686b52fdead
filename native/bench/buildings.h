/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Generated buildings: a pot in a stadium, and a hall with columns. */

#ifndef BENCH_BUILDINGS_H
#define BENCH_BUILDINGS_H

#include "mesh.h"

/* Few large triangles around a small dense pot of about 30,000, seen from the stands, or near. */
mesh buildings_stadium(int near);

/* About 400,000 triangles around the camera: fluted columns, arches, galleries, curtains. */
mesh buildings_atrium(void);

#endif
