/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Dividing fragments in two, keeping their order on either side. */

#pragma once

#include "bvh/bins.h"

/* Which side a fragment goes to: right if its bin coordinate on `axis` is at least `plane`. */
typedef struct divider {
  float4 origin, scale, plane; /* the same value in each lane */
  uint32_t axis;
} divider;

divider whittle_divider(const bin_map *map, const split *s);

/* Writes each fragment to the end of its side and gives the bounds of their doubled centroids. */
void whittle_partition(const divider *d, const whittle_fragment *fragments, uint32_t count,
                       whittle_fragment *left, whittle_fragment *right, box4 middles[2]);
