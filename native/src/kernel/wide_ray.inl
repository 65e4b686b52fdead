/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Single rays on the tree with eight children. */

/* What a ray needs at every node: where the bounds that it meets first and last begin in one, and
 * itself in every lane. */
typedef struct wide_ray {
  uint32_t near[3], far[3]; /* floats into a node */
  v_float t_min, best, quick[3], begin[3], end[3];
} wide_ray;

static inline void wide_ray_load(const prepared_rays *p, uint32_t lane, float t_min, float best,
                                 wide_ray *w) {
  w->t_min = v_set(t_min), w->best = v_set(best);
  for (uint32_t i = 0; i < 3; i++) {
    w->near[i] = p->near[i][lane], w->far[i] = p->far[i][lane];
    w->quick[i] = v_set(p->quick[i][lane]);
    w->begin[i] = v_set(p->begin[i][lane]), w->end[i] = v_set(p->end[i][lane]);
  }
}

#define WIDE_GROUPS (WHITTLE_WIDTH / WIDE_LANES)

/* The children that a ray enters before its nearest hit, and where: s_slab, a child in each lane.
 */
static __attribute__((noinline, cold)) child_order wide_fine_order(const prepared_rays *p,
                                                                   uint32_t lane, float t_min,
                                                                   float best,
                                                                   const wide_node *node) {
  const float *numbers = (const float *)node;
  const uint32_t z = p->axis[lane], x = v_next_axis[z], axis[3] = {x, v_next_axis[x], z};
  v_float front[WIDE_GROUPS];
  v_mask reach[WIDE_GROUPS];
  for (uint32_t g = 0, i = 0; g < WIDE_GROUPS; g++, i += WIDE_LANES) {
    v_float near = v_set(t_min), far = v_set(best);
    v_float to_near[3], to_far[3], most = v_set(0.0f);
    for (int k = 0; k < 3; k++) {
      const v_float origin = v_set(p->sheared_origin[k][lane]);
      to_near[k] = v_load(numbers + p->near[axis[k]][lane] + i) - origin;
      to_far[k] = v_load(numbers + p->far[axis[k]][lane] + i) - origin;
      most = v_max(v_max(v_abs(to_near[k]), v_abs(to_far[k])), most);
    }
    const v_float room = most * v_set(WHITTLE_NODE_PAD);
    for (int k = 0; k < 3; k++) {
      const v_float inverse = v_set(p->sheared_inverse[k][lane]),
                    outwards = v_copysign(room, inverse);
      near = v_max((to_near[k] - outwards) * inverse, near);
      far = v_min((to_far[k] + outwards) * inverse, far);
    }
    const v_mask there = v_eq(v_load(&node->low[0][i]), v_load(&node->low[0][i]));
    front[g] = near, reach[g] = v_and(there, v_le(near, far));
  }
  return order_of(front, reach);
}

/* At least those of wide_fine_order, at no later fronts. Only the NaN of a missing child makes NaN
 * here; as the last one's second operand it stays, and compares false. */
static inline child_order wide_quick_order(const wide_ray *ray, const wide_node *node) {
  const float *numbers = (const float *)node;
  v_float front[WIDE_GROUPS];
  v_mask reach[WIDE_GROUPS];
  for (uint32_t g = 0, i = 0; g < WIDE_GROUPS; g++, i += WIDE_LANES) {
    v_float near[3], far[3];
    for (int k = 0; k < 3; k++) {
      near[k] = v_fused(v_load(numbers + ray->near[k] + i), ray->quick[k], ray->begin[k]);
      far[k] = v_fused(v_load(numbers + ray->far[k] + i), ray->quick[k], ray->end[k]);
    }
    front[g] = v_max(v_max(near[0], ray->t_min), v_max(near[1], near[2]));
    const v_float end = v_min(v_min(far[0], ray->best), v_min(far[1], far[2]));
    reach[g] = v_le(front[g], end);
  }
  return order_of(front, reach);
}

/* A visited node whose children in `order` still wait for their turn. */
typedef struct wide_wait {
  child_order order;
  const wide_node *node;
} wide_wait;

/* The nearest child in `order`, of which there is one; the others wait on the stack. */
static inline wide_child wide_next(const whittle_scene *scene, const wide_node *node,
                                   child_order order, wide_wait *stack, uint32_t *height) {
  uint32_t key;
  const uint32_t i = order_first(order, &key);
  const child_order others = order_without(order, i);
  stack[*height] = (wide_wait){others, node};
  const uint32_t second = order_first(others, &key);
  *height += key != ORDER_NONE;
  wide_prefetch(scene, node->child[second]);
  return node->child[i];
}

/* Tests a leaf's triangles; true if `any` and one is hit. */
static inline __attribute__((always_inline)) bool wide_ray_leaf(const trace_context *context,
                                                                ray_stream *rays, uint32_t i,
                                                                const prepared_rays *p,
                                                                wide_child leaf, const bool any) {
  uint32_t first = leaf.first, left = leaf.count;
  do {
    const uint32_t size = left < WHITTLE_BLOCK ? left : WHITTLE_BLOCK;
    if (single_block(context, rays, i, p, (triangle_block){first, size, 0, size}, any) !=
        WHITTLE_NONE)
      return true;
    first += size, left -= size;
  } while (left > 0);
  return false;
}

/* The leaf that a ray comes to next, from `child` down; false if there is none. What it needs at
 * nodes lives in registers here: a leaf's test needs them all. */
static inline __attribute__((always_inline)) bool
wide_find_leaf(const whittle_scene *scene, const prepared_rays *prepared, uint32_t lane,
               float t_min, float best, wide_wait *stack, uint32_t *height, wide_child *child) {
  const uint32_t nearest = order_key(best);
  wide_ray ray;
  uint32_t key;
  wide_ray_load(prepared, lane, t_min, best, &ray);
  while (!wide_is_leaf(*child)) {
    const wide_node *node = &scene->wide[child->first];
    child_order order = __builtin_expect(child->count == WIDE_NODE, 1)
                            ? wide_quick_order(&ray, node)
                            : wide_fine_order(prepared, lane, t_min, best, node);
    order_first(order, &key);
    while (key > nearest) {
      if (*height == 0)
        return false;
      node = stack[--*height].node, order = stack[*height].order;
      order_first(order, &key);
    }
    *child = wide_next(scene, node, order, stack, height);
  }
  return true;
}

/* Ray i, which has been prepared, from `child` down, for hits nearer than what it has. */
static inline __attribute__((always_inline)) void
wide_descend(const trace_context *context, ray_stream *rays, const prepared_rays *prepared,
             uint32_t i, wide_child child, const bool any) {
  const whittle_scene *scene = context->scene;
  wide_wait stack[WHITTLE_STACK];
  uint32_t height = 0, key;
  while (wide_find_leaf(scene, prepared, i % V_LANES, rays->t_min[i], rays->t[i], stack, &height,
                        &child)) {
    if (wide_ray_leaf(context, rays, i, prepared, child, any))
      return;
    const uint32_t nearest = order_key(rays->t[i]);
    do {
      if (height == 0)
        return;
      order_first(stack[--height].order, &key);
    } while (key > nearest);
    child = wide_next(scene, stack[height].node, stack[height].order, stack, &height);
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
