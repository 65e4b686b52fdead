/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Filling bins along three axes in one pass, and sweeping them in lanes of an axis each. */

#include "bvh/bins.h"

#include <string.h>

/* Narrower than this, bins / extent would overflow. */
#define LEAST_EXTENT 1e-36f

/* From this many fragments on a second set of bins pays for itself. */
enum { ENOUGH_FOR_TWO = 256 };

bin_map whittle_bin_map(box4 middles, uint32_t bins) {
  /* The largest offset stays below `bins` in spite of three roundings of 2^-24, and above bins - 1:
   * on a usable axis the first and the last bin are never empty, nor is any index out of range. */
  const float width = (float)bins * (1.0f - 0x1p-20f);
  _Alignas(16) float extent[4], scale[4] = {0.0f, 0.0f, 0.0f, 0.0f};
  float4_store(extent, float4_sub(middles.hi, middles.lo));
  for (int axis = 0; axis < 3; axis++)
    scale[axis] = extent[axis] > LEAST_EXTENT ? width / extent[axis] : 0.0f;
  const float4 scales = float4_load(scale);
  return (bin_map){middles.lo, scales, float4_less(float4_all(0.0f), scales), bins};
}

void whittle_bins_clear(bins *b, uint32_t count) {
  const box4 empty = box4_empty();
  for (int axis = 0; axis < 3; axis++)
    for (uint32_t i = 0; i < count; i++)
      b->box[axis][i] = empty;
  memset(b->count, 0, count * sizeof *b->count);
}

static inline void add(bins *b, const bin_map *map, const whittle_fragment *fragment) {
  const box4 box = fragment_box(fragment);
  _Alignas(16) int32_t bin[4];
  float4_truncate(float4_mul(float4_sub(box4_middle(box), map->origin), map->scale), bin);
  for (int axis = 0; axis < 3; axis++) {
    box4 *into = &b->box[axis][bin[axis]];
    *into = box4_union(*into, box);
    b->count[bin[axis]][axis]++;
  }
}

/* Neighbours in the list are neighbours in space: they would wait for each other at the same bin.
 */
static void add_in_two_streams(bins *b, const bin_map *map, const whittle_fragment *fragments,
                               uint32_t half) {
  bins second;
  whittle_bins_clear(&second, map->bins);
  for (uint32_t i = 0; i < half; i++) {
    add(b, map, &fragments[i]);
    add(&second, map, &fragments[half + i]);
  }
  whittle_bins_merge(b, &second, map->bins);
}

void whittle_bins_add(bins *b, const bin_map *map, const whittle_fragment *fragments,
                      uint32_t count) {
  uint32_t done = 0;
  if (count >= ENOUGH_FOR_TWO) {
    add_in_two_streams(b, map, fragments, count / 2);
    done = count / 2 * 2;
  }
  for (uint32_t i = done; i < count; i++)
    add(b, map, &fragments[i]);
}

void whittle_bins_rank(bins *b, ranks *r, const whittle_fragment *fragments, uint32_t count) {
  float4 middle[MOST_RANKED];
  int4 rank[MOST_RANKED];
  for (uint32_t i = 0; i < count; i++) {
    middle[i] = box4_middle(fragment_box(&fragments[i]));
    rank[i] = int4_zero();
    /* A mask is -1 where it is set. */
    for (uint32_t j = 0; j < i; j++) {
      const int4 after = int4_mask(float4_less(middle[i], middle[j]));
      rank[j] = int4_sub(rank[j], after);
      rank[i] = int4_add(rank[i], int4_add(int4_all(1), after));
    }
  }
  for (uint32_t i = 0; i < count; i++) {
    const box4 box = fragment_box(&fragments[i]);
    int4_store(r->rank[i], rank[i]);
    int4_store(b->count[i], int4_all(1));
    for (int axis = 0; axis < 3; axis++)
      b->box[axis][r->rank[i][axis]] = box;
  }
}

void whittle_bins_merge(bins *into, const bins *from, uint32_t count) {
  for (uint32_t i = 0; i < count; i++)
    for (int axis = 0; axis < 3; axis++) {
      into->box[axis][i] = box4_union(into->box[axis][i], from->box[axis][i]);
      into->count[i][axis] += from->count[i][axis];
    }
}

box4 whittle_bins_bounds(const bins *b, uint32_t axis, uint32_t begin, uint32_t end) {
  box4 box = b->box[axis][begin];
  for (uint32_t i = begin + 1; i < end; i++)
    box = box4_union(box, b->box[axis][i]);
  return box;
}

/* A power of two that brings the span's largest extent into [1, 2): then areas of spans of any
 * size neither overflow nor vanish beside each other. */
static float area_scale(box4 bounds) {
  _Alignas(16) float extent[4];
  float4_store(extent, float4_sub(bounds.hi, bounds.lo));
  float largest = extent[0] > extent[1] ? extent[0] : extent[1];
  largest = largest > extent[2] ? largest : extent[2];
  uint32_t bits;
  memcpy(&bits, &largest, sizeof bits);
  bits = (254u << 23) - (bits & (255u << 23));
  float scale;
  memcpy(&scale, &bits, sizeof scale);
  return scale;
}

/* Half the surface of three boxes, one in each lane. */
static inline float4 areas(const box4 box[3], float4 scale) {
  float4 side[3];
  float4_transpose3(float4_sub(box[0].hi, box[0].lo), float4_sub(box[1].hi, box[1].lo),
                    float4_sub(box[2].hi, box[2].lo), side);
  for (int i = 0; i < 3; i++)
    side[i] = float4_mul(side[i], scale);
  return float4_add(float4_mul(side[0], side[1]),
                    float4_mul(side[2], float4_add(side[0], side[1])));
}

static inline void extend(box4 box[3], const bins *b, uint32_t i) {
  for (int axis = 0; axis < 3; axis++)
    box[axis] = box4_union(box[axis], b->box[axis][i]);
}

/* For each axis the least cost of a plane, and that plane. */
static void sweep(const bins *b, uint32_t bins, float4 scale, float4 *least, float4 *plane) {
  const box4 empty = box4_empty();
  float4 right_cost[MOST_BINS];
  box4 box[3] = {empty, empty, empty};
  int4 inside = int4_zero();
  for (uint32_t i = bins - 1; i > 0; i--) {
    extend(box, b, i);
    inside = int4_add(inside, int4_load(b->count[i]));
    right_cost[i] = float4_mul(areas(box, scale), int4_to_float4(inside));
  }
  *least = float4_all(__builtin_inff());
  *plane = float4_all(0.0f);
  box[0] = box[1] = box[2] = empty;
  inside = int4_zero();
  for (uint32_t i = 1; i < bins; i++) {
    extend(box, b, i - 1);
    inside = int4_add(inside, int4_load(b->count[i - 1]));
    const float4 left_cost = float4_mul(areas(box, scale), int4_to_float4(inside));
    const float4 cost = float4_add(left_cost, right_cost[i]);
    const float4 better = float4_less(cost, *least);
    *least = float4_choose(better, cost, *least);
    *plane = float4_choose(better, float4_all((float)i), *plane);
  }
}

bool whittle_bins_split(const bins *b, uint32_t bins, float4 usable, box4 bounds, uint32_t count,
                        split *best) {
  const float4 scale = float4_all(area_scale(bounds));
  float4 least, plane;
  sweep(b, bins, scale, &least, &plane);
  _Alignas(16) float costs[4], planes[4], whole[4];
  float4_store(costs, float4_choose(usable, least, float4_all(__builtin_inff())));
  float4_store(planes, plane);
  const box4 all[3] = {bounds, bounds, bounds};
  float4_store(whole, areas(all, scale));
  uint32_t axis = 0;
  for (uint32_t a = 1; a < 3; a++)
    axis = costs[a] < costs[axis] ? a : axis;
  *best = (split){axis, (uint32_t)planes[axis], costs[axis], whole[0] * (float)count, whole[0]};
  return costs[axis] < __builtin_inff();
}
