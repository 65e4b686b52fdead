/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* One ray through the binary tree, counting: the definition of what a ray costs. */

typedef struct single_ray {
  s_ray exact;
  f4_float origin, inverse; /* of rays on the binary tree: x, y, z */
  float best;
} single_ray;

typedef struct single_entry {
  uint32_t node;
  float entry;
} single_entry;

/* Ray i, whose group is prepared. */
static inline void single_ray_load(const ray_stream *rays, uint32_t i, const prepared_rays *p,
                                   single_ray *ray) {
  const uint32_t lane = i % V_LANES;
  s_ray *exact = &ray->exact;
  s_set_axes(exact, (int)p->axis[lane]);
  for (int k = 0; k < 3; k++) {
    exact->origin[k] = rays->origin[exact->axis[k]][i];
    exact->inverse[k] = p->inverse[exact->axis[k]][lane];
  }
  exact->shear_x = p->shear_x[lane], exact->shear_y = p->shear_y[lane];
  exact->t_min = rays->t_min[i];
  ray->best = rays->t[i];
}

/* The same of a ray that goes down the binary tree. */
static inline void walked_ray_load(const ray_stream *rays, uint32_t i, prepared_rays *p,
                                   single_ray *ray) {
  const uint32_t lane = i % V_LANES;
  prepare_ray(rays, i, p);
  single_ray_load(rays, i, p, ray);
  ray->origin = f4_make(rays->origin[0][i], rays->origin[1][i], rays->origin[2][i], 0.0f);
  ray->inverse = f4_make(p->inverse[0][lane], p->inverse[1][lane], p->inverse[2][lane], 1.0f);
}

/* Whether the ray enters a node before its nearest hit, and where: s_slab of triangle.inl, four
 * lanes at a time (the fourth is not looked at). */
static inline bool single_enters(const single_ray *ray, const whittle_node *node, float *entry) {
  const f4_float nothing = f4_set(0.0f);
  const f4_float below = ray->origin - f4_load3(node->bounds_min);
  const f4_float above = f4_load3(node->bounds_max) - ray->origin;
  const f4_float room = f4_set(f4_max3(f4_max(below, above)) * WHITTLE_NODE_PAD);
  const f4_float to_low = nothing - (below + room), to_high = above + room;
  const f4_float close = f4_by_sign(ray->inverse, to_low, to_high) * ray->inverse;
  const f4_float away = f4_by_sign(ray->inverse, to_high, to_low) * ray->inverse;
  const float near = f4_max3(f4_max(close, f4_set(-__builtin_inff())));
  const float far = f4_min3(f4_min(away, f4_set(__builtin_inff())));
  *entry = s_max(near, ray->exact.t_min);
  return near <= far && near <= ray->best && far >= ray->exact.t_min;
}

/* The triangles of a block from `index` on whose edges the ray's line passes, V_LANES at a time. */
static inline uint32_t single_edges(const single_ray *ray, const float *rows, uint32_t size,
                                    uint32_t index, v_edges *edges) {
  const s_ray *exact = &ray->exact;
  v_ray lanes; /* the same in every lane, against as many triangles */
  lanes.shear_x = v_set(exact->shear_x), lanes.shear_y = v_set(exact->shear_y);
  v_relative r;
  v_float *to[3] = {r.x, r.y, r.z};
  for (uint32_t k = 0; k < 3; k++) {
    const float *at = rows + (uint32_t)exact->axis[k] * size + index;
    const v_float origin = v_set(exact->origin[k]);
    for (uint32_t vertex = 0; vertex < 3; vertex++)
      to[k][vertex] = v_load(at + 3 * vertex * size) - origin;
  }
  const uint32_t left = size - index;
  const uint32_t there = left < V_LANES ? (1u << left) - 1 : (uint32_t)((1ull << V_LANES) - 1);
  return there & v_bits(v_edge_test(&lanes, &r, v_from_bits(there), edges));
}

/* Of the block of `size` triangles from `first` on, those from `begin` to below `end`. */
typedef struct triangle_block {
  uint32_t first, size, begin, end;
} triangle_block;

/* Decides about a triangle whose edges the ray's line passes; true if it is a new nearest hit. */
static inline bool single_decide(const trace_context *context, ray_stream *rays, uint32_t i,
                                 single_ray *ray, const triangle_block *block, uint32_t index,
                                 const s_edges *edges) {
  const triangle_store *store = &context->scene->triangles;
  const uint32_t record = block->first + index;
  if (record == rays->skip[i] || (context->masked && !sees(context, record)))
    return false;
  const triangle_record triangle =
      whittle_block_triangle(whittle_rows(store, block->first), block->size, index);
  const s_relative relative = s_relate(&ray->exact, &triangle);
  const triangle_plane plane = whittle_plane(&triangle);
  float t, u, v;
  int tied;
  if (!s_decide(&ray->exact, &relative, &plane, edges, 1, ray->best, &t, &u, &v, &tied,
                context->own_box_misses))
    return false;
  if (tied && !wins_tie(store, record, rays->record[i]))
    return false;
  ray->best = t;
  rays->t[i] = t, rays->u[i] = u, rays->v[i] = v, rays->record[i] = record;
  return true;
}

/* Tests triangles of a block; true if `any` and one is hit. Adds to `tested` all of them, or those
 * up to the hit. */
static inline bool single_block(const trace_context *context, ray_stream *rays, uint32_t i,
                                single_ray *ray, triangle_block block, const bool any,
                                uint32_t *tested) {
  const float *rows = whittle_rows(&context->scene->triangles, block.first);
  for (uint32_t at = block.begin; at < block.end; at += V_LANES) {
    v_edges edges;
    float u[V_LANES], v[V_LANES], w[V_LANES];
    uint32_t passed = single_edges(ray, rows, block.size, at, &edges);
    if (block.end - at < V_LANES)
      passed &= (1u << (block.end - at)) - 1;
    if (passed == 0)
      continue;
    v_store(u, edges.u), v_store(v, edges.v), v_store(w, edges.w);
    for (; passed; passed &= passed - 1) {
      const uint32_t lane = (uint32_t)__builtin_ctz(passed);
      const s_edges one = {u[lane], v[lane], w[lane]};
      if (single_decide(context, rays, i, ray, &block, at + lane, &one) && any) {
        *tested += at + lane + 1 - block.begin;
        return true;
      }
    }
  }
  *tested += block.end - block.begin;
  return false;
}

/* Tests `count` triangles from `first` on; true if `any` and one is hit. */
static inline bool single_leaf(const trace_context *context, ray_stream *rays, uint32_t i,
                               single_ray *ray, uint32_t first, uint32_t count, const bool any,
                               uint32_t *tested) {
  const triangle_store *store = &context->scene->triangles;
  while (count > 0) {
    const uint32_t begin = store->places[first] >> 4, size = store->places[first] & 15;
    const uint32_t here = size - begin < count ? size - begin : count;
    const triangle_block block = {first - begin, size, begin, begin + here};
    if (single_block(context, rays, i, ray, block, any, tested))
      return true;
    first += here, count -= here;
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
    row->instance_triangles[context->scene->triangles.ids[r].instance]++;
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
                                                              ray_stream *rays,
                                                              prepared_rays *prepared, uint32_t i,
                                                              const bool any, const bool watched) {
  const whittle_node *nodes = context->scene->nodes;
  single_ray ray;
  walked_ray_load(rays, i, prepared, &ray);
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
                                                 prepared_rays *prepared, uint32_t i, bool any) {
  walk_single(context, rays, prepared, i, any, false);
}

static __attribute__((noinline)) void walk_watched(const trace_context *context, ray_stream *rays,
                                                   prepared_rays *prepared, uint32_t i, bool any) {
  walk_single(context, rays, prepared, i, any, true);
}

static inline void count_all(const trace_context *context, ray_stream *rays, bool any) {
  prepared_rays prepared;
  prepared.group = WHITTLE_NONE;
  for (uint32_t i = 0; i < rays->count; i++)
    context->watch ? walk_watched(context, rays, &prepared, i, any)
                   : walk_plain(context, rays, &prepared, i, any);
}
