/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* One ray through the binary tree, counting: the definition of what a ray costs. */

typedef struct single_ray {
  s_ray exact;
  f4_float origin, inverse;
  float best;
  uint32_t best_primitive;
} single_ray;

typedef struct single_entry {
  uint32_t node;
  float entry;
} single_entry;

static inline void single_ray_load(const ray_stream *rays, uint32_t i, single_ray *ray) {
  float d[3], o[3];
  for (int axis = 0; axis < 3; axis++)
    d[axis] = rays->direction[axis][i], o[axis] = rays->origin[axis][i];
  s_ray *exact = &ray->exact;
  s_set_axes(exact, whittle_dominant_axis(d));
  for (int k = 0; k < 3; k++) {
    exact->origin[k] = o[exact->axis[k]];
    exact->inverse[k] = 1.0f / d[exact->axis[k]];
  }
  exact->shear_x = d[exact->axis[0]] / d[exact->axis[2]];
  exact->shear_y = d[exact->axis[1]] / d[exact->axis[2]];
  exact->t_min = rays->t_min[i];
  ray->origin = f4_make(o[0], o[1], o[2], 0.0f);
  ray->inverse = f4_set(1.0f) / f4_make(d[0], d[1], d[2], 1.0f);
  ray->best = rays->t[i];
  ray->best_primitive = WHITTLE_NONE;
}

/* Whether the ray enters a node before its nearest hit, and where: s_slab of triangle.inl, four
 * lanes at a time (the fourth is not looked at). */
static inline bool single_enters(const single_ray *ray, const whittle_node *node, float *entry) {
  const f4_float low = f4_load3(node->bounds_min), high = f4_load3(node->bounds_max);
  const f4_float lowest = f4_set(-__builtin_inff()), highest = f4_set(__builtin_inff());
  const f4_float close = f4_by_sign(ray->inverse, low, high) - ray->origin;
  const f4_float away = f4_by_sign(ray->inverse, high, low) - ray->origin;
  const float n = f4_max3(f4_max(close * ray->inverse, lowest));
  const float f = f4_min3(f4_min(away * ray->inverse, highest));
  const float near = n - s_abs(n) * WHITTLE_NODE_PAD;
  const float far = f + s_abs(f) * WHITTLE_NODE_PAD;
  *entry = s_max(near, ray->exact.t_min);
  return near <= far && near <= ray->best && far >= ray->exact.t_min;
}

/* Tests a leaf's triangles; true if `any` and one is hit. */
static inline bool single_leaf(const trace_context *context, ray_stream *rays, uint32_t i,
                               single_ray *ray, uint32_t first, uint32_t count, const bool any,
                               uint32_t *tested) {
  const whittle_scene *scene = context->scene;
  for (uint32_t r = first; r < first + count; r++) {
    const triangle_record *triangle = &scene->triangles[r];
    ++*tested;
    if (r == rays->skip[i] || (context->masked && !sees(context, triangle)))
      continue;
    float t, u, v;
    const s_relative relative = s_relate(&ray->exact, triangle);
    if (!s_triangle_test(&ray->exact, &relative, triangle, 1, ray->best, ray->best_primitive, &t,
                         &u, &v, context->own_box_misses))
      continue;
    ray->best = t, ray->best_primitive = triangle->primitive;
    rays->t[i] = t, rays->u[i] = u, rays->v[i] = v, rays->record[i] = r;
    if (any)
      return true;
  }
  return false;
}

/* Charges a visit to whoever owns what was visited. */
static inline void single_charge(const ray_watch *watch, const trace_context *context,
                                 uint32_t index, uint32_t first, uint32_t tested) {
  const cost_owners *owners = watch->owners;
  const cost_row *row = watch->charged;
  const node_owner owner = owners->nodes[index];
  row->instance_nodes[owner.instance]++;
  row->material_nodes[owner.material]++;
  for (uint32_t r = first; r < first + tested; r++) {
    row->instance_triangles[context->scene->triangles[r].instance]++;
    row->material_triangles[owners->materials[r]]++;
  }
}

/* Tells what is wanted of ray i's visit to a node and the `tested` triangles of a leaf. */
static inline void single_watch(const trace_context *context, uint32_t i, uint32_t index,
                                uint32_t level, uint32_t tested) {
  const ray_watch *watch = context->watch;
  const whittle_node *node = &context->scene->nodes[index];
  uint32_t *deepest = &watch->leaf_depth[watch->slot[i]];
  if (node->count > 0 && level > *deepest)
    *deepest = level;
  if (watch->owners != NULL)
    single_charge(watch, context, index, node->left_first, tested);
  if (watch->log != NULL)
    ray_log_visit(watch->log, index, node->left_first, tested);
}

/* Of the children of an inner node the one to visit next, or WHITTLE_NONE if the ray enters none;
 * the other, if it enters both, waits at stack[depth]. */
static inline uint32_t single_descend(const single_ray *ray, const whittle_node *nodes,
                                      uint32_t left, single_entry *stack, uint32_t *depth) {
  float entry[2];
  const bool enters_left = single_enters(ray, &nodes[left], &entry[0]);
  const bool enters_right = single_enters(ray, &nodes[left + 1], &entry[1]);
  if (enters_left && enters_right) {
    const uint32_t second = entry[1] < entry[0] ? 0 : 1;
    stack[(*depth)++] = (single_entry){left + second, entry[second]};
    return left + 1 - second;
  }
  return enters_left ? left : enters_right ? left + 1 : WHITTLE_NONE;
}

/* The nodes that a ray visits: the root; of a visited inner node the children whose padded box it
 * enters, the nearer first and the left one at equal distance; the second only if it still begins
 * no farther than the nearest hit when its turn comes. */
static inline __attribute__((always_inline)) void walk_single(const trace_context *context,
                                                              ray_stream *rays, uint32_t i,
                                                              const bool any, const bool watched) {
  const whittle_node *nodes = context->scene->nodes;
  single_ray ray;
  single_ray_load(rays, i, &ray);
  single_entry stack[WHITTLE_STACK];
  uint8_t levels[WHITTLE_STACK]; /* of what waits on the stack: edges from the root */
  uint32_t depth = 0, visited = 0, tested = 0, index = 0, level = 0;
  rays->record[i] = WHITTLE_NONE;
  bool going = ray.best > ray.exact.t_min && context->scene->node_count > 0;
  while (going) {
    const whittle_node *node = &nodes[index];
    visited++;
    if (node->count > 0) {
      const uint32_t first = node->left_first, before = tested;
      const bool stop = single_leaf(context, rays, i, &ray, first, node->count, any, &tested);
      if (watched)
        single_watch(context, i, index, level, tested - before);
      if (stop)
        break;
    } else {
      if (watched) {
        single_watch(context, i, index, level, 0);
        levels[depth] = (uint8_t)++level;
      }
      index = single_descend(&ray, nodes, node->left_first, stack, &depth);
      if (index != WHITTLE_NONE)
        continue;
    }
    do {
      going = depth > 0;
      if (going)
        index = stack[--depth].node;
    } while (going && stack[depth].entry > ray.best);
    level = watched ? levels[depth] : 0;
  }
  rays->nodes[i] = visited, rays->triangles[i] = tested;
}

/* Not inlined, so that what only traces is compiled as if nothing could be counted. */
static __attribute__((noinline)) void walk_plain(const trace_context *context, ray_stream *rays,
                                                 uint32_t i, bool any) {
  walk_single(context, rays, i, any, false);
}

static __attribute__((noinline)) void walk_watched(const trace_context *context, ray_stream *rays,
                                                   uint32_t i, bool any) {
  walk_single(context, rays, i, any, true);
}

static inline void count_single(const trace_context *context, ray_stream *rays, uint32_t i,
                                bool any) {
  context->watch ? walk_watched(context, rays, i, any) : walk_plain(context, rays, i, any);
}
