/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What many rays of a packet that share no more than their class do at a node and in a leaf. A
 * node's children are culled with the frustum of all rays; each of those left is tested by every
 * ray and keeps the rays that enter it. */

typedef struct generic_entry {
  wide_child child;
  float front; /* where the frustum comes to it */
  uint32_t active;
} generic_entry;

/* Of the active rays those that enter child i of a node: the quick test of wide_ray.inl. */
static inline uint32_t generic_enters(const generic_packet *p, const wide_node *node, uint32_t i,
                                      uint32_t active) {
  const float *numbers = (const float *)node;
  uint32_t found = 0;
  for (uint32_t g = 0; g < GENERIC_GROUPS; g++) {
    const prepared_rays *r = &p->prepared[g];
    v_float near = v_load(p->rays.t_min + g * V_LANES), far = v_load(p->rays.t + g * V_LANES);
    for (int k = 0; k < 3; k++) {
      const v_float first = v_set(numbers[p->near[k] + i]), last = v_set(numbers[p->far[k] + i]);
      near = v_max(v_fused(first, v_load(r->quick[k]), v_load(r->begin[k])), near);
      far = v_min(v_fused(last, v_load(r->quick[k]), v_load(r->end[k])), far);
    }
    found |= v_bits(v_le(near, far)) << g * V_LANES;
  }
  return found & active;
}

/* The same for the children of a node that is small beside the scene. */
static __attribute__((noinline, cold)) uint32_t generic_enters_fine(const generic_packet *p,
                                                                    const wide_node *node,
                                                                    uint32_t i, uint32_t active) {
  const float low[3] = {node->low[0][i], node->low[1][i], node->low[2][i]};
  const float high[3] = {node->high[0][i], node->high[1][i], node->high[2][i]};
  uint32_t found = 0;
  for (uint32_t g = 0; g < GENERIC_GROUPS; g++) {
    const v_ray ray = generic_ray(p, g);
    v_float near, far;
    v_slab(&ray, low, high, WHITTLE_NODE_PAD, &near, &far);
    near = v_max(near, ray.t_min), far = v_min(far, v_load(p->rays.t + g * V_LANES));
    found |= v_bits(v_le(near, far)) << g * V_LANES;
  }
  return found & active;
}

/* Records what the lanes of a group have hit. */
static inline void generic_record(generic_packet *p, uint32_t g, v_mask hit, uint32_t record,
                                  v_float t, v_float u, v_float v, const bool any) {
  const uint32_t at = g * V_LANES;
  const ray_stream *r = &p->rays;
  v_storeu(r->record + at, v_selectu(hit, v_setu(record), v_loadu(r->record + at)));
  v_store(r->t + at, v_select(hit, t, v_load(r->t + at)));
  v_store(r->u + at, v_select(hit, u, v_load(r->u + at)));
  v_store(r->v + at, v_select(hit, v, v_load(r->v + at)));
  if (any)
    p->alive &= ~(v_bits(hit) << at);
}

/* Of the lanes tied with the nearest hit so far, those in which another triangle is the winner. */
__attribute__((noinline, cold)) static uint32_t generic_lost(const trace_context *context,
                                                             const generic_packet *p, uint32_t g,
                                                             uint32_t tied, uint32_t record) {
  uint32_t lost = 0;
  for (; tied; tied &= tied - 1) {
    const uint32_t lane = (uint32_t)__builtin_ctz(tied);
    if (!wins_tie(&context->scene->triangles, record, p->rays.record[g * V_LANES + lane]))
      lost |= 1u << lane;
  }
  return lost;
}

/* A triangle of a block and a lane group in which lines pass its edges. */
typedef struct generic_pair {
  v_edges edges;
  v_mask lanes;
  uint32_t index, group;
} generic_pair;

#define GENERIC_PAIRS (WHITTLE_BLOCK * GENERIC_GROUPS)

/* The pairs of the triangles in `reached` whose edges active rays pass; gives their number. Lists
 * first and decides later: what the processor cannot foresee costs more than arithmetic. */
static inline __attribute__((always_inline)) uint32_t
generic_pass_edges(const generic_packet *p, const float *rows, uint32_t size, uint32_t reached,
                   uint32_t active, generic_pair pairs[GENERIC_PAIRS + 1]) {
  uint32_t n = 0;
  for (; reached; reached &= reached - 1) {
    const uint32_t i = (uint32_t)__builtin_ctz(reached);
    const triangle_record triangle = whittle_block_triangle(rows, size, i);
    for (uint32_t g = 0; g < GENERIC_GROUPS; g++) {
      const v_ray ray = generic_ray(p, g);
      const v_relative relative = v_relate(&ray, &triangle);
      generic_pair *pair = &pairs[n];
      pair->lanes = v_edge_test(&ray, &relative, v_from_bits(active >> g * V_LANES), &pair->edges);
      pair->index = i, pair->group = g;
      n += v_any(pair->lanes);
    }
  }
  return n;
}

/* Decides a pair; true if a ray hits. */
static inline __attribute__((always_inline)) bool
generic_decide(const trace_context *context, generic_packet *p, const generic_pair *pair,
               const triangle_record *triangle, const triangle_plane *plane, uint32_t record,
               const bool any) {
  const uint32_t g = pair->group;
  const v_mask skipped = v_equ(v_loadu(p->rays.skip + g * V_LANES), v_setu(record));
  const v_mask open = v_andnot(pair->lanes, skipped);
  const v_ray ray = generic_ray(p, g);
  const v_relative relative = v_relate(&ray, triangle);
  const v_float best = v_load(p->rays.t + g * V_LANES);
  v_float t, u, v;
  v_mask tied;
  v_mask hit = v_decide(&ray, &relative, plane, &pair->edges, open, best, &t, &u, &v, &tied,
                        context->own_box_misses);
  const uint32_t even = v_bits(tied);
  if (__builtin_expect(even != 0, 0))
    hit = v_andnot(hit, v_from_bits(generic_lost(context, p, g, even, record)));
  if (!v_any(hit))
    return false;
  generic_record(p, g, hit, record, t, u, v, any);
  return true;
}

/* The triangles of a block that the frustum reaches, as bits. */
static inline uint32_t generic_reached(const generic_packet *p, const v_frustum *f,
                                       const float *rows, uint32_t size) {
  uint32_t reached = 0;
  for (uint32_t at = 0; at < size; at += V_LANES) {
    v_float low[3], high[3], depth;
    for (uint32_t axis = 0; axis < 3; axis++) {
      const float *row = rows + axis * size + at;
      const v_float a = v_load(row), b = v_load(row + 3 * size), c = v_load(row + 6 * size);
      low[axis] = v_min(v_min(a, b), c), high[axis] = v_max(v_max(a, b), c);
    }
    reached |= v_bits(frustum_reaches(f, p->axis, p->negative, low, high, &depth)) << at;
  }
  return reached & ((1u << size) - 1);
}

static inline __attribute__((always_inline)) void generic_leaf(const trace_context *context,
                                                               generic_packet *p,
                                                               const v_frustum *f, wide_child leaf,
                                                               uint32_t active, const bool any) {
  generic_pair pairs[GENERIC_PAIRS + 1];
  bool hits = false;
  for (uint32_t part = 0; part < leaf.count; part += WHITTLE_BLOCK) {
    const uint32_t left = leaf.count - part, size = left < WHITTLE_BLOCK ? left : WHITTLE_BLOCK;
    const uint32_t first = leaf.first + part;
    const float *rows = whittle_rows(&context->scene->triangles, first);
    const uint32_t reached = generic_reached(p, f, rows, size);
    const uint32_t n = generic_pass_edges(p, rows, size, reached, active, pairs);
    triangle_record triangle;
    triangle_plane plane;
    for (uint32_t k = 0, now = WHITTLE_NONE; k < n; k++) {
      const uint32_t i = pairs[k].index;
      if (context->masked && !sees(context, first + i))
        continue;
      if (i != now) {
        triangle = whittle_block_triangle(rows, size, i);
        plane = whittle_plane(&triangle), now = i;
      }
      hits |= generic_decide(context, p, &pairs[k], &triangle, &plane, first + i, any);
    }
  }
  if (hits)
    generic_deepest(p);
}

/* The children that the frustum reaches, and the depths where. */
static inline uint32_t generic_reach(const generic_packet *p, const v_frustum *f,
                                     const wide_node *node, float front[]) {
  uint32_t reach = 0;
  for (uint32_t i = 0; i < WHITTLE_WIDTH; i += WIDE_LANES) {
    v_float low[3], high[3], depth;
    for (int axis = 0; axis < 3; axis++)
      low[axis] = v_load(&node->low[axis][i]), high[axis] = v_load(&node->high[axis][i]);
    reach |= v_bits(frustum_reaches(f, p->axis, p->negative, low, high, &depth)) << i;
    v_store(front + i, depth);
  }
  return reach & ((1u << WHITTLE_WIDTH) - 1);
}

/* What is known of a node's children: the rays that enter them, and where the first does. */
typedef struct generic_children {
  float front[WHITTLE_WIDTH + V_LANES];
  uint32_t active[WHITTLE_WIDTH + V_LANES];
  uint32_t entered; /* children with active rays, as bits */
} generic_children;

/* Pushes the children that rays enter, the farthest first; gives the new height of the stack. */
static inline uint32_t generic_push(const whittle_scene *scene, const wide_node *node,
                                    const generic_children *children, generic_entry *stack,
                                    uint32_t height) {
  for (uint32_t rest = children->entered; rest; rest &= rest - 1) {
    const uint32_t i = (uint32_t)__builtin_ctz(rest);
    const uint32_t below = wide_deeper(children->front, i) & children->entered;
    wide_prefetch(scene, node->child[i]);
    stack[height + (uint32_t)__builtin_popcount(below)] =
        (generic_entry){node->child[i], children->front[i], children->active[i]};
  }
  return height + (uint32_t)__builtin_popcount(children->entered);
}

/* The children of an entry's node, by all its rays at once. */
static inline void generic_open(const generic_packet *p, const v_frustum *f, const wide_node *node,
                                generic_entry entry, generic_children *children) {
  const bool fine = entry.child.count == WIDE_FINE_NODE;
  uint32_t reach = generic_reach(p, f, node, children->front);
  children->entered = 0;
  for (; reach; reach &= reach - 1) {
    const uint32_t i = (uint32_t)__builtin_ctz(reach);
    children->active[i] = __builtin_expect(fine, 0) ? generic_enters_fine(p, node, i, entry.active)
                                                    : generic_enters(p, node, i, entry.active);
    children->entered |= (uint32_t)(children->active[i] != 0) << i;
  }
}
