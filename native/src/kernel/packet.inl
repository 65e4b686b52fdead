/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The lecture's packets through the binary tree: first ray, then frustum, then ray by ray. */

/* Wald, Boulos, Shirley: Ray Tracing Deformable Scenes using Dynamic BVHs, TOG 2007. In the fast
 * mode "the first ray" is the lane group that holds it, which costs the same. */

/* Arrays of exactly 4 KiB would all compete for the same lines of the first cache. */
#define PACKET_ROOM (WHITTLE_MAX_PACKET + 16)

/* Rays of one class: same dominant axis, same sign along it. */
typedef struct packet {
  uint32_t count, groups;
  int axis;
  uint32_t slot[PACKET_ROOM]; /* where each came from in the stream */
  float origin[3][PACKET_ROOM] __attribute__((aligned(64)));
  float direction[3][PACKET_ROOM] __attribute__((aligned(64)));
  float inverse[3][PACKET_ROOM] __attribute__((aligned(64)));
  float shear_x[PACKET_ROOM], shear_y[PACKET_ROOM];
  float t_min[PACKET_ROOM], t[PACKET_ROOM]; /* t of a blocked lane is -infinity */
  float u[PACKET_ROOM], v[PACKET_ROOM];
  uint32_t record[PACKET_ROOM], primitive[PACKET_ROOM], skip[PACKET_ROOM];
  uint32_t alive; /* lanes not yet blocked, for any-hit rays */
  frustum frustum;
} packet;

typedef struct packet_entry {
  uint32_t node, first;
} packet_entry;

static inline void packet_group(const packet *p, uint32_t at, v_ray *ray) {
  for (int axis = 0; axis < 3; axis++) {
    ray->origin[axis] = v_load(&p->origin[axis][at]);
    ray->inverse[axis] = v_load(&p->inverse[axis][at]);
  }
  ray->shear_x = v_load(&p->shear_x[at]);
  ray->shear_y = v_load(&p->shear_y[at]);
  ray->shear_z = ray->inverse[p->axis];
  ray->t_min = v_load(&p->t_min[at]);
}

/* Takes rays `slot[0 .. count)` of the stream; the last group is filled up with dead lanes. */
static void packet_load(packet *p, const ray_stream *rays, uint32_t count, bool consecutive) {
  const uint32_t first = p->slot[0];
  p->count = count;
  p->groups = (count + V_LANES - 1) / V_LANES;
  if (consecutive) {
    for (int axis = 0; axis < 3; axis++) {
      memcpy(p->origin[axis], rays->origin[axis] + first, count * sizeof(float));
      memcpy(p->direction[axis], rays->direction[axis] + first, count * sizeof(float));
    }
    memcpy(p->t_min, rays->t_min + first, count * sizeof(float));
    memcpy(p->t, rays->t + first, count * sizeof(float));
    memcpy(p->skip, rays->skip + first, count * sizeof(uint32_t));
  } else {
    for (uint32_t i = 0; i < count; i++) {
      const uint32_t from = p->slot[i];
      for (int axis = 0; axis < 3; axis++) {
        p->origin[axis][i] = rays->origin[axis][from];
        p->direction[axis][i] = rays->direction[axis][from];
      }
      p->t_min[i] = rays->t_min[from], p->t[i] = rays->t[from], p->skip[i] = rays->skip[from];
    }
  }
  for (uint32_t i = count; i < p->groups * V_LANES; i++) {
    for (int axis = 0; axis < 3; axis++) {
      p->origin[axis][i] = p->origin[axis][0];
      p->direction[axis][i] = p->direction[axis][0];
    }
    p->t_min[i] = 0.0f, p->t[i] = -__builtin_inff(), p->skip[i] = WHITTLE_NONE;
  }
}

static inline void widen(float *least, float *most, v_float x) {
  *least = s_min(v_reduce_min(x), *least);
  *most = s_max(v_reduce_max(x), *most);
}

/* Derives what the tests need of each ray, and the frustum around all of them. */
static void packet_prepare(packet *p) {
  const int kz = p->axis, kx = v_next_axis[kz], ky = v_next_axis[kx];
  frustum *f = &p->frustum;
  f->axis = kz;
  f->sign = p->direction[kz][0] < 0.0f ? -1.0f : 1.0f;
  for (int axis = 0; axis < 3; axis++) {
    f->origin_min[axis] = f->slope_min[axis] = __builtin_inff();
    f->origin_max[axis] = f->slope_max[axis] = -__builtin_inff();
  }
  float earliest = __builtin_inff(), unused = -__builtin_inff();
  for (uint32_t at = 0; at < p->count; at += V_LANES) {
    const v_float depth = v_load(&p->direction[kz][at]);
    for (int axis = 0; axis < 3; axis++) {
      v_store(&p->inverse[axis][at], v_set(1.0f) / v_load(&p->direction[axis][at]));
      widen(&f->origin_min[axis], &f->origin_max[axis], v_load(&p->origin[axis][at]));
    }
    const v_float shear_x = v_load(&p->direction[kx][at]) / depth;
    const v_float shear_y = v_load(&p->direction[ky][at]) / depth;
    v_store(&p->shear_x[at], shear_x);
    v_store(&p->shear_y[at], shear_y);
    widen(&f->slope_min[kx], &f->slope_max[kx], shear_x * v_set(f->sign));
    widen(&f->slope_min[ky], &f->slope_max[ky], shear_y * v_set(f->sign));
    widen(&earliest, &unused, v_load(&p->t_min[at]));
    v_storeu(&p->record[at], v_setu(WHITTLE_NONE));
    v_storeu(&p->primitive[at], v_setu(WHITTLE_NONE));
  }
  f->valid = earliest >= 0.0f;
  p->alive = p->count;
}

/* The greatest depth at which a ray of the packet still looks for a hit. */
static void packet_deepest(packet *p) {
  v_float deepest = v_set(-__builtin_inff());
  for (uint32_t at = 0; at < p->count; at += V_LANES)
    deepest = v_max(v_load(&p->t[at]) * v_abs(v_load(&p->direction[p->axis][at])), deepest);
  p->frustum.deepest = v_reduce_max(deepest) * (1.0f + FRUSTUM_SLACK);
}

static inline v_mask packet_enters(const packet *p, uint32_t at, const whittle_node *node) {
  v_ray ray;
  packet_group(p, at, &ray);
  v_float near, far;
  v_slab(&ray, node->bounds_min, node->bounds_max, &near, &far);
  const v_mask hit = v_and(v_le(near, far), v_le(near, v_load(&p->t[at])));
  return v_and(hit, v_le(ray.t_min, far));
}

static inline bool packet_ray_enters(const packet *p, uint32_t i, const whittle_node *node) {
  return v_bits(packet_enters(p, i / V_LANES * V_LANES, node)) >> (i % V_LANES) & 1;
}

/* The first ray from `first` on that enters the node, or WHITTLE_NONE if none does. */
static inline __attribute__((always_inline)) uint32_t
packet_first(const packet *p, const whittle_node *node, uint32_t first, const bool lecture,
             packet_counters *counters) {
  const uint32_t group = first / V_LANES * V_LANES;
  uint32_t at = group;
  if (lecture) {
    counters->nodes++;
    if (packet_ray_enters(p, first, node)) {
      counters->decided_first++;
      return first;
    }
  } else {
    const uint32_t bits = v_bits(packet_enters(p, group, node));
    if (bits != 0)
      return group + (uint32_t)__builtin_ctz(bits);
    at += V_LANES;
  }
  if (p->frustum.valid && frustum_misses(&p->frustum, node->bounds_min, node->bounds_max)) {
    if (lecture)
      counters->decided_frustum++;
    return WHITTLE_NONE;
  }
  if (lecture)
    counters->decided_brute_force++;
  for (; at < p->count; at += V_LANES) {
    const uint32_t bits = v_bits(packet_enters(p, at, node));
    if (bits != 0)
      return at + (uint32_t)__builtin_ctz(bits);
  }
  return WHITTLE_NONE;
}

/* Tests one lane group against a leaf's triangles; true if a hit was recorded. */
static inline __attribute__((always_inline)) bool
packet_group_leaf(const trace_context *context, packet *p, uint32_t at, v_mask enters,
                  const whittle_node *leaf, const bool any) {
  const whittle_scene *scene = context->scene;
  v_ray ray;
  packet_group(p, at, &ray);
  v_float best = v_load(&p->t[at]);
  v_uint best_primitive = v_loadu(&p->primitive[at]);
  const v_uint skip = v_loadu(&p->skip[at]);
  bool changed = false;
  for (uint32_t r = leaf->left_first; r < leaf->left_first + leaf->count; r++) {
    const triangle_record *triangle = &scene->triangles[r];
    if (context->masked && !sees(context, triangle))
      continue;
    const v_mask active = v_andnot(enters, v_equ(skip, v_setu(r)));
    v_float t, u, v;
    const v_mask hit = v_triangle_test(&ray, p->axis, triangle, active, best, best_primitive, &t, &u,
                                       &v, context->own_box_misses);
    const uint32_t bits = v_bits(hit);
    if (bits == 0)
      continue;
    changed = true;
    if (any) {
      p->alive -= (uint32_t)__builtin_popcount(bits);
      enters = v_andnot(enters, hit);
      best = v_select(hit, v_set(-__builtin_inff()), best);
    } else {
      best = v_select(hit, t, best);
      best_primitive = v_selectu(hit, v_setu(triangle->primitive), best_primitive);
      v_store(&p->u[at], v_select(hit, u, v_load(&p->u[at])));
      v_store(&p->v[at], v_select(hit, v, v_load(&p->v[at])));
    }
    v_storeu(&p->record[at], v_selectu(hit, v_setu(r), v_loadu(&p->record[at])));
  }
  if (changed) {
    v_store(&p->t[at], best);
    v_storeu(&p->primitive[at], best_primitive);
  }
  return changed;
}

static inline __attribute__((always_inline)) void packet_leaf(const trace_context *context, packet *p,
                                                              const whittle_node *leaf,
                                                              uint32_t first, const bool any) {
  bool changed = false;
  for (uint32_t at = first / V_LANES * V_LANES; at < p->count; at += V_LANES) {
    const v_mask enters = packet_enters(p, at, leaf);
    if (v_any(enters))
      changed |= packet_group_leaf(context, p, at, enters, leaf, any);
  }
  if (changed && p->frustum.valid)
    packet_deepest(p);
}

static inline void packet_count_active(const packet *p, const whittle_node *node,
                                       packet_counters *counters) {
  for (uint32_t at = 0; at < p->count; at += V_LANES)
    counters->active_rays += (uint64_t)__builtin_popcount(v_bits(packet_enters(p, at, node)));
  counters->visited_rays += p->count;
}

/* Whether the first ray meets the left child before the right one. */
static inline bool packet_left_first(const packet *p, uint32_t first, const whittle_node *left) {
  const whittle_node *right = left + 1;
  float along = 0.0f;
  for (int axis = 0; axis < 3; axis++) {
    const float apart = (right->bounds_min[axis] + right->bounds_max[axis]) -
                        (left->bounds_min[axis] + left->bounds_max[axis]);
    along += apart * p->direction[axis][first];
  }
  return along >= 0.0f;
}

static inline __attribute__((always_inline)) void
packet_traverse(const trace_context *context, packet *p, const bool any, const bool lecture) {
  const whittle_node *nodes = context->scene->nodes;
  packet_entry stack[WHITTLE_STACK];
  uint32_t depth = 0;
  stack[depth++] = (packet_entry){0, 0};
  while (depth > 0 && p->alive > 0) {
    const packet_entry entry = stack[--depth];
    const whittle_node *node = &nodes[entry.node];
    const uint32_t first = packet_first(p, node, entry.first, lecture, context->packets);
    if (first == WHITTLE_NONE)
      continue;
    if (lecture)
      packet_count_active(p, node, context->packets);
    if (node->count > 0) {
      packet_leaf(context, p, node, first, any);
      continue;
    }
    const uint32_t left = node->left_first;
    whittle_prefetch(&nodes[left]);
    const uint32_t near = packet_left_first(p, first, &nodes[left]) ? left : left + 1;
    stack[depth++] = (packet_entry){2 * left + 1 - near, first};
    stack[depth++] = (packet_entry){near, first};
  }
}

static void packet_save(const packet *p, ray_stream *rays, bool any, bool consecutive) {
  if (consecutive) {
    const uint32_t first = p->slot[0];
    memcpy(rays->record + first, p->record, p->count * sizeof(uint32_t));
    if (any)
      return;
    memcpy(rays->t + first, p->t, p->count * sizeof(float));
    memcpy(rays->u + first, p->u, p->count * sizeof(float));
    memcpy(rays->v + first, p->v, p->count * sizeof(float));
    return;
  }
  for (uint32_t i = 0; i < p->count; i++) {
    const uint32_t to = p->slot[i];
    rays->record[to] = p->record[i];
    if (!any)
      rays->t[to] = p->t[i], rays->u[to] = p->u[i], rays->v[to] = p->v[i];
  }
}
