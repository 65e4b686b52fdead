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

/* Tests of lane groups that a packet may spend for each of its rays: about what half of the rays
 * would cost alone. Beyond that its rays have too little in common. */
#define WORK_PER_RAY 24

#define VIEW_ROOM (WHITTLE_BLOCK + V_LANES)

typedef struct wide_entry {
  wide_child child;
  float front; /* where the packet or ray comes to it */
} wide_entry;

/* Four lines: a node, or seven triangles of a leaf. A loop by size would be mispredicted. */
static inline void wide_prefetch(const whittle_scene *scene, wide_child child) {
  const char *first = wide_is_leaf(child)
                          ? (const char *)whittle_rows(&scene->triangles, child.first)
                          : (const char *)&scene->wide[child.first];
  whittle_prefetch(first), whittle_prefetch(first + 64);
  whittle_prefetch(first + 128), whittle_prefetch(first + 192);
}

/* Pushes the children in `reach`, if `sorted` the farthest first; gives the new height of the
 * stack.
 */
static inline uint32_t wide_push(const whittle_scene *scene, const wide_node *node, uint32_t reach,
                                 const float front[], wide_entry *stack, uint32_t height,
                                 const bool sorted) {
  const uint32_t bottom = height;
  for (; reach; reach &= reach - 1) {
    const uint32_t i = (uint32_t)__builtin_ctz(reach);
    const wide_child child = node->child[i];
    const float at_front = front[i];
    wide_prefetch(scene, child);
    uint32_t at = height++;
    for (; sorted && at > bottom && stack[at - 1].front < at_front; at--)
      stack[at] = stack[at - 1];
    stack[at].child = child, stack[at].front = at_front;
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
    const v_mask bits = frustum_reaches(f, p->axis, p->looks_negative, low, high, &depth);
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

static inline __attribute__((always_inline)) void wide_leaf(const trace_context *context, packet *p,
                                                            uint32_t first, uint32_t count,
                                                            passed_pair *passed, const bool any,
                                                            const packet_view from) {
  for (uint32_t part = 0; part < count; part += WHITTLE_BLOCK) {
    const uint32_t left = count - part;
    wide_block(context, p, first + part, left < WHITTLE_BLOCK ? left : WHITTLE_BLOCK, passed, any,
               from);
  }
}

/* False if the packet came to no end within its budget; what it found until then holds. */
static inline __attribute__((always_inline)) bool
wide_traverse(const trace_context *context, packet *p, const bool any, const packet_view from) {
  const whittle_scene *scene = context->scene;
  wide_entry stack[WIDE_STACK];
  float front[WHITTLE_WIDTH + V_LANES];
  passed_pair passed[MOST_PAIRS];
  uint32_t height = 1;
  stack[0] = (wide_entry){.child = {0, WIDE_NODE}};
  while (height > 0 && p->alive > 0) {
    const wide_entry entry = stack[--height];
    if (entry.front > p->whole.deepest)
      continue;
    if (p->work > WORK_PER_RAY * p->count)
      return false;
    if (wide_is_leaf(entry.child)) {
      wide_leaf(context, p, entry.child.first, entry.child.count, passed, any, from);
      continue;
    }
    const wide_node *node = &scene->wide[entry.child.first];
    const v_frustum f = frustum_everywhere(&p->whole);
    uint32_t reach = wide_reach(p, &f, node, front);
    if (from == NO_VIEW)
      reach = wide_entered(p, node, reach);
    height = wide_push(scene, node, reach, front, stack, height, !any);
  }
  return true;
}

/* ---- Single rays
 * -------------------------------------------------------------------------------------- */

/* What a ray needs at every node: where the bounds that it meets first and last begin in one, and
 * itself in every lane. */
typedef struct wide_ray {
  uint32_t near[3], far[3]; /* floats into a node */
  v_float origin[3], inverse[3], t_min;
  v_float quick[3], begin[3], end[3]; /* of the quick test */
} wide_ray;

/* The quick test is bound * quick + begin: the rounding of all its steps, and the pad of all boxes
 * in the scene, are folded into `begin` and `end` as 2^-19 of what any bound may be away. `quick`
 * is the inverse direction, kept finite: axes that a ray does not move along still cull. */
#define QUICK_PAD (2.0f * WHITTLE_BOX_PAD)
#define QUICK_MOST 0x1p60f

static inline void wide_ray_load(const single_ray *ray, wide_ray *w) {
  const uint32_t low = offsetof(wide_node, low) / sizeof(float);
  const uint32_t high = offsetof(wide_node, high) / sizeof(float);
  const float *o = ray->exact.origin;
  const float away = s_max(s_max(s_abs(o[0]), s_abs(o[1])), s_abs(o[2])) + 1.0f;
  w->t_min = v_set(ray->exact.t_min);
  for (int i = 0; i < 3; i++) {
    const uint32_t axis = WHITTLE_WIDTH * (uint32_t)ray->exact.axis[i];
    const float inverse = ray->exact.inverse[i];
    const bool negative = inverse < 0.0f;
    const float quick = s_max(s_min(inverse, QUICK_MOST), -QUICK_MOST);
    const float room = away * s_abs(quick) * (QUICK_PAD - WHITTLE_BOX_PAD + WHITTLE_NODE_PAD);
    w->near[i] = (negative ? high : low) + axis, w->far[i] = (negative ? low : high) + axis;
    w->origin[i] = v_set(o[i]), w->inverse[i] = v_set(inverse), w->quick[i] = v_set(quick);
    w->begin[i] = v_set(-(o[i] * quick) - room), w->end[i] = v_set(-(o[i] * quick) + room);
  }
}

/* The children that a ray enters before its nearest hit, and where: s_slab, a child in each lane.
 */
static inline uint32_t wide_fine_reach(const wide_ray *ray, float best, const wide_node *node,
                                       float front[]) {
  const float *numbers = (const float *)node;
  uint32_t found = 0;
  for (uint32_t i = 0; i < WHITTLE_WIDTH; i += WIDE_LANES) {
    v_float near = ray->t_min, far = v_set(best);
    v_float to_near[3], to_far[3], reach = v_set(0.0f);
    for (int k = 0; k < 3; k++) {
      to_near[k] = v_load(numbers + ray->near[k] + i) - ray->origin[k];
      to_far[k] = v_load(numbers + ray->far[k] + i) - ray->origin[k];
      reach = v_max(v_max(v_abs(to_near[k]), v_abs(to_far[k])), reach);
    }
    const v_float room = reach * v_set(WHITTLE_NODE_PAD);
    for (int k = 0; k < 3; k++) {
      const v_float outwards = v_copysign(room, ray->inverse[k]);
      near = v_max((to_near[k] - outwards) * ray->inverse[k], near);
      far = v_min((to_far[k] + outwards) * ray->inverse[k], far);
    }
    const v_mask there = v_eq(v_load(&node->low[0][i]), v_load(&node->low[0][i]));
    found |= v_bits(v_and(there, v_le(near, far))) << i;
    v_store(front + i, near);
  }
  return found & ((1u << WHITTLE_WIDTH) - 1);
}

/* At least those of wide_fine_reach, at no later fronts. */
static inline uint32_t wide_quick_reach(const wide_ray *ray, float best, const wide_node *node,
                                        float front[]) {
  const float *numbers = (const float *)node;
  uint32_t found = 0;
  for (uint32_t i = 0; i < WHITTLE_WIDTH; i += WIDE_LANES) {
    v_float near = ray->t_min, far = v_set(best);
    for (int k = 0; k < 3; k++) {
      near = v_max(v_fused(v_load(numbers + ray->near[k] + i), ray->quick[k], ray->begin[k]), near);
      far = v_min(v_fused(v_load(numbers + ray->far[k] + i), ray->quick[k], ray->end[k]), far);
    }
    const v_mask there = v_eq(v_load(&node->low[0][i]), v_load(&node->low[0][i]));
    found |= v_bits(v_and(there, v_le(near, far))) << i;
    v_store(front + i, near);
  }
  return found & ((1u << WHITTLE_WIDTH) - 1);
}

/* Tests a leaf's triangles; true if `any` and one is hit. */
static inline __attribute__((always_inline)) bool wide_ray_leaf(const trace_context *context,
                                                                ray_stream *rays, uint32_t i,
                                                                single_ray *ray, wide_child leaf,
                                                                const bool any) {
  uint32_t tested = 0;
  for (uint32_t part = 0; part < leaf.count; part += WHITTLE_BLOCK) {
    const uint32_t left = leaf.count - part, size = left < WHITTLE_BLOCK ? left : WHITTLE_BLOCK;
    const triangle_block block = {leaf.first + part, size, 0, size};
    if (single_block(context, rays, i, ray, block, any, &tested))
      return true;
  }
  return false;
}

/* One ray; with `resume` it goes on from the hit that a packet found for it. */
static inline __attribute__((always_inline)) void wide_single(const trace_context *context,
                                                              ray_stream *rays, uint32_t i,
                                                              const bool any, const bool resume) {
  const whittle_scene *scene = context->scene;
  single_ray ray;
  wide_ray wide;
  wide_entry stack[WIDE_STACK];
  float front[WHITTLE_WIDTH + V_LANES];
  uint32_t height = 0;
  if (!resume)
    rays->record[i] = WHITTLE_NONE;
  else if (any && rays->record[i] != WHITTLE_NONE)
    return;
  if (!(rays->t[i] > rays->t_min[i]))
    return;
  single_ray_load(rays, i, &ray);
  wide_ray_load(&ray, &wide);
  wide_child child = {0, WIDE_NODE};
  for (;;) {
    if (!wide_is_leaf(child)) {
      const wide_node *node = &scene->wide[child.first];
      const uint32_t reach = __builtin_expect(child.count == WIDE_NODE, 1)
                                 ? wide_quick_reach(&wide, ray.best, node, front)
                                 : wide_fine_reach(&wide, ray.best, node, front);
      if (reach != 0 && (reach & (reach - 1)) == 0) {
        child = node->child[__builtin_ctz(reach)];
        continue;
      }
      height = wide_push(scene, node, reach, front, stack, height, !any);
    } else if (wide_ray_leaf(context, rays, i, &ray, child, any)) {
      return;
    }
    do {
      if (height == 0)
        return;
      child = stack[--height].child;
    } while (stack[height].front > ray.best);
  }
}

/* The rays of a list, or with list NULL first .. first + count, one by one. */
static inline __attribute__((always_inline)) void wide_alone(const trace_context *context,
                                                             ray_stream *rays, const uint32_t *list,
                                                             uint32_t first, uint32_t count,
                                                             const bool any, const bool resume) {
  for (uint32_t k = 0; k < count; k++)
    wide_single(context, rays, list ? list[k] : first + k, any, resume);
}
