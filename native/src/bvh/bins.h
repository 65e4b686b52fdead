/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The binned surface area heuristic: Wald 2007, "On fast construction of SAH-based bounding volume
 * hierarchies", with the traversal cost in the test that stops. Where there are no more fragments
 * than bins, each gets a bin of its own by its rank, and the sweep is exact. */

#pragma once

#include "bvh/span.h"

enum { MOST_BINS = 64, MOST_RANKED = 16 };

/* Which bin a doubled centroid falls into, on each axis. */
typedef struct bin_map {
  float4 origin, scale;
  float4 usable; /* mask of the axes along which centroids differ */
  uint32_t bins;
} bin_map;

typedef struct bins {
  box4 box[3][MOST_BINS];
  _Alignas(16) int32_t count[MOST_BINS][4]; /* by axis */
} bins;

/* Where each fragment of a small span stands along each axis. */
typedef struct ranks {
  _Alignas(16) int32_t rank[MOST_RANKED][4];
} ranks;

/* Bins below `plane` go left. Cost is the sum of count x area of both sides, in the units of
 * `leaf_cost`, which is the same for the undivided span. */
typedef struct split {
  uint32_t axis, plane;
  float cost, leaf_cost, area;
} split;

bin_map whittle_bin_map(box4 middles, uint32_t bins);
void whittle_bins_clear(bins *b, uint32_t count);
void whittle_bins_add(bins *b, const bin_map *map, const whittle_fragment *fragments,
                      uint32_t count);
void whittle_bins_merge(bins *into, const bins *from, uint32_t count);

/* Ranks up to MOST_RANKED fragments by their centroids, equals by their order, and puts each alone
 * into the bin of its rank. No clearing is needed before. */
void whittle_bins_rank(bins *b, ranks *r, const whittle_fragment *fragments, uint32_t count);

/* The cheapest of the planes between `bins` bins that hold `count` fragments, over the axes that
 * are `usable`; the first one among equals; false if no axis is usable. */
bool whittle_bins_split(const bins *b, uint32_t bins, float4 usable, box4 bounds, uint32_t count,
                        split *best);

/* The bounds of bins [begin, end) of an axis. */
box4 whittle_bins_bounds(const bins *b, uint32_t axis, uint32_t begin, uint32_t end);
