/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The triangles of a block as a packet sees them, and which lane groups may hit which. */

/* Room around a triangle's rectangle: |slope| <= 1 along the rays, so 8 ulp of 1 cover the rounding
 * of slopes and of sheared vertices (a hit has one vertex on each side of the ray on each axis). */
#define RECTANGLE_PAD 0x1p-20f

#define VIEW_ROOM (WHITTLE_BLOCK + V_LANES)

/* The triangles of a block as a packet sees them from where its lines meet: the rectangles of their
 * vertices' slopes, a triangle in each lane. */
typedef struct block_view {
  /* x, y, z in the order of the sheared space, relative to the rays' origin if they share one. */
  float vertex[9][VIEW_ROOM];
  uint8_t low_x[VIEW_ROOM], high_x[VIEW_ROOM], low_y[VIEW_ROOM], high_y[VIEW_ROOM]; /* in steps */
  float front[VIEW_ROOM]; /* depth of the nearest vertex, with slack */
  uint32_t seen;          /* triangles whose rectangle meets that of the packet */
  uint32_t unsure;        /* triangles that reach behind the point: they have no rectangle */
} block_view;

/* Triangles `at` to at + V_LANES of a block of `size`. */
static inline void view_lanes(const packet *p, const float *rows, uint32_t size, uint32_t at,
                              block_view *view, const packet_view from) {
  const uint32_t k = (uint32_t)p->axis, x = v_next_axis[k], y = v_next_axis[x];
  const uint32_t order[3] = {x, y, k};
  const v_float sense = v_set(p->looks_negative ? -1.0f : 1.0f), nothing = v_set(0.0f);
  v_float low_x = v_set(__builtin_inff()), high_x = v_set(-__builtin_inff());
  v_float low_y = low_x, high_y = high_x, front = low_x, back = high_x;
  for (uint32_t vertex = 0; vertex < 3; vertex++) {
    v_float to[3];
    for (uint32_t i = 0; i < 3; i++) {
      const v_float there = v_load(rows + (3 * vertex + order[i]) * size + at);
      to[i] = there - v_set(p->point[order[i]]);
      v_store(&view->vertex[3 * vertex + i][at], from == FROM_ORIGIN ? to[i] : there);
    }
    const v_float depth = to[2] * sense, inverse = v_set(1.0f) / depth;
    const v_float slope_x = to[0] * inverse, slope_y = to[1] * inverse;
    front = v_min(depth, front), back = v_max(depth, back);
    low_x = v_min(slope_x, low_x), high_x = v_max(slope_x, high_x);
    low_y = v_min(slope_y, low_y), high_y = v_max(slope_y, high_y);
  }
  const uint32_t left = size - at;
  const uint32_t there = left < V_LANES ? (1u << left) - 1 : (uint32_t)((1ull << V_LANES) - 1);
  const v_float behind = v_set(p->spread);
  view->unsure |= (there & v_bits(v_and(v_le(front, behind), v_le(nothing, back + behind)))) << at;
  const v_float pad = v_set(RECTANGLE_PAD) + behind / front;
  low_x = low_x - pad, low_y = low_y - pad, high_x = high_x + pad, high_y = high_y + pad;
  const v_float nearest = front * v_set(1.0f - FRUSTUM_SLACK) - behind;
  v_mask seen = v_and(v_lt(behind, front), v_le(nearest, v_set(p->whole.deepest)));
  seen = v_and(seen, v_and(v_le(low_x, v_set(p->whole.slope_max[x])),
                           v_le(v_set(p->whole.slope_min[x]), high_x)));
  seen = v_and(seen, v_and(v_le(low_y, v_set(p->whole.slope_max[y])),
                           v_le(v_set(p->whole.slope_min[y]), high_y)));
  view->seen |= (there & v_bits(seen)) << at;
  const group_steps *s = &p->steps;
  v_store_bytes(&view->low_x[at], to_steps(low_x, s->origin_x, s->scale_x));
  v_store_bytes(&view->high_x[at], to_steps(high_x, s->origin_x, s->scale_x));
  v_store_bytes(&view->low_y[at], to_steps(low_y, s->origin_y, s->scale_y));
  v_store_bytes(&view->high_y[at], to_steps(high_y, s->origin_y, s->scale_y));
  v_store(&view->front[at], nearest);
}

/* The groups among V_BYTES from `g` on whose rays pass through triangle i's rectangle, as bits. */
static inline uint64_t groups_through(const packet *p, uint32_t g, const block_view *view,
                                      uint32_t i) {
  const group_steps *s = &p->steps;
  v_bytes off = v_short_above(depth_step(view->front[i]), s->deepest + g);
  off = v_bytes_or(off, v_bytes_above(v_load_bytes(s->low_x + g), v_set_bytes(view->high_x[i])));
  off = v_bytes_or(off, v_bytes_above(v_set_bytes(view->low_x[i]), v_load_bytes(s->high_x + g)));
  off = v_bytes_or(off, v_bytes_above(v_load_bytes(s->low_y + g), v_set_bytes(view->high_y[i])));
  off = v_bytes_or(off, v_bytes_above(v_set_bytes(view->low_y[i]), v_load_bytes(s->high_y + g)));
  const uint32_t groups = packet_groups(p) - g;
  return v_bytes_zero(off) & (groups < 64 ? (1ull << groups) - 1 : UINT64_MAX);
}

/* The groups among V_BYTES from `g` on that may still hit something. */
static inline uint64_t groups_open(const packet *p, uint32_t g) {
  const uint32_t groups = packet_groups(p) - g;
  return v_bytes_zero(v_short_above(0, p->steps.deepest + g)) &
         (groups < 64 ? (1ull << groups) - 1 : UINT64_MAX);
}

/* Pairs of a triangle of the block and a lane group that may hit it. Lists without branches, then
 * tests: what the processor cannot foresee costs more than arithmetic. */
typedef uint32_t pair; /* at * WHITTLE_BLOCK + index */

static inline uint32_t pair_index(pair p) {
  return p % WHITTLE_BLOCK;
}

static inline uint32_t pair_at(pair p) {
  return p / WHITTLE_BLOCK;
}

#define MOST_PAIRS (WHITTLE_BLOCK * WHITTLE_MAX_PACKET / V_LANES)

/* Written four at a time, also those that are not there: how many there are is hard to foresee. */
#define PAIRS_AT_ONCE 4

static inline uint32_t add_pairs(pair *pairs, uint32_t n, uint32_t index, uint32_t g, uint64_t at) {
  const uint32_t end = n + (uint32_t)__builtin_popcountll(at);
  const pair first = g * V_LANES * WHITTLE_BLOCK + index;
  do {
    for (uint32_t i = 0; i < PAIRS_AT_ONCE; i++, at &= at - 1)
      pairs[n++] = first + (uint32_t)__builtin_ctzll(at | 1ull << 63) * (V_LANES * WHITTLE_BLOCK);
  } while (n < end);
  return end;
}
