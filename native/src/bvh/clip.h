/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Convex polygons in double precision, and what a box leaves of them. */

#pragma once

#include "whittle.h"

/* A triangle cut by six planes has nine corners; rounding may make it a little more ragged. */
enum { POLYGON_MOST = 16 };

typedef struct polygon {
  double at[POLYGON_MOST][3];
  uint32_t count;
} polygon;

/* A triangle of nine floats. */
polygon whittle_polygon_of(const float *corners);

/* The part of a polygon within a node's box, its faces included; count 0 if there is none. */
void whittle_polygon_clip(const polygon *whole, const whittle_node *box, polygon *inside);

double whittle_polygon_area(const polygon *p);
