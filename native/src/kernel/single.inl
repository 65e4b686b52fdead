/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* One ray through the binary tree, counting: the definition of what a ray costs. */

/* A ray on the binary tree, whose group is prepared. */
typedef struct walked_ray {
  f4_float origin, inverse; /* x, y, z */
  float t_min, best;
} walked_ray;

typedef struct single_entry {
  uint32_t node;
  float entry;
} single_entry;

static inline walked_ray walked_ray_load(const ray_stream *rays, uint32_t i,
                                         const prepared_rays *p) {
  const uint32_t lane = i % V_LANES;
  return (walked_ray){f4_make(rays->origin[0][i], rays->origin[1][i], rays->origin[2][i], 0.0f),
                      f4_make(p->inverse[0][lane], p->inverse[1][lane], p->inverse[2][lane], 1.0f),
                      rays->t_min[i], rays->t[i]};
}

/* Whether the ray enters a node before its nearest hit, and where: s_slab of triangle.inl, four
 * lanes at a time (the fourth is not looked at). */
static inline bool single_enters(const walked_ray *ray, const whittle_node *node, float *entry) {
  const f4_float nothing = f4_set(0.0f);
  const f4_float below = ray->origin - f4_load3(node->bounds_min);
  const f4_float above = f4_load3(node->bounds_max) - ray->origin;
  const f4_float room = f4_set(f4_max3(f4_max(below, above)) * WHITTLE_NODE_PAD);
  const f4_float to_low = nothing - (below + room), to_high = above + room;
  const f4_float close = f4_by_sign(ray->inverse, to_low, to_high) * ray->inverse;
  const f4_float away = f4_by_sign(ray->inverse, to_high, to_low) * ray->inverse;
  const float near = f4_max3(f4_max(close, f4_set(-__builtin_inff())));
  const float far = f4_min3(f4_min(away, f4_set(__builtin_inff())));
  *entry = s_max(near, ray->t_min);
  return near <= far && near <= ray->best && far >= ray->t_min;
}

/* The triangles of a block of `size` from `index` on whose edges the line of the ray in a lane
 * passes, V_LANES at a time. */
static inline __attribute__((always_inline)) uint32_t single_edges(const prepared_rays *p,
                                                                   uint32_t lane, const float *rows,
                                                                   uint32_t size, uint32_t index,
                                                                   v_edges *edges) {
  const uint32_t every = (uint32_t)((1ull << V_LANES) - 1), left = size - index;
  uint32_t axis = p->axis[lane];
  v_ray ray; /* the same in every lane, against as many triangles */
  v_relative r;
  v_float *to[3] = {r.z, r.x, r.y};
  ray.shear_x = v_set(p->shear_x[lane]), ray.shear_y = v_set(p->shear_y[lane]);
  for (uint32_t k = 0; k < 3; k++, axis = v_next_axis[axis]) {
    const float *at = rows + axis * size + index;
    const v_float origin = v_set(p->sheared_origin[(k + 2) % 3][lane]);
    for (uint32_t vertex = 0; vertex < 3; vertex++)
      to[k][vertex] = v_load(at + 3 * vertex * size) - origin;
  }
  const uint32_t passed = v_bits(v_edge_test(&ray, &r, v_from_bits(every), edges));
  return left < V_LANES ? passed & ((1u << left) - 1) : passed;
}

/* Of the block of `size` triangles from `first` on, those from `begin` to below `end`. */
typedef struct triangle_block {
  uint32_t first, size, begin, end;
} triangle_block;

/* Decides about a triangle of `block` whose edges ray i's line passes; true if it is a new nearest
 * hit. */
static inline bool single_decide(const trace_context *context, ray_stream *rays, uint32_t i,
                                 uint32_t axis, const decided_ray *ray, const triangle_block *block,
                                 uint32_t index, const s_edges *edges) {
  const triangle_store *store = &context->scene->triangles;
  const uint32_t record = block->first + index;
  if (record == rays->skip[i] || (context->masked && !sees(context, record)))
    return false;
  const sheared_triangle triangle =
      sheared_triangle_of(whittle_rows(store, block->first), block->size, index, axis);
  const float determinant = (edges->u + edges->v) + edges->w;
  float near, far, t;
  int tied;
  decided_slab(ray, &triangle, &near, &far);
  if (!s_settle(1, determinant, decided_distance(ray, &triangle), near, far, ray->t_min, rays->t[i],
                &t, &tied, context->own_box_misses))
    return false;
  if (tied && !wins_tie(store, record, rays->record[i]))
    return false;
  rays->t[i] = t, rays->record[i] = record;
  rays->u[i] = s_weight(edges->v, determinant), rays->v[i] = s_weight(edges->w, determinant);
  return true;
}

/* Decides about the triangles `passed` of those from `index` on; if `any` stops at a hit and gives
 * its place in the block, else WHITTLE_NONE. Not inlined: it is rare beside what it is called from,
 * which needs all registers. */
static __attribute__((noinline)) uint32_t single_decide_all(
    const trace_context *context, ray_stream *rays, uint32_t i, const prepared_rays *p,
    triangle_block block, uint32_t index, uint32_t passed, const v_edges *edges, bool any) {
  const uint32_t axis = p->axis[i % V_LANES];
  const decided_ray ray = decided_ray_of(p, i % V_LANES, rays->t_min[i]);
  float u[V_LANES], v[V_LANES], w[V_LANES];
  v_store(u, edges->u), v_store(v, edges->v), v_store(w, edges->w);
  for (; passed; passed &= passed - 1) {
    const uint32_t lane = (uint32_t)__builtin_ctz(passed);
    const s_edges one = {u[lane], v[lane], w[lane]};
    if (single_decide(context, rays, i, axis, &ray, &block, index + lane, &one) && any)
      return index + lane;
  }
  return WHITTLE_NONE;
}

/* Tests triangles of a block; if `any` stops at a hit and gives its place in the block, else
 * WHITTLE_NONE. */
static inline __attribute__((always_inline)) uint32_t single_block(const trace_context *context,
                                                                   ray_stream *rays, uint32_t i,
                                                                   const prepared_rays *p,
                                                                   triangle_block block,
                                                                   const bool any) {
  const float *rows = whittle_rows(&context->scene->triangles, block.first);
  for (uint32_t at = block.begin; at < block.end; at += V_LANES) {
    v_edges edges;
    uint32_t passed = single_edges(p, i % V_LANES, rows, block.size, at, &edges);
    if (block.end < block.size && block.end - at < V_LANES)
      passed &= (1u << (block.end - at)) - 1;
    if (passed == 0)
      continue;
    const v_edges kept = edges; /* so that only these are in memory */
    const uint32_t hit = single_decide_all(context, rays, i, p, block, at, passed, &kept, any);
    if (any && hit != WHITTLE_NONE)
      return hit;
  }
  return WHITTLE_NONE;
}

/* Tests `count` triangles from `first` on; true if `any` and one is hit. Adds to `tested` all of
 * them, or those up to the hit. */
static inline bool single_leaf(const trace_context *context, ray_stream *rays, uint32_t i,
                               const prepared_rays *p, uint32_t first, uint32_t count,
                               const bool any, uint32_t *tested) {
  const triangle_store *store = &context->scene->triangles;
  while (count > 0) {
    const uint32_t begin = store->places[first] >> 4, size = store->places[first] & 15;
    const uint32_t here = size - begin < count ? size - begin : count;
    const triangle_block block = {first - begin, size, begin, begin + here};
    const uint32_t hit = single_block(context, rays, i, p, block, any);
    if (hit != WHITTLE_NONE) {
      *tested += hit + 1 - begin;
      return true;
    }
    *tested += here, first += here, count -= here;
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
static inline uint32_t single_descend(const walked_ray *ray, const whittle_node *nodes,
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
  prepare_ray(rays, i, prepared);
  walked_ray ray = walked_ray_load(rays, i, prepared);
  single_entry stack[WHITTLE_STACK];
  uint8_t levels[WHITTLE_STACK]; /* of what waits on the stack: edges from the root */
  uint32_t depth = 0, visited = 0, tested = 0, index = 0, level = 0;
  rays->record[i] = WHITTLE_NONE;
  bool going = ray.best > ray.t_min && context->scene->node_count > 0;
  while (going) {
    const whittle_node *node = &nodes[index];
    visited++;
    if (node->count > 0) {
      const uint32_t first = node->left_first, before = tested;
      const bool stop = single_leaf(context, rays, i, prepared, first, node->count, any, &tested);
      ray.best = rays->t[i];
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
