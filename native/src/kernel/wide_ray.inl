/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Single rays on the tree with eight children. */

/* What a ray needs at every node: where the bounds that it meets first and last begin in one, and
 * itself in every lane. */
typedef struct wide_ray {
  uint32_t near[3], far[3]; /* floats into a node */
  v_float t_min, quick[3], begin[3], end[3];
} wide_ray;

static inline void wide_ray_load(const prepared_rays *p, uint32_t lane, float t_min, wide_ray *w) {
  const uint32_t low = offsetof(wide_node, low) / sizeof(float);
  const uint32_t high = offsetof(wide_node, high) / sizeof(float);
  w->t_min = v_set(t_min);
  for (uint32_t i = 0; i < 3; i++) {
    const uint32_t swap = (p->negative[i] >> lane & 1) * (high - low);
    w->near[i] = low + WHITTLE_WIDTH * i + swap, w->far[i] = high + WHITTLE_WIDTH * i - swap;
    w->quick[i] = v_set(p->quick[i][lane]);
    w->begin[i] = v_set(p->begin[i][lane]), w->end[i] = v_set(p->end[i][lane]);
  }
}

/* The children that a ray enters before its nearest hit, and where: s_slab, a child in each lane.
 */
static __attribute__((noinline, cold)) uint32_t wide_fine_reach(const single_ray *single,
                                                                const wide_ray *ray,
                                                                const wide_node *node,
                                                                float front[]) {
  const float *numbers = (const float *)node;
  const s_ray *exact = &single->exact;
  uint32_t found = 0;
  for (uint32_t i = 0; i < WHITTLE_WIDTH; i += WIDE_LANES) {
    v_float near = ray->t_min, far = v_set(single->best);
    v_float to_near[3], to_far[3], reach = v_set(0.0f);
    for (int k = 0; k < 3; k++) {
      const v_float origin = v_set(exact->origin[k]);
      to_near[k] = v_load(numbers + ray->near[exact->axis[k]] + i) - origin;
      to_far[k] = v_load(numbers + ray->far[exact->axis[k]] + i) - origin;
      reach = v_max(v_max(v_abs(to_near[k]), v_abs(to_far[k])), reach);
    }
    const v_float room = reach * v_set(WHITTLE_NODE_PAD);
    for (int k = 0; k < 3; k++) {
      const v_float inverse = v_set(exact->inverse[k]), outwards = v_copysign(room, inverse);
      near = v_max((to_near[k] - outwards) * inverse, near);
      far = v_min((to_far[k] + outwards) * inverse, far);
    }
    const v_mask there = v_eq(v_load(&node->low[0][i]), v_load(&node->low[0][i]));
    found |= v_bits(v_and(there, v_le(near, far))) << i;
    v_store(front + i, near);
  }
  return found & ((1u << WHITTLE_WIDTH) - 1);
}

/* At least those of wide_fine_reach, at no later fronts. Only the NaN of a missing child makes NaN
 * here; as the last one's second operand it stays, and compares false. */
static inline uint32_t wide_quick_reach(const wide_ray *ray, float best, const wide_node *node,
                                        float front[]) {
  const float *numbers = (const float *)node;
  uint32_t found = 0;
  for (uint32_t i = 0; i < WHITTLE_WIDTH; i += WIDE_LANES) {
    v_float near[3], far[3];
    for (int k = 0; k < 3; k++) {
      near[k] = v_fused(v_load(numbers + ray->near[k] + i), ray->quick[k], ray->begin[k]);
      far[k] = v_fused(v_load(numbers + ray->far[k] + i), ray->quick[k], ray->end[k]);
    }
    const v_float begin = v_max(v_max(near[0], ray->t_min), v_max(near[1], near[2]));
    const v_float end = v_min(v_min(far[0], v_set(best)), v_min(far[1], far[2]));
    found |= v_bits(v_le(begin, end)) << i;
    v_store(front + i, begin);
  }
  return found & ((1u << WHITTLE_WIDTH) - 1);
}

/* Of the children in `reach`, at least one, the nearest, or if not `sorted` any; the others wait on
 * the stack, the farthest lowest. */
static inline __attribute__((always_inline)) wide_child
wide_next(const whittle_scene *scene, const wide_node *node, uint32_t reach, const float front[],
          wide_entry *stack, uint32_t *height, const bool sorted) {
  uint32_t i = (uint32_t)__builtin_ctz(reach);
  wide_entry next = {node->child[i], front[i]};
  const uint32_t bottom = *height;
  while ((reach &= reach - 1) != 0) {
    i = (uint32_t)__builtin_ctz(reach);
    wide_entry other = {node->child[i], front[i]};
    if (sorted && other.front < next.front) {
      const wide_entry nearer = other;
      other = next, next = nearer;
    }
    uint32_t at = (*height)++;
    for (; sorted && at > bottom && stack[at - 1].front < other.front; at--)
      stack[at] = stack[at - 1];
    stack[at] = other;
    wide_prefetch(scene, other.child);
  }
  return next.child;
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

/* Ray i, which has been prepared, from `child` down, for hits nearer than what it has. */
static inline __attribute__((always_inline)) void
wide_descend(const trace_context *context, ray_stream *rays, const prepared_rays *prepared,
             uint32_t i, wide_child child, const bool any) {
  const whittle_scene *scene = context->scene;
  single_ray ray;
  wide_ray wide;
  wide_entry stack[WIDE_STACK];
  float front[WHITTLE_WIDTH + V_LANES];
  uint32_t height = 0;
  single_ray_load(rays, i, prepared, &ray);
  wide_ray_load(prepared, i % V_LANES, ray.exact.t_min, &wide);
  for (;;) {
    if (!wide_is_leaf(child)) {
      const wide_node *node = &scene->wide[child.first];
      const uint32_t reach = __builtin_expect(child.count == WIDE_NODE, 1)
                                 ? wide_quick_reach(&wide, ray.best, node, front)
                                 : wide_fine_reach(&ray, &wide, node, front);
      if (reach != 0) {
        child = wide_next(scene, node, reach, front, stack, &height, !any);
        continue;
      }
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

static __attribute__((noinline)) void wide_descend_any(const trace_context *context,
                                                       ray_stream *rays,
                                                       const prepared_rays *prepared, uint32_t i,
                                                       wide_child child) {
  wide_descend(context, rays, prepared, i, child, true);
}

static __attribute__((noinline)) void wide_descend_closest(const trace_context *context,
                                                           ray_stream *rays,
                                                           const prepared_rays *prepared,
                                                           uint32_t i, wide_child child) {
  wide_descend(context, rays, prepared, i, child, false);
}

/* The rays of a list, or with list NULL first .. first + count, one by one; with `resume` they go
 * on from the hits that a packet found for them. */
static void wide_alone(const trace_context *context, ray_stream *rays, const uint32_t *list,
                       uint32_t first, uint32_t count, bool any, bool resume) {
  const wide_child root = {0, WIDE_NODE};
  prepared_rays prepared;
  prepared.group = WHITTLE_NONE;
  for (uint32_t k = 0; k < count; k++) {
    const uint32_t i = list ? list[k] : first + k;
    if (!resume)
      rays->record[i] = WHITTLE_NONE;
    if (!(rays->t[i] > rays->t_min[i]) || (any && rays->record[i] != WHITTLE_NONE))
      continue;
    prepare_ray(rays, i, &prepared);
    any ? wide_descend_any(context, rays, &prepared, i, root)
        : wide_descend_closest(context, rays, &prepared, i, root);
  }
}
