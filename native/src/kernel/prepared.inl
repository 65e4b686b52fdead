/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What single rays need of themselves, worked out for a lane group of their stream at a time. */

/* The quick test of a box is bound * quick + begin: the rounding of all its steps, and the pad of
 * all boxes in the scene, are folded into `begin` and `end` as 2^-19 of what any bound may be away.
 * `quick` is the inverse direction, kept finite: axes that a ray does not move along still cull. */
#define QUICK_PAD (2.0f * WHITTLE_BOX_PAD)
#define QUICK_MOST 0x1p60f

typedef struct prepared_rays {
  uint32_t group; /* of the stream, or WHITTLE_NONE */
  uint32_t axis[V_LANES];
  uint32_t near[3][V_LANES],
      far[3][V_LANES];       /* floats into a node: its bounds met first and last */
  float inverse[3][V_LANES]; /* by x, y, z */
  float quick[3][V_LANES], begin[3][V_LANES], end[3][V_LANES];
  float sheared_origin[3][V_LANES], sheared_inverse[3][V_LANES]; /* in the sheared space's order */
  float shear_x[V_LANES], shear_y[V_LANES];
} prepared_rays;

static inline v_float by_axis(const v_mask is[2], v_float x, v_float y, v_float z) {
  return v_select(is[0], x, v_select(is[1], y, z));
}

/* Three numbers of each lane, by x, y, z, in the order of the sheared space. */
static inline void by_shear(const v_mask is[2], const v_float of[3], v_float to[3]) {
  to[0] = by_axis(is, of[1], of[2], of[0]);
  to[1] = by_axis(is, of[2], of[0], of[1]);
  to[2] = by_axis(is, of[0], of[1], of[2]);
}

/* whittle_dominant_axis, and what follows from it. */
static inline void prepare_shears(prepared_rays *p, const v_float o[3], const v_float d[3],
                                  const v_float inverse[3]) {
  const v_float x = v_abs(d[0]), y = v_abs(d[1]), z = v_abs(d[2]);
  const v_mask is[2] = {v_and(v_le(y, x), v_le(z, x)), v_le(z, y)};
  v_float sheared[3];
  v_storeu(p->axis, v_selectu(is[0], v_setu(0), v_selectu(is[1], v_setu(1), v_setu(2))));
  by_shear(is, o, sheared);
  for (int i = 0; i < 3; i++)
    v_store(p->sheared_origin[i], sheared[i]);
  by_shear(is, inverse, sheared);
  for (int i = 0; i < 3; i++)
    v_store(p->sheared_inverse[i], sheared[i]);
  by_shear(is, d, sheared);
  v_store(p->shear_x, sheared[0] / sheared[2]);
  v_store(p->shear_y, sheared[1] / sheared[2]);
}

/* Where in a node the bounds of axis i begin, the lower and the upper ones. */
#define NODE_LOW(i) (offsetof(wide_node, low) / sizeof(float) + WHITTLE_WIDTH * (size_t)(i))
#define NODE_HIGH(i) (offsetof(wide_node, high) / sizeof(float) + WHITTLE_WIDTH * (size_t)(i))

static __attribute__((noinline)) void prepare_group(const ray_stream *rays, uint32_t group,
                                                    prepared_rays *p) {
  const float most = __builtin_inff();
  v_float o[3], d[3], inverse[3];
  for (int i = 0; i < 3; i++) {
    o[i] = v_load(rays->origin[i] + (size_t)group * V_LANES);
    d[i] = v_load(rays->direction[i] + (size_t)group * V_LANES);
  }
  const v_float away = v_max(v_max(v_abs(o[0]), v_abs(o[1])), v_abs(o[2])) + v_set(1.0f);
  const v_float share = v_set(QUICK_PAD - WHITTLE_BOX_PAD + WHITTLE_NODE_PAD);
  for (int i = 0; i < 3; i++) {
    /* + 0 turns -0 into 0, which is what a ray's class takes it for. */
    inverse[i] = v_set(1.0f) / (d[i] + v_set(0.0f));
    const v_float quick = v_max(v_min(inverse[i], v_set(QUICK_MOST)), v_set(-QUICK_MOST));
    const v_float room = away * v_abs(quick) * share, to = v_set(0.0f) - o[i] * quick;
    const v_mask negative = v_lt(inverse[i], v_set(0.0f));
    const v_uint low = v_setu((uint32_t)NODE_LOW(i)), high = v_setu((uint32_t)NODE_HIGH(i));
    v_storeu(p->near[i], v_selectu(negative, high, low));
    v_storeu(p->far[i], v_selectu(negative, low, high));
    v_store(p->inverse[i], inverse[i]), v_store(p->quick[i], quick);
    /* Where a far origin makes infinity - infinity nothing is culled. */
    v_store(p->begin[i], v_max(to - room, v_set(-most)));
    v_store(p->end[i], v_min(to + room, v_set(most)));
  }
  prepare_shears(p, o, d, inverse);
  p->group = group;
}

/* Prepares the group of ray i unless it is the one at hand. */
static inline void prepare_ray(const ray_stream *rays, uint32_t i, prepared_rays *p) {
  if (p->group != i / V_LANES)
    prepare_group(rays, i / V_LANES, p);
}
