/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The lecture's packets through the binary tree: first ray, then frustum, then ray by ray. */

/* Wald, Boulos, Shirley: Ray Tracing Deformable Scenes using Dynamic BVHs, TOG 2007. In the fast
 * mode "the first ray" is the lane group that holds it, which costs the same, and "ray by ray"
 * begins with the groups' own frustums. */

/* Arrays of exactly 4 KiB would all compete for the same lines of the first cache. */
#define PACKET_ROOM (WHITTLE_MAX_PACKET + 16)

/* Node intervals of packets are padded by folding this into 1 / direction, on top of the pad of the
 * triangles' own intervals. Rays have t_min >= 0 here: negative bounds need no pad. */
#define NODE_PAD (2.0f * WHITTLE_NODE_PAD)

/* Rays of one class: same dominant axis, same octant, t_min >= 0. */
typedef struct packet {
  uint32_t count;
  int axis;
  bool negative[3]; /* signs of the directions */
  uint32_t alive;   /* lanes not yet blocked, for any-hit rays */
  float common[3];  /* the origin, if all rays share it */
  frustums whole;   /* one, in lane 0 */
  frustums groups;
  float origin[3][PACKET_ROOM] __attribute__((aligned(64)));
  float inverse_near[3][PACKET_ROOM], inverse_far[3][PACKET_ROOM]; /* 1 / direction, padded */
  float t_min[PACKET_ROOM], t[PACKET_ROOM]; /* t of a blocked lane is -infinity */
  float shear_x[PACKET_ROOM], shear_y[PACKET_ROOM];
  float u[PACKET_ROOM], v[PACKET_ROOM];
  uint32_t record[PACKET_ROOM], primitive[PACKET_ROOM], skip[PACKET_ROOM];
  float direction[3][PACKET_ROOM];
  uint32_t slot[PACKET_ROOM]; /* where each came from in the stream */
} packet;

typedef struct packet_entry {
  uint32_t node, first;
} packet_entry;

/* ---- Filling and emptying ----------------------------------------------------------------------- */

/* Takes rays `slot[0 .. count)` of the stream; the last group is filled up with dead lanes. */
static void packet_load(packet *p, const ray_stream *rays, uint32_t count, bool consecutive) {
  const uint32_t first = p->slot[0];
  p->count = count;
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
  for (uint32_t i = count; i % V_LANES != 0; i++) {
    for (int axis = 0; axis < 3; axis++) {
      p->origin[axis][i] = p->origin[axis][0];
      p->direction[axis][i] = p->direction[axis][0];
    }
    p->t_min[i] = 0.0f, p->t[i] = -__builtin_inff(), p->skip[i] = WHITTLE_NONE;
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

static inline float group_deepest(const packet *p, uint32_t at) {
  const v_float depth = v_load(&p->t[at]) * v_abs(v_load(&p->direction[p->axis][at]));
  return v_reduce_max(depth) * (1.0f + FRUSTUM_SLACK);
}

/* The frustum of the whole packet from those of its groups. */
static void packet_join(packet *p, uint32_t groups) {
  for (int axis = 0; axis < 3; axis++) {
    float least[2] = {__builtin_inff(), __builtin_inff()};
    float most[2] = {-__builtin_inff(), -__builtin_inff()};
    for (uint32_t g = 0; g < groups; g++) {
      least[0] = s_min(p->groups.origin_min[axis][g], least[0]);
      most[0] = s_max(p->groups.origin_max[axis][g], most[0]);
      least[1] = s_min(p->groups.slope_min[axis][g], least[1]);
      most[1] = s_max(p->groups.slope_max[axis][g], most[1]);
    }
    v_store(p->whole.origin_min[axis], v_set(least[0]));
    v_store(p->whole.origin_max[axis], v_set(most[0]));
    v_store(p->whole.slope_min[axis], v_set(least[1]));
    v_store(p->whole.slope_max[axis], v_set(most[1]));
  }
}

static void packet_deepest(packet *p, uint32_t groups) {
  float deepest = -__builtin_inff();
  for (uint32_t g = 0; g < groups; g++)
    deepest = s_max(p->groups.deepest[g], deepest);
  v_store(p->whole.deepest, v_set(deepest));
}

/* Derives what the tests need of each ray, and the frustums; true if all share one origin. */
static bool packet_prepare(packet *p) {
  const int kz = p->axis, kx = v_next_axis[kz], ky = v_next_axis[kx];
  const v_float sense = v_set(p->negative[kz] ? -1.0f : 1.0f);
  bool common = true;
  uint32_t g = 0;
  for (uint32_t at = 0; at < p->count; at += V_LANES, g++) {
    for (int axis = 0; axis < 3; axis++) {
      const v_float origin = v_load(&p->origin[axis][at]);
      const v_float inverse = v_set(1.0f) / v_load(&p->direction[axis][at]);
      v_store(&p->inverse_near[axis][at], inverse * v_set(1.0f - NODE_PAD));
      v_store(&p->inverse_far[axis][at], inverse * v_set(1.0f + NODE_PAD));
      p->groups.origin_min[axis][g] = v_reduce_min(origin);
      p->groups.origin_max[axis][g] = v_reduce_max(origin);
      common &= p->groups.origin_min[axis][g] == p->origin[axis][0] &&
                p->groups.origin_max[axis][g] == p->origin[axis][0];
    }
    const v_float depth = v_load(&p->direction[kz][at]);
    const v_float shear_x = v_load(&p->direction[kx][at]) / depth;
    const v_float shear_y = v_load(&p->direction[ky][at]) / depth;
    v_store(&p->shear_x[at], shear_x);
    v_store(&p->shear_y[at], shear_y);
    p->groups.slope_min[kx][g] = v_reduce_min(shear_x * sense);
    p->groups.slope_max[kx][g] = v_reduce_max(shear_x * sense);
    p->groups.slope_min[ky][g] = v_reduce_min(shear_y * sense);
    p->groups.slope_max[ky][g] = v_reduce_max(shear_y * sense);
    p->groups.slope_min[kz][g] = p->groups.slope_max[kz][g] = 1.0f;
    p->groups.deepest[g] = group_deepest(p, at);
    v_storeu(&p->record[at], v_setu(WHITTLE_NONE));
    v_storeu(&p->primitive[at], v_setu(WHITTLE_NONE));
  }
  packet_join(p, g);
  packet_deepest(p, g);
  for (int axis = 0; axis < 3; axis++)
    p->common[axis] = p->origin[axis][0];
  p->alive = p->count;
  return common;
}

/* ---- Tests ---------------------------------------------------------------------------------------- */

/* A box as the slab test wants it: the planes met first and last, less the origin if it is common. */
typedef struct packet_box {
  float near[3], far[3];
} packet_box;

static inline packet_box box_for(const packet *p, const whittle_node *node, const bool common) {
  packet_box box;
  for (int axis = 0; axis < 3; axis++) {
    const float low = node->bounds_min[axis], high = node->bounds_max[axis];
    const float origin = common ? p->common[axis] : 0.0f;
    box.near[axis] = (p->negative[axis] ? high : low) - origin;
    box.far[axis] = (p->negative[axis] ? low : high) - origin;
  }
  return box;
}

/* The lanes of a group that enter a box before their nearest hit. */
static inline uint32_t group_enters(const packet *p, uint32_t at, const packet_box *box,
                                    const bool common) {
  v_float near = v_load(&p->t_min[at]), far = v_load(&p->t[at]);
  for (int axis = 0; axis < 3; axis++) {
    v_float to_near = v_set(box->near[axis]), to_far = v_set(box->far[axis]);
    if (!common) {
      const v_float origin = v_load(&p->origin[axis][at]);
      to_near = to_near - origin, to_far = to_far - origin;
    }
    near = v_max(to_near * v_load(&p->inverse_near[axis][at]), near);
    far = v_min(to_far * v_load(&p->inverse_far[axis][at]), far);
  }
  return v_bits(v_le(near, far));
}

static inline bool whole_reaches(const packet *p, const whittle_node *node) {
  return v_bits(frustums_reach(&p->whole, 0, p->axis, p->negative[p->axis], node->bounds_min,
                               node->bounds_max)) & 1;
}

/* The groups among V_LANES from group `g` on whose frustums reach the node, as bits. */
static inline uint32_t groups_reach(const packet *p, uint32_t g, const whittle_node *node) {
  const uint32_t groups = (p->count + V_LANES - 1) / V_LANES;
  const uint32_t bits = v_bits(frustums_reach(&p->groups, g, p->axis, p->negative[p->axis],
                                              node->bounds_min, node->bounds_max));
  return groups - g < V_LANES ? bits & ((1u << (groups - g)) - 1) : bits;
}

/* The first ray from `first` on that enters the node, or WHITTLE_NONE if none does. */
static inline __attribute__((always_inline)) uint32_t
packet_first(const packet *p, const whittle_node *node, uint32_t first, const bool common) {
  const packet_box box = box_for(p, node, common);
  uint32_t at = first / V_LANES * V_LANES;
  const uint32_t bits = group_enters(p, at, &box, common);
  if (bits != 0)
    return at + (uint32_t)__builtin_ctz(bits);
  if (!whole_reaches(p, node))
    return WHITTLE_NONE;
  const uint32_t tried = at / V_LANES;
  for (uint32_t g = tried / V_LANES * V_LANES; g * V_LANES < p->count; g += V_LANES) {
    uint32_t reach = groups_reach(p, g, node);
    reach &= g < tried + 1 ? ~((2u << (tried - g)) - 1) : UINT32_MAX;
    for (; reach; reach &= reach - 1) {
      at = (g + (uint32_t)__builtin_ctz(reach)) * V_LANES;
      const uint32_t entering = group_enters(p, at, &box, common);
      if (entering != 0)
        return at + (uint32_t)__builtin_ctz(entering);
    }
  }
  return WHITTLE_NONE;
}

/* The same as the lecture has it, and what decided. */
static inline uint32_t packet_first_counted(const packet *p, const whittle_node *node,
                                            uint32_t first, packet_counters *counters) {
  const packet_box box = box_for(p, node, false);
  uint32_t found = WHITTLE_NONE, active = 0;
  for (uint32_t at = first / V_LANES * V_LANES; at < p->count; at += V_LANES) {
    const uint32_t bits = group_enters(p, at, &box, false);
    active += (uint32_t)__builtin_popcount(bits);
    const uint32_t from_first = at < first ? bits >> (first - at) << (first - at) : bits;
    if (found == WHITTLE_NONE && from_first != 0)
      found = at + (uint32_t)__builtin_ctz(from_first);
  }
  counters->nodes++;
  if (found == first)
    counters->decided_first++;
  else if (!whole_reaches(p, node))
    counters->decided_frustum++, found = WHITTLE_NONE;
  else
    counters->decided_brute_force++;
  if (found != WHITTLE_NONE)
    counters->active_rays += active, counters->visited_rays += p->count;
  return found;
}

/* ---- Leaves ---------------------------------------------------------------------------------------- */

static inline v_ray group_ray(const packet *p, uint32_t at) {
  v_ray ray;
  v_set_axes(&ray, p->axis);
  for (int i = 0; i < 3; i++) {
    ray.origin[i] = v_load(&p->origin[ray.axis[i]][at]);
    ray.inverse[i] = v_set(1.0f) / v_load(&p->direction[ray.axis[i]][at]);
  }
  ray.shear_x = v_load(&p->shear_x[at]);
  ray.shear_y = v_load(&p->shear_y[at]);
  ray.t_min = v_load(&p->t_min[at]);
  return ray;
}

/* Records the lanes of `hit`; a blocked lane leaves the packet. */
static inline void record_hits(packet *p, uint32_t at, v_mask hit, uint32_t record, v_float t,
                               v_float u, v_float v, uint32_t primitive, const bool any) {
  v_storeu(&p->record[at], v_selectu(hit, v_setu(record), v_loadu(&p->record[at])));
  if (any) {
    p->alive -= (uint32_t)__builtin_popcount(v_bits(hit));
    v_store(&p->t[at], v_select(hit, v_set(-__builtin_inff()), v_load(&p->t[at])));
    return;
  }
  v_store(&p->t[at], v_select(hit, t, v_load(&p->t[at])));
  v_store(&p->u[at], v_select(hit, u, v_load(&p->u[at])));
  v_store(&p->v[at], v_select(hit, v, v_load(&p->v[at])));
  v_storeu(&p->primitive[at], v_selectu(hit, v_setu(primitive), v_loadu(&p->primitive[at])));
}

/* Tests one lane group against a leaf's triangles; true if a hit was recorded. */
static inline __attribute__((always_inline)) bool
group_leaf(const trace_context *context, packet *p, uint32_t at, uint32_t enters,
           const whittle_node *leaf, const bool any, const bool common) {
  const v_ray ray = group_ray(p, at);
  const v_uint skip = v_loadu(&p->skip[at]);
  bool changed = false;
  for (uint32_t r = leaf->left_first; r < leaf->left_first + leaf->count; r++) {
    const triangle_record *triangle = &context->scene->triangles[r];
    if (context->masked && !sees(context, triangle))
      continue;
    const v_relative relative =
        common ? v_relate_common(p->common, &ray, triangle) : v_relate(&ray, triangle);
    const v_mask active = v_andnot(v_from_bits(enters), v_equ(skip, v_setu(r)));
    v_float t, u, v;
    const v_mask hit =
        v_triangle_test(&ray, &relative, triangle, active, v_load(&p->t[at]),
                        v_loadu(&p->primitive[at]), &t, &u, &v, context->own_box_misses);
    if (!v_any(hit))
      continue;
    changed = true;
    record_hits(p, at, hit, r, t, u, v, triangle->primitive, any);
    if (any)
      enters &= ~v_bits(hit);
  }
  return changed;
}

static inline __attribute__((always_inline)) void
packet_leaf(const trace_context *context, packet *p, const whittle_node *leaf, uint32_t first,
            const bool any, const bool common) {
  const packet_box box = box_for(p, leaf, common);
  const uint32_t first_group = first / V_LANES;
  bool changed = false;
  for (uint32_t g = first_group / V_LANES * V_LANES; g * V_LANES < p->count; g += V_LANES) {
    uint32_t reach = groups_reach(p, g, leaf);
    reach &= g < first_group ? UINT32_MAX << (first_group - g) : UINT32_MAX;
    for (; reach; reach &= reach - 1) {
      const uint32_t group = g + (uint32_t)__builtin_ctz(reach), at = group * V_LANES;
      const uint32_t enters = group_enters(p, at, &box, common);
      if (enters == 0 || !group_leaf(context, p, at, enters, leaf, any, common))
        continue;
      p->groups.deepest[group] = group_deepest(p, at);
      changed = true;
    }
  }
  if (changed)
    packet_deepest(p, (p->count + V_LANES - 1) / V_LANES);
}

/* ---- Traversal -------------------------------------------------------------------------------------- */

/* Whether the first ray meets the left child before the right one. */
static inline bool left_first(const packet *p, uint32_t first, const whittle_node *left) {
  const whittle_node *right = left + 1;
  float along = 0.0f;
  for (int axis = 0; axis < 3; axis++) {
    const float apart = (right->bounds_min[axis] + right->bounds_max[axis]) -
                        (left->bounds_min[axis] + left->bounds_max[axis]);
    along += apart * p->direction[axis][first];
  }
  return along >= 0.0f;
}

/* Asks for what the visit to a node will read: memory, not arithmetic, is what large scenes wait for. */
static inline void prefetch_below(const whittle_scene *scene, const whittle_node *node) {
  if (node->count == 0) {
    whittle_prefetch(&scene->nodes[node->left_first]);
    return;
  }
  const char *first = (const char *)&scene->triangles[node->left_first];
  whittle_prefetch(first);
  whittle_prefetch(first + 64);
}

static inline __attribute__((always_inline)) void
packet_traverse(const trace_context *context, packet *p, const bool any, const bool common,
                const bool lecture) {
  const whittle_node *nodes = context->scene->nodes;
  packet_entry stack[WHITTLE_STACK];
  uint32_t depth = 0;
  stack[depth++] = (packet_entry){0, 0};
  while (depth > 0 && p->alive > 0) {
    const packet_entry entry = stack[--depth];
    const whittle_node *node = &nodes[entry.node];
    const uint32_t first = lecture
                               ? packet_first_counted(p, node, entry.first, context->packets)
                               : packet_first(p, node, entry.first, common);
    if (first == WHITTLE_NONE)
      continue;
    if (node->count > 0) {
      packet_leaf(context, p, node, first, any, common);
      continue;
    }
    const uint32_t left = node->left_first;
    prefetch_below(context->scene, &nodes[left]);
    prefetch_below(context->scene, &nodes[left + 1]);
    const uint32_t near = left_first(p, first, &nodes[left]) ? left : left + 1;
    stack[depth++] = (packet_entry){2 * left + 1 - near, first};
    stack[depth++] = (packet_entry){near, first};
  }
}
