/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Dividing fragments in two without a branch on the side, which no predictor could guess. */

#include "bvh/partition.h"

divider whittle_divider(const bin_map *map, const split *s) {
  _Alignas(16) float origin[4], scale[4];
  float4_store(origin, map->origin);
  float4_store(scale, map->scale);
  return (divider){float4_all(origin[s->axis]), float4_all(scale[s->axis]),
                   float4_all((float)s->plane), s->axis};
}

/* A mask of all lanes: set for the left side. The same roundings as in the bins. */
static inline float4 goes_left(const divider *d, const whittle_fragment *f) {
  const float4 middle = float4_add(float4_all(f->lo[d->axis]), float4_all(f->hi[d->axis]));
  return float4_less(float4_mul(float4_sub(middle, d->origin), d->scale), d->plane);
}

void whittle_partition(const divider *d, const whittle_fragment *fragments, uint32_t count,
                       whittle_fragment *left, whittle_fragment *right, box4 middles[2]) {
  box4 l = box4_empty(), r = box4_empty();
  const divider own = *d; /* which the stores below cannot change */
  for (uint32_t i = 0; i < count; i++) {
    const box4 box = fragment_box(&fragments[i]);
    const float4 middle = box4_middle(box);
    const float4 mask = goes_left(&own, &fragments[i]);
    /* A masked-out middle is NaN, which min and max pass over. */
    const float4 of_left = float4_or(middle, float4_not(mask)), of_right = float4_or(middle, mask);
    l = (box4){float4_min(of_left, l.lo), float4_max(of_left, l.hi)};
    r = (box4){float4_min(of_right, r.lo), float4_max(of_right, r.hi)};
    const uintptr_t side = float4_any(mask);
    const uintptr_t both = (uintptr_t)left ^ (uintptr_t)right;
    whittle_fragment *to = (whittle_fragment *)((uintptr_t)right ^ (both & (0 - side)));
    float4_store(to->lo, box.lo);
    float4_store(to->hi, box.hi);
    left += side;
    right += 1 - side;
  }
  middles[0] = l;
  middles[1] = r;
}
