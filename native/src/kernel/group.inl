/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Lane groups of a packet: their test of a box, and what is recorded of their hits. */

/* The lanes of a group that enter a box before their nearest hit: v_slab for one octant. */
static inline uint32_t group_enters(const packet *p, uint32_t at, const float low[3],
                                    const float high[3]) {
  v_float near = v_load(&p->t_min[at]), far = v_load(&p->t[at]);
  v_float below[3], above[3], reach = v_set(0.0f);
  for (int axis = 0; axis < 3; axis++) {
    const v_float origin = v_load(&p->origin[axis][at]);
    below[axis] = origin - v_set(low[axis]), above[axis] = v_set(high[axis]) - origin;
    reach = v_max(v_max(below[axis], above[axis]), reach);
  }
  const v_float room = reach * v_set(WHITTLE_NODE_PAD);
  for (int axis = 0; axis < 3; axis++) {
    const v_float inverse = v_load(&p->inverse[axis][at]);
    const v_float to_low = v_set(0.0f) - (below[axis] + room), to_high = above[axis] + room;
    near = v_max((p->negative[axis] ? to_high : to_low) * inverse, near);
    far = v_min((p->negative[axis] ? to_low : to_high) * inverse, far);
  }
  return v_bits(v_le(near, far));
}

/* Where a packet keeps what the triangle test reads, in the order of the sheared space: a copy of
 * the pointers, which the compiler can hold on to while vectors are stored. */
typedef struct packet_lanes {
  int axis[3];
  const float *origin[3], *direction[3], *shear_x, *shear_y, *t_min, *t;
} packet_lanes;

static inline packet_lanes packet_lanes_of(const packet *p) {
  v_ray order;
  v_set_axes(&order, p->axis);
  packet_lanes l = {.shear_x = p->shear_x, .shear_y = p->shear_y, .t_min = p->t_min, .t = p->t};
  for (int i = 0; i < 3; i++) {
    l.axis[i] = order.axis[i];
    l.origin[i] = p->origin[order.axis[i]], l.direction[i] = p->direction[order.axis[i]];
  }
  return l;
}

static inline __attribute__((always_inline)) v_ray lanes_ray(const packet_lanes *l, uint32_t at) {
  v_ray ray;
  for (int i = 0; i < 3; i++) {
    ray.axis[i] = l->axis[i];
    ray.origin[i] = v_load(l->origin[i] + at);
    ray.inverse[i] = v_set(1.0f) / v_load(l->direction[i] + at);
  }
  ray.shear_x = v_load(l->shear_x + at);
  ray.shear_y = v_load(l->shear_y + at);
  ray.t_min = v_load(l->t_min + at);
  return ray;
}

/* Lanes of a group that still look for a hit. */
static inline v_mask lanes_open(const packet_lanes *l, uint32_t at) {
  return v_lt(v_load(l->t_min + at), v_load(l->t + at));
}

static inline void record_deepest(packet *p, uint32_t at, float deepest) {
  p->groups.deepest[at / V_LANES] = deepest;
}

/* Records the lanes of `hit`. */
static inline void record_hits(packet *p, uint32_t at, v_mask hit, uint32_t record, v_float t,
                               v_float u, v_float v) {
  v_storeu(&p->record[at], v_selectu(hit, v_setu(record), v_loadu(&p->record[at])));
  v_store(&p->t[at], v_select(hit, t, v_load(&p->t[at])));
  v_store(&p->u[at], v_select(hit, u, v_load(&p->u[at])));
  v_store(&p->v[at], v_select(hit, v, v_load(&p->v[at])));
  record_deepest(p, at, group_deepest(p, at));
}

/* The same of any-hit rays: a blocked lane leaves the packet. */
static inline void record_blocked(packet *p, uint32_t at, v_mask hit, uint32_t record) {
  v_storeu(&p->record[at], v_selectu(hit, v_setu(record), v_loadu(&p->record[at])));
  p->alive -= (uint32_t)__builtin_popcount(v_bits(hit));
  v_store(&p->t[at], v_select(hit, v_set(-__builtin_inff()), v_load(&p->t[at])));
  record_deepest(p, at, group_deepest(p, at));
}

/* Of the lanes tied with the nearest hit so far, those in which another triangle is the winner. */
__attribute__((noinline, cold)) static uint32_t lost_ties(const trace_context *context,
                                                          const packet *p, uint32_t at,
                                                          uint32_t tied, uint32_t record) {
  uint32_t lost = 0;
  for (; tied; tied &= tied - 1) {
    const uint32_t lane = (uint32_t)__builtin_ctz(tied);
    if (!wins_tie(&context->scene->triangles, record, p->record[at + lane]))
      lost |= 1u << lane;
  }
  return lost;
}

/* The lanes of `hit` without those of `tied` in which another triangle is the winner. */
static inline v_mask settle_ties(const trace_context *context, const packet *p, uint32_t at,
                                 v_mask hit, v_mask tied, uint32_t record) {
  const uint32_t even = v_bits(tied);
  if (__builtin_expect(even != 0, 0))
    return v_andnot(hit, v_from_bits(lost_ties(context, p, at, even, record)));
  return hit;
}

/* Decides the lanes of a group that have passed a triangle's edges; true if a hit was recorded. */
static inline __attribute__((always_inline)) bool
group_decide(const trace_context *context, packet *p, uint32_t at, const v_ray *ray,
             const v_relative *relative, const triangle_plane *plane, const v_edges *edges,
             v_mask lanes, uint32_t record, const bool any) {
  lanes = v_andnot(lanes, v_equ(v_loadu(&p->skip[at]), v_setu(record)));
  v_float t, u, v;
  v_mask tied;
  v_mask hit = v_decide(ray, relative, plane, edges, lanes, v_load(&p->t[at]), &t, &u, &v, &tied,
                        context->own_box_misses);
  hit = settle_ties(context, p, at, hit, tied, record);
  if (!v_any(hit))
    return false;
  whittle_prefetch(&context->scene->triangles.ids[record]); /* to be asked for when all is done */
  if (any)
    record_blocked(p, at, hit, record);
  else
    record_hits(p, at, hit, record, t, u, v);
  return true;
}
