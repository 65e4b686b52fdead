/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The triangles of a block against a packet: which lane groups may hit which, and the exact test.
 */

/* Room around a triangle's rectangle: |slope| <= 1 along the rays, so 8 ulp of 1 cover the rounding
 * of slopes and of sheared vertices (a hit has one vertex on each side of the ray on each axis). */
#define RECTANGLE_PAD 0x1p-20f

#define VIEW_ROOM (WHITTLE_BLOCK + V_LANES)

/* The triangles of a block as a packet sees them from where its lines meet: the rectangles of their
 * vertices' slopes, a triangle in each lane. */
typedef struct block_view {
  /* x, y, z in the order of the sheared space, relative to the rays' origin if they share one. */
  float vertex[9][VIEW_ROOM];
  float low_x[VIEW_ROOM], high_x[VIEW_ROOM], low_y[VIEW_ROOM], high_y[VIEW_ROOM];
  float front[VIEW_ROOM]; /* depth of the nearest vertex, with slack */
  uint32_t seen;          /* triangles whose rectangle meets that of the packet */
  uint32_t unsure;        /* triangles that reach behind the point: they have no rectangle */
} block_view;

/* Triangles `at` to at + V_LANES of a block of `size`. */
static inline void copy_vertices(const packet *p, const float *rows, uint32_t size, uint32_t at,
                                 block_view *view) {
  const uint32_t k = (uint32_t)p->axis, x = v_next_axis[k], y = v_next_axis[x];
  const uint32_t order[3] = {x, y, k};
  for (uint32_t row = 0; row < 9; row++)
    v_store(&view->vertex[row][at], v_load(rows + (row / 3 * 3 + order[row % 3]) * size + at));
}

/* The same as seen from the packet's point. */
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
  v_store(&view->low_x[at], low_x), v_store(&view->high_x[at], high_x);
  v_store(&view->low_y[at], low_y), v_store(&view->high_y[at], high_y);
  v_store(&view->front[at], nearest);
}

static inline uint32_t groups_from(const packet *p, uint32_t g) {
  const uint32_t groups = packet_groups(p) - g;
  return (uint32_t)((1ull << (groups < V_LANES ? groups : V_LANES)) - 1);
}

/* The groups among V_LANES from `g` on whose rays pass through triangle i's rectangle, as bits. */
static inline uint32_t groups_through(const packet *p, uint32_t g, const block_view *view,
                                      uint32_t i) {
  const frustums *f = &p->groups;
  const int x = v_next_axis[p->axis], y = v_next_axis[x];
  v_mask at = v_le(v_set(view->front[i]), v_load(&f->deepest[g]));
  at = v_and(at, v_le(v_load(&f->slope_min[x][g]), v_set(view->high_x[i])));
  at = v_and(at, v_le(v_set(view->low_x[i]), v_load(&f->slope_max[x][g])));
  at = v_and(at, v_le(v_load(&f->slope_min[y][g]), v_set(view->high_y[i])));
  at = v_and(at, v_le(v_set(view->low_y[i]), v_load(&f->slope_max[y][g])));
  return v_bits(at) & groups_from(p, g);
}

/* The groups among V_LANES from `g` on whose frustums reach the triangle's box, as bits. */
static inline uint32_t groups_reaching(const packet *p, uint32_t g, const v_float low[3],
                                       const v_float high[3]) {
  const v_frustum f = frustums_load(&p->groups, g);
  v_float depth;
  return v_bits(frustum_reaches(&f, p->axis, p->looks_negative, low, high, &depth)) &
         groups_from(p, g);
}

/* Pairs of a triangle of the block and a lane group that may hit it. Lists without branches, then
 * tests: what the processor cannot foresee costs more than arithmetic. */
typedef struct pair {
  uint32_t index, at;
} pair;

#define MOST_PAIRS (WHITTLE_BLOCK * WHITTLE_MAX_PACKET / V_LANES)

static inline uint32_t add_pairs(pair *pairs, uint32_t n, uint32_t index, uint32_t g, uint64_t at) {
  for (; at; at &= at - 1)
    pairs[n++] = (pair){index, (g + (uint32_t)__builtin_ctzll(at)) * V_LANES};
  return n;
}

/* The pairs of triangle i with the groups that pass through its rectangle. */
static inline uint32_t list_seen(const packet *p, const block_view *view, uint32_t i, pair *pairs,
                                 uint32_t n) {
  const uint32_t groups = packet_groups(p);
  for (uint32_t from = 0; from < groups; from += 64) {
    const uint32_t end = groups < from + 64 ? groups : from + 64;
    uint64_t through = 0;
    for (uint32_t g = from; g < end; g += V_LANES)
      through |= (uint64_t)groups_through(p, g, view, i) << (g - from);
    n = add_pairs(pairs, n, i, from, through);
  }
  return n;
}

/* The pairs of triangle i, without a view, with the groups whose frustums reach its box. */
static inline uint32_t list_reached(const packet *p, const float *rows, uint32_t size, uint32_t i,
                                    pair *pairs, uint32_t n) {
  v_float low[3], high[3];
  for (uint32_t axis = 0; axis < 3; axis++) {
    const float a = rows[axis * size + i], b = rows[(3 + axis) * size + i];
    const float c = rows[(6 + axis) * size + i];
    low[axis] = v_set(s_min(s_min(a, b), c)), high[axis] = v_set(s_max(s_max(a, b), c));
  }
  for (uint32_t g = 0; g < packet_groups(p); g += V_LANES)
    n = add_pairs(pairs, n, i, g, groups_reaching(p, g, low, high));
  return n;
}

/* Triangle i of a block relative to the rays' origins. */
static inline __attribute__((always_inline)) v_relative block_relative(const v_ray *ray,
                                                                       const block_view *view,
                                                                       uint32_t i,
                                                                       const bool common) {
  v_relative r;
  for (uint32_t vertex = 0; vertex < 3; vertex++) {
    v_float *to[3] = {r.x, r.y, r.z};
    for (uint32_t k = 0; k < 3; k++) {
      to[k][vertex] = v_set(view->vertex[3 * vertex + k][i]);
      if (!common)
        to[k][vertex] = to[k][vertex] - ray->origin[k];
    }
  }
  return r;
}

/* A pair in which a line passes the triangle's edges. */
typedef struct passed_pair {
  v_edges edges;
  v_mask lanes;
  pair pair;
} passed_pair;

/* Keeps the pairs in which a line passes the edges; gives their number. */
static inline __attribute__((always_inline)) uint32_t
pass_edges(const packet *p, const block_view *view, const pair *pairs, uint32_t count,
           passed_pair *passed, const bool any, const bool common) {
  const packet_lanes lanes = packet_lanes_of(p);
  uint32_t kept = 0;
  for (uint32_t i = 0; i < count; i++) {
    const pair now = pairs[i];
    const v_ray ray = lanes_ray(&lanes, now.at);
    const v_relative relative = block_relative(&ray, view, now.index, common);
    passed_pair *next = &passed[kept];
    const v_mask open = any ? lanes_open(&lanes, now.at) : v_from_bits(UINT32_MAX);
    next->lanes = v_edge_test(&ray, &relative, open, &next->edges);
    next->pair = now;
    kept += v_any(next->lanes);
  }
  return kept;
}

/* Tests the pairs of a block. */
static inline __attribute__((always_inline)) void
test_pairs(const trace_context *context, packet *p, uint32_t first, uint32_t size,
           const block_view *view, const pair *pairs, uint32_t count, passed_pair *passed,
           const bool any, const bool common) {
  const float *rows = whittle_rows(&context->scene->triangles, first);
  const uint32_t kept = pass_edges(p, view, pairs, count, passed, any, common);
  const packet_lanes lanes = packet_lanes_of(p);
  uint32_t now = WHITTLE_NONE;
  bool changed = false;
  triangle_plane plane;
  p->work += 2 * count;
  for (uint32_t i = 0; i < kept; i++) {
    const pair at = passed[i].pair;
    if (at.index != now) {
      const triangle_record triangle = whittle_block_triangle(rows, size, at.index);
      plane = whittle_plane(&triangle), now = at.index;
    }
    const v_ray ray = lanes_ray(&lanes, at.at);
    const v_relative relative = block_relative(&ray, view, at.index, common);
    v_mask open = passed[i].lanes;
    if (any)
      open = v_and(open, lanes_open(&lanes, at.at));
    changed |= group_decide(context, p, at.at, &ray, &relative, &plane, &passed[i].edges, open,
                            first + at.index, any);
  }
  if (changed)
    packet_deepest(p);
}

/* The triangles of a block that a packet does not see. */
static inline uint32_t hidden(const trace_context *context, uint32_t first, uint32_t size) {
  uint32_t bits = 0;
  for (uint32_t i = 0; i < size; i++)
    bits |= (uint32_t)!sees(context, first + i) << i;
  return bits;
}

static inline __attribute__((always_inline)) void
wide_block(const trace_context *context, packet *p, uint32_t first, uint32_t size,
           passed_pair *passed, const bool any, const packet_view from) {
  const float *rows = whittle_rows(&context->scene->triangles, first);
  pair pairs[MOST_PAIRS];
  block_view view;
  uint32_t n = 0, masked = context->masked ? hidden(context, first, size) : 0;
  uint32_t rest = ((1u << size) - 1) & ~masked;
  for (uint32_t at = 0; from == NO_VIEW && at < size; at += V_LANES)
    copy_vertices(p, rows, size, at, &view);
  if (from != NO_VIEW) {
    view.seen = view.unsure = 0;
    for (uint32_t at = 0; at < size; at += V_LANES)
      view_lanes(p, rows, size, at, &view, from);
    for (uint32_t seen = view.seen & rest; seen; seen &= seen - 1)
      n = list_seen(p, &view, (uint32_t)__builtin_ctz(seen), pairs, n);
    rest &= view.unsure;
  }
  for (; rest; rest &= rest - 1)
    n = list_reached(p, rows, size, (uint32_t)__builtin_ctz(rest), pairs, n);
  test_pairs(context, p, first, size, &view, pairs, n, passed, any, from == FROM_ORIGIN);
}
