/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Single rays on the tree with eight children. */

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
