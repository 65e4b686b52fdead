/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What few rays of a packet do at a node and in a leaf: ray by ray, eight boxes or triangles at
 * once.
 */

/* So many active rays are few. */
#define GENERIC_FEW 10

/* How deep the frustum would have to come to find what ray i meets at t. */
static inline float generic_depth(const generic_packet *p, uint32_t i, float t) {
  return t * s_abs(p->rays.direction[p->axis][i]);
}

/* The children that ray i enters, from `at` on in lanes, and how deep: the quick test of
 * wide_ray.inl. The NaN of a missing child comes last, and compares false. */
static inline v_mask generic_few_reach(const generic_packet *p, const wide_node *node, uint32_t at,
                                       uint32_t i, v_float *depth) {
  const float *numbers = (const float *)node + at;
  const prepared_rays *r = &p->prepared[i / V_LANES];
  const uint32_t lane = i % V_LANES;
  v_float near = v_set(p->rays.t_min[i]), far = v_set(p->rays.t[i]);
  for (int k = 0; k < 3; k++) {
    const v_float quick = v_set(r->quick[k][lane]);
    near = v_max(near, v_fused(v_load(numbers + p->near[k]), quick, v_set(r->begin[k][lane])));
    far = v_min(far, v_fused(v_load(numbers + p->far[k]), quick, v_set(r->end[k][lane])));
  }
  *depth = near * v_set(s_abs(p->rays.direction[p->axis][i]));
  return v_le(near, far);
}

/* The children of an entry's node that is small beside the scene. */
static __attribute__((noinline, cold)) void generic_few_open_fine(const generic_packet *p,
                                                                  const wide_node *node,
                                                                  generic_entry entry,
                                                                  generic_children *children) {
  children->entered = 0;
  for (uint32_t i = 0; i < WHITTLE_WIDTH; i++) {
    const bool there = node->low[0][i] <= node->high[0][i];
    children->front[i] = entry.front;
    children->active[i] = there ? generic_enters_fine(p, node, i, entry.active) : 0;
    children->entered |= (uint32_t)(children->active[i] != 0) << i;
  }
}

/* The children of an entry's node. */
static inline void generic_few_open(const generic_packet *p, const wide_node *node,
                                    generic_entry entry, generic_children *children) {
  if (__builtin_expect(entry.child.count == WIDE_FINE_NODE, 0)) {
    generic_few_open_fine(p, node, entry, children);
    return;
  }
  uint32_t entered = 0;
  for (uint32_t at = 0; at < WHITTLE_WIDTH; at += WIDE_LANES) {
    v_float front = v_set(__builtin_inff());
    v_uint active = v_setu(0);
    for (uint32_t rest = entry.active; rest; rest &= rest - 1) {
      const uint32_t i = (uint32_t)__builtin_ctz(rest);
      v_float depth;
      const v_mask in = generic_few_reach(p, node, at, i, &depth);
      front = v_select(in, v_min(depth, front), front);
      active = active | v_selectu(in, v_setu(1u << i), v_setu(0));
      entered |= v_bits(in) << at;
    }
    v_store(children->front + at, front);
    v_storeu(children->active + at, active);
  }
  children->entered = entered & ((1u << WHITTLE_WIDTH) - 1);
}

static inline __attribute__((always_inline)) void generic_few_leaf(const trace_context *context,
                                                                   generic_packet *p,
                                                                   wide_child leaf, uint32_t active,
                                                                   const bool any) {
  bool hits = false;
  for (; active; active &= active - 1) {
    const uint32_t i = (uint32_t)__builtin_ctz(active);
    const float before = p->rays.t[i];
    if (wide_ray_leaf(context, &p->rays, i, &p->prepared[i / V_LANES], leaf, any))
      p->alive &= ~(1u << i), hits = true;
    hits |= p->rays.t[i] < before;
  }
  if (hits)
    generic_deepest(p);
}
