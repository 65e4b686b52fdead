/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The fast traversals, on the tree with eight children: packets by frustum, and single rays. */

/* A node's children are tested against the frustum of the whole packet, several at once. A packet
 * whose rays share an origin needs no test of single rays before the triangles: a triangle's
 * rectangle of slopes finds the lane groups that it covers. */

#define WIDE_LANES (V_LANES < WHITTLE_WIDTH ? V_LANES : WHITTLE_WIDTH)
#define WIDE_STACK (WHITTLE_STACK * (WHITTLE_WIDTH - 1))

/* Room around a triangle's rectangle: |slope| <= 1 along the rays, so 8 ulp of 1 cover the rounding
 * of slopes and of sheared vertices (a hit has one vertex on each side of the ray on each axis). */
#define RECTANGLE_PAD 0x1p-20f

/* Tests of lane groups that a packet may spend for each of its rays: about what a quarter of the
 * rays would cost alone. Beyond that its rays have too little in common. */
#define WORK_PER_RAY 12

typedef struct wide_entry {
  uint32_t child, count; /* as in wide_node */
  float front;           /* where the packet or ray comes to it */
} wide_entry;

/* Four lines: a node, or the first five triangles of a leaf. A loop by size would be mispredicted.
 */
static inline void wide_prefetch(const whittle_scene *scene, uint32_t child, uint32_t count) {
  const char *first =
      count ? (const char *)&scene->triangles[child] : (const char *)&scene->wide[child];
  whittle_prefetch(first), whittle_prefetch(first + 64);
  whittle_prefetch(first + 128), whittle_prefetch(first + 192);
}

/* Pushes the children in `reach`, the farthest first; gives the new height of the stack. */
static inline uint32_t wide_push(const whittle_scene *scene, const wide_node *node, uint32_t reach,
                                 const float front[], wide_entry *stack, uint32_t height) {
  const uint32_t bottom = height;
  for (; reach; reach &= reach - 1) {
    const uint32_t i = (uint32_t)__builtin_ctz(reach);
    const wide_entry entry = {node->child[i], node->count[i], front[i]};
    wide_prefetch(scene, entry.child, entry.count);
    uint32_t at = height++;
    for (; at > bottom && stack[at - 1].front < entry.front; at--)
      stack[at] = stack[at - 1];
    stack[at] = entry;
  }
  return height;
}

/* ---- Packets
 * ---------------------------------------------------------------------------------------- */

/* The children that the packet's frustum reaches, and the depths where. */
static inline uint32_t wide_reach(const packet *p, const v_frustum *f, const wide_node *node,
                                  float front[]) {
  uint32_t reach = 0;
  for (uint32_t i = 0; i < WHITTLE_WIDTH; i += WIDE_LANES) {
    v_float low[3], high[3], depth;
    for (int axis = 0; axis < 3; axis++)
      low[axis] = v_load(&node->low[axis][i]), high[axis] = v_load(&node->high[axis][i]);
    const v_mask bits = frustum_reaches(f, p->axis, p->negative[p->axis], low, high, &depth);
    reach |= v_bits(bits) << i;
    v_store(front + i, depth);
  }
  return reach & ((1u << WHITTLE_WIDTH) - 1);
}

/* Of the children in `reach` those that a ray of the packet enters. */
static inline uint32_t wide_entered(packet *p, const wide_node *node, uint32_t reach) {
  uint32_t entered = 0;
  for (; reach; reach &= reach - 1) {
    const uint32_t i = (uint32_t)__builtin_ctz(reach);
    const float low[3] = {node->low[0][i], node->low[1][i], node->low[2][i]};
    const float high[3] = {node->high[0][i], node->high[1][i], node->high[2][i]};
    for (uint32_t at = 0; at < p->count; at += V_LANES) {
      p->work++;
      if (group_enters(p, at, low, high) != 0) {
        entered |= 1u << i;
        break;
      }
    }
  }
  return entered;
}

/* The triangles of a leaf as a packet sees them from its shared origin: the rectangles of their
 * vertices' slopes, a triangle in each lane. */
typedef struct leaf_view {
  float low_x[4], high_x[4], low_y[4], high_y[4];
  float front[4];  /* depth of the nearest vertex, with slack */
  uint32_t seen;   /* triangles whose rectangle meets that of the packet */
  uint32_t unsure; /* triangles that reach behind the origin: they have no rectangle */
} leaf_view;

/* Vertex `v` of up to four triangles less the origin, by axis. */
static inline void gather_vertices(const packet *p, const triangle_record *triangles,
                                   uint32_t count, uint32_t v, f4_float by_axis[4]) {
  for (uint32_t i = 0; i < 4; i++)
    by_axis[i] = f4_load((const float *)&triangles[i < count ? i : 0] + 4 * v);
  f4_transpose(by_axis);
  for (int axis = 0; axis < 3; axis++)
    by_axis[axis] = by_axis[axis] - f4_set(p->origin[axis][0]);
}

static inline leaf_view view_leaf(const packet *p, const triangle_record *triangles,
                                  uint32_t count) {
  const int k = p->axis, x = v_next_axis[k], y = v_next_axis[x];
  const f4_float sense = f4_set(p->negative[k] ? -1.0f : 1.0f), pad = f4_set(RECTANGLE_PAD);
  f4_float low_x = f4_set(__builtin_inff()), high_x = f4_set(-__builtin_inff());
  f4_float low_y = low_x, high_y = high_x, front = low_x, back = high_x;
  for (uint32_t v = 0; v < 3; v++) {
    f4_float at[4];
    gather_vertices(p, triangles, count, v, at);
    const f4_float depth = at[k] * sense, inverse = f4_set(1.0f) / depth;
    const f4_float slope_x = at[x] * inverse, slope_y = at[y] * inverse;
    front = f4_min(depth, front), back = f4_max(depth, back);
    low_x = f4_min(slope_x, low_x), high_x = f4_max(slope_x, high_x);
    low_y = f4_min(slope_y, low_y), high_y = f4_max(slope_y, high_y);
  }
  const uint32_t lanes = (1u << count) - 1;
  low_x = low_x - pad, low_y = low_y - pad, high_x = high_x + pad, high_y = high_y + pad;
  leaf_view view = {.unsure = lanes & f4_le(front, f4_set(0.0f)) & f4_le(f4_set(0.0f), back)};
  front = front * f4_set(1.0f - FRUSTUM_SLACK);
  view.seen =
      lanes & ~f4_le(front, f4_set(0.0f)) & f4_le(front, f4_set(p->whole.deepest)) &
      f4_le(low_x, f4_set(p->whole.slope_max[x])) & f4_le(f4_set(p->whole.slope_min[x]), high_x) &
      f4_le(low_y, f4_set(p->whole.slope_max[y])) & f4_le(f4_set(p->whole.slope_min[y]), high_y);
  f4_store(view.low_x, low_x), f4_store(view.high_x, high_x);
  f4_store(view.low_y, low_y), f4_store(view.high_y, high_y);
  f4_store(view.front, front);
  return view;
}

static inline uint32_t groups_from(const packet *p, uint32_t g) {
  const uint32_t groups = packet_groups(p) - g;
  return (uint32_t)((1ull << (groups < V_LANES ? groups : V_LANES)) - 1);
}

/* The groups among V_LANES from `g` on whose rays pass through triangle i's rectangle, as bits. */
static inline uint32_t groups_through(const packet *p, uint32_t g, const leaf_view *view,
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

/* The quarters of the packet whose rays pass through triangle i's rectangle, as bits. */
static inline uint32_t quarters_through(const packet *p, const leaf_view *view, uint32_t i) {
  return f4_le(f4_load(p->quarters[0]), f4_set(view->high_x[i])) &
         f4_le(f4_set(view->low_x[i]), f4_load(p->quarters[1])) &
         f4_le(f4_load(p->quarters[2]), f4_set(view->high_y[i])) &
         f4_le(f4_set(view->low_y[i]), f4_load(p->quarters[3]));
}

/* The groups among V_LANES from `g` on whose frustums reach the triangle's box, as bits. */
static inline uint32_t groups_reaching(const packet *p, uint32_t g,
                                       const triangle_record *triangle) {
  const v_frustum f = frustums_load(&p->groups, g);
  v_float low[3], high[3], depth;
  for (int i = 0; i < 3; i++) {
    low[i] = v_set(s_min(s_min(triangle->v0[i], triangle->v1[i]), triangle->v2[i]));
    high[i] = v_set(s_max(s_max(triangle->v0[i], triangle->v1[i]), triangle->v2[i]));
  }
  return v_bits(frustum_reaches(&f, p->axis, p->negative[p->axis], low, high, &depth)) &
         groups_from(p, g);
}

/* Pairs of a triangle and a lane group that may hit it. Lists without branches, then tests: what
 * the processor cannot foresee costs more than arithmetic. */
typedef struct pair {
  uint32_t record, at;
} pair;

#define MOST_PAIRS (4 * WHITTLE_MAX_PACKET / V_LANES)

static inline uint32_t add_pairs(pair *pairs, uint32_t n, uint32_t record, uint32_t g,
                                 uint32_t at) {
  for (; at; at &= at - 1)
    pairs[n++] = (pair){record, (g + (uint32_t)__builtin_ctz(at)) * V_LANES};
  return n;
}

/* The pairs of triangle `record`: groups in its rectangle (view), or without one those whose
 * frustum reaches its box (view NULL). */
static inline uint32_t list_triangle(const trace_context *context, const packet *p, uint32_t record,
                                     const leaf_view *view, uint32_t i, pair *pairs, uint32_t n) {
  const triangle_record *triangle = &context->scene->triangles[record];
  const uint32_t groups = packet_groups(p);
  if (context->masked && !sees(context, triangle))
    return n;
  if (view == NULL) {
    for (uint32_t g = 0; g < groups; g += V_LANES)
      n = add_pairs(pairs, n, record, g, groups_reaching(p, g, triangle));
    return n;
  }
  for (uint32_t quarter = quarters_through(p, view, i); quarter; quarter &= quarter - 1) {
    const uint32_t from = (uint32_t)__builtin_ctz(quarter) * p->quarter;
    for (uint32_t g = from; g < from + p->quarter && g < groups; g += V_LANES)
      n = add_pairs(pairs, n, record, g, groups_through(p, g, view, i));
  }
  return n;
}

/* Keeps the pairs in which a line meets the triangle, then decides those. */
static inline __attribute__((always_inline)) void test_pairs(const trace_context *context,
                                                             packet *p, pair *pairs, uint32_t count,
                                                             const bool any, const bool shared) {
  uint32_t kept = 0;
  bool changed = false;
  p->work += 2 * count;
  for (uint32_t i = 0; i < count; i++) {
    const pair now = pairs[i];
    pairs[kept] = now;
    kept += group_meets(p, now.at, &context->scene->triangles[now.record], now.record, shared);
  }
  for (uint32_t i = 0; i < kept; i++)
    changed |= group_triangle(context, p, pairs[i].at, UINT32_MAX, pairs[i].record, any, shared);
  if (changed)
    packet_deepest(p);
}

static inline __attribute__((always_inline)) void wide_leaf(const trace_context *context, packet *p,
                                                            uint32_t first, uint32_t count,
                                                            const bool any, const bool shared) {
  pair pairs[MOST_PAIRS];
  uint32_t n = 0;
  for (uint32_t part = 0; part < count; part += 4) {
    const uint32_t from = first + part, size = count - part < 4 ? count - part : 4;
    uint32_t rest = (1u << size) - 1;
    if (shared) {
      const leaf_view view = view_leaf(p, &context->scene->triangles[from], size);
      rest = view.unsure;
      for (uint32_t seen = view.seen; seen; seen &= seen - 1)
        n = list_triangle(context, p, from + (uint32_t)__builtin_ctz(seen), &view,
                          (uint32_t)__builtin_ctz(seen), pairs, n);
    }
    for (; rest; rest &= rest - 1)
      n = list_triangle(context, p, from + (uint32_t)__builtin_ctz(rest), NULL, 0, pairs, n);
    test_pairs(context, p, pairs, n, any, shared);
    n = 0;
  }
}

/* False if the packet came to no end within its budget; what it found until then holds. */
static inline __attribute__((always_inline)) bool
wide_traverse(const trace_context *context, packet *p, const bool any, const bool shared) {
  const whittle_scene *scene = context->scene;
  wide_entry stack[WIDE_STACK];
  float front[WHITTLE_WIDTH + V_LANES];
  uint32_t height = 1;
  stack[0] = (wide_entry){.child = 0, .count = 0};
  while (height > 0 && p->alive > 0) {
    const wide_entry entry = stack[--height];
    if (entry.front > p->whole.deepest)
      continue;
    if (p->work > WORK_PER_RAY * p->count)
      return false;
    if (entry.count > 0) {
      wide_leaf(context, p, entry.child, entry.count, any, shared);
      continue;
    }
    const wide_node *node = &scene->wide[entry.child];
    const v_frustum f = frustum_everywhere(&p->whole);
    uint32_t reach = wide_reach(p, &f, node, front);
    if (!shared)
      reach = wide_entered(p, node, reach);
    height = wide_push(scene, node, reach, front, stack, height);
  }
  return true;
}

/* ---- Single rays
 * -------------------------------------------------------------------------------------- */

/* The children that a ray enters before its nearest hit, and where: s_slab, a child in each lane.
 */
static inline uint32_t wide_ray_reach(const single_ray *ray, const wide_node *node, float front[]) {
  const s_ray *exact = &ray->exact;
  const v_float pad = v_set(WHITTLE_NODE_PAD);
  uint32_t reach = 0;
  for (uint32_t i = 0; i < WHITTLE_WIDTH; i += WIDE_LANES) {
    v_float near = v_set(-__builtin_inff()), far = v_set(__builtin_inff());
    v_mask there = v_le(v_load(&node->low[0][i]), v_load(&node->high[0][i]));
    for (int axis = 0; axis < 3; axis++) {
      const int k = exact->axis[axis];
      const bool negative = exact->inverse[axis] < 0.0f;
      const v_float origin = v_set(exact->origin[axis]), inverse = v_set(exact->inverse[axis]);
      near =
          v_max((v_load(negative ? &node->high[k][i] : &node->low[k][i]) - origin) * inverse, near);
      far =
          v_min((v_load(negative ? &node->low[k][i] : &node->high[k][i]) - origin) * inverse, far);
    }
    near = near - v_abs(near) * pad, far = far + v_abs(far) * pad;
    there = v_and(there, v_and(v_le(near, far), v_le(near, v_set(ray->best))));
    reach |= v_bits(v_and(there, v_le(v_set(exact->t_min), far))) << i;
    v_store(front + i, near);
  }
  return reach & ((1u << WHITTLE_WIDTH) - 1);
}

/* One ray; with `resume` it goes on from the hit that a packet found for it. */
static inline __attribute__((always_inline)) void wide_single(const trace_context *context,
                                                              ray_stream *rays, uint32_t i,
                                                              const bool any, const bool resume) {
  const whittle_scene *scene = context->scene;
  single_ray ray;
  wide_entry stack[WIDE_STACK];
  float front[WHITTLE_WIDTH + V_LANES];
  uint32_t height = 1, tested = 0;
  single_ray_load(rays, i, &ray);
  if (!resume)
    rays->record[i] = WHITTLE_NONE;
  else if (rays->record[i] != WHITTLE_NONE)
    ray.best_primitive = scene->triangles[rays->record[i]].primitive;
  if (!(ray.best > ray.exact.t_min))
    return;
  stack[0] = (wide_entry){.child = 0, .count = 0, .front = -__builtin_inff()};
  while (height > 0) {
    const wide_entry entry = stack[--height];
    if (entry.front > ray.best)
      continue;
    if (entry.count > 0) {
      if (single_leaf(context, rays, i, &ray, entry.child, entry.count, any, &tested))
        return;
      continue;
    }
    const wide_node *node = &scene->wide[entry.child];
    height = wide_push(scene, node, wide_ray_reach(&ray, node, front), front, stack, height);
  }
}
