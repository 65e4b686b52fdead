/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The median by radix selection: linear time, and the same whatever the order of equal centroids.
 */

#include "bvh/median.h"

#include <string.h>

enum { POLL = 1 << 16 };

/* Orders as floats do. */
static inline uint32_t key_of(const whittle_fragment *f, uint32_t axis) {
  const float middle = f->lo[axis] + f->hi[axis] + 0.0f;
  uint32_t bits;
  memcpy(&bits, &middle, sizeof bits);
  return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

static uint32_t widest_axis(box4 middles) {
  _Alignas(16) float extent[4];
  float4_store(extent, float4_sub(middles.hi, middles.lo));
  uint32_t axis = 0;
  for (uint32_t a = 1; a < 3; a++)
    axis = extent[a] > extent[axis] ? a : axis;
  return axis;
}

/* The key with `rank` keys before it in sorted order; *rank becomes its rank among its equals. */
static uint32_t select_key(const whittle_fragment *fragments, uint32_t count, uint32_t axis,
                           uint32_t *rank, whittle_run_state *state) {
  uint32_t prefix = 0, known = 0;
  for (int shift = 24; shift >= 0; shift -= 8) {
    uint32_t histogram[256] = {0};
    for (uint32_t i = 0; i < count; i++) {
      if (i % POLL == 0 && whittle_cancelled(state))
        return 0;
      const uint32_t key = key_of(&fragments[i], axis);
      histogram[key >> shift & 255] += (key & known) == prefix;
    }
    uint32_t digit = 0;
    while (*rank >= histogram[digit])
      *rank -= histogram[digit++];
    prefix |= digit << shift;
    known |= 255u << shift;
  }
  return prefix;
}

static void extend(span *s, const whittle_fragment *f) {
  const box4 box = fragment_box(f);
  const float4 middle = box4_middle(box);
  s->bounds = box4_union(s->bounds, box);
  s->middles = box4_union(s->middles, (box4){middle, middle});
}

void whittle_median(const span *s, const whittle_fragment *fragments, whittle_fragment *left,
                    whittle_fragment *right, span children[2], whittle_run_state *state) {
  const uint32_t axis = widest_axis(s->middles);
  uint32_t ties_left = s->count / 2;
  const uint32_t median = select_key(fragments, s->count, axis, &ties_left, state);
  for (int side = 0; side < 2; side++)
    children[side].bounds = children[side].middles = box4_empty();
  for (uint32_t i = 0; i < s->count; i++) {
    if (i % POLL == 0 && whittle_cancelled(state))
      return;
    const uint32_t key = key_of(&fragments[i], axis);
    const bool tie = key == median && ties_left > 0;
    const bool lower = key < median || tie;
    ties_left -= tie;
    *(lower ? left++ : right++) = fragments[i];
    extend(&children[lower ? 0 : 1], &fragments[i]);
  }
}
