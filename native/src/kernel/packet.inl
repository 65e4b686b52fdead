/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Packets of rays: what both packet traversals load, test and record. */

/* Arrays of exactly 4 KiB would all compete for the same lines of the first cache. */
#define PACKET_ROOM (WHITTLE_MAX_PACKET + 16)

/* Node intervals of packets are padded by folding this into 1 / direction, on top of the pad of the
 * triangles' own intervals. Rays have t_min >= 0 here: negative bounds need no pad. */
#define NODE_PAD (2.0f * WHITTLE_NODE_PAD)

/* Memory for the rays of a class that do not lie next to each other in their stream. */
typedef struct packet_room {
  float origin[3][PACKET_ROOM] __attribute__((aligned(64)));
  float direction[3][PACKET_ROOM];
  float t_min[PACKET_ROOM], t[PACKET_ROOM], u[PACKET_ROOM], v[PACKET_ROOM];
  uint32_t record[PACKET_ROOM], skip[PACKET_ROOM];
} packet_room;

/* Rays of one class: same dominant axis, same octant, t_min >= 0. The arrays are the stream's own,
 * or those of `room`; the lanes behind `count` in the last group are dead. */
typedef struct packet {
  uint32_t count;
  int axis;
  bool negative[3]; /* signs of the directions */
  bool shared;      /* all rays have one origin, origin[..][0] */
  uint32_t alive;   /* lanes not yet blocked, for any-hit rays */
  uint32_t work;    /* tests of lane groups so far */
  uint32_t alone;   /* how many packets go ray by ray before the next is tried together */
  frustum whole;
  frustums groups;
  uint32_t quarter;     /* lane groups in a quarter of the packet, a multiple of V_LANES */
  float quarters[4][4]; /* least and most slope in x and y of each quarter */
  float *origin[3], *direction[3], *t_min, *t, *u, *v; /* t of a blocked lane is -infinity */
  uint32_t *record, *skip;
  float inverse_near[3][PACKET_ROOM], inverse_far[3][PACKET_ROOM]; /* padded; unless shared */
  float shear_x[PACKET_ROOM], shear_y[PACKET_ROOM];
  uint32_t primitive[PACKET_ROOM];
  uint32_t slot[PACKET_ROOM]; /* where each came from in the stream */
  packet_room room;
} packet;

/* ---- Filling and emptying -----------------------------------------------------------------------
 */

/* Takes `count` rays from slot[0] on, where they stand. */
static void packet_borrow(packet *p, const ray_stream *rays, uint32_t count) {
  const uint32_t first = p->slot[0];
  p->count = count;
  for (int axis = 0; axis < 3; axis++) {
    p->origin[axis] = rays->origin[axis] + first;
    p->direction[axis] = rays->direction[axis] + first;
  }
  p->t_min = rays->t_min + first, p->t = rays->t + first;
  p->u = rays->u + first, p->v = rays->v + first;
  p->record = rays->record + first, p->skip = rays->skip + first;
}

/* Takes copies of rays slot[0 .. count). */
static void packet_gather(packet *p, const ray_stream *rays, uint32_t count) {
  packet_room *room = &p->room;
  p->count = count;
  for (int axis = 0; axis < 3; axis++)
    p->origin[axis] = room->origin[axis], p->direction[axis] = room->direction[axis];
  p->t_min = room->t_min, p->t = room->t, p->u = room->u, p->v = room->v;
  p->record = room->record, p->skip = room->skip;
  for (uint32_t i = 0; i < count; i++) {
    const uint32_t from = p->slot[i];
    for (int axis = 0; axis < 3; axis++) {
      p->origin[axis][i] = rays->origin[axis][from];
      p->direction[axis][i] = rays->direction[axis][from];
    }
    p->t_min[i] = rays->t_min[from], p->t[i] = rays->t[from], p->skip[i] = rays->skip[from];
  }
}

/* Gives what packet_gather's copies found back to the stream. */
static void packet_scatter(const packet *p, ray_stream *rays, bool any) {
  for (uint32_t i = 0; i < p->count; i++) {
    const uint32_t to = p->slot[i];
    rays->record[to] = p->record[i];
    if (!any)
      rays->t[to] = p->t[i], rays->u[to] = p->u[i], rays->v[to] = p->v[i];
  }
}

/* Fills the last group up with dead lanes. */
static void packet_pad(packet *p) {
  for (uint32_t i = p->count; i % V_LANES != 0; i++) {
    for (int axis = 0; axis < 3; axis++) {
      p->origin[axis][i] = p->origin[axis][0];
      p->direction[axis][i] = p->direction[axis][0];
    }
    p->t_min[i] = 0.0f, p->t[i] = -__builtin_inff(), p->skip[i] = WHITTLE_NONE;
  }
}

static inline float group_deepest(const packet *p, uint32_t at) {
  const v_float depth = v_load(&p->t[at]) * v_abs(v_load(&p->direction[p->axis][at]));
  return v_reduce_max(depth) * (1.0f + FRUSTUM_SLACK);
}

static inline uint32_t packet_groups(const packet *p) {
  return (p->count + V_LANES - 1) / V_LANES;
}

/* Least and most of a row of the groups' numbers. */
static inline float least_of(const float *row, uint32_t count) {
  float least = row[0];
  for (uint32_t i = 1; i < count; i++)
    least = s_min(row[i], least);
  return least;
}

static inline float most_of(const float *row, uint32_t count) {
  float most = row[0];
  for (uint32_t i = 1; i < count; i++)
    most = s_max(row[i], most);
  return most;
}

static inline void packet_deepest(packet *p) {
  p->whole.deepest = most_of(p->groups.deepest, packet_groups(p));
}

/* Whether all rays start at one point. */
static bool packet_shares(const packet *p) {
  v_mask same = v_from_bits((uint32_t)((1ull << V_LANES) - 1));
  for (int axis = 0; axis < 3; axis++) {
    const v_float origin = v_set(p->origin[axis][0]);
    for (uint32_t at = 0; at < p->count; at += V_LANES)
      same = v_and(same, v_eq(origin, v_load(&p->origin[axis][at])));
  }
  return v_bits(same) == (uint32_t)((1ull << V_LANES) - 1);
}

/* What the slab test of single rays reads, and the ranges of their origins. */
static void prepare_origins(packet *p) {
  for (int axis = 0; axis < 3; axis++) {
    frustums *f = &p->groups;
    uint32_t g = 0;
    for (uint32_t at = 0; at < p->count; at += V_LANES, g++) {
      const v_float origin = v_load(&p->origin[axis][at]);
      f->origin_min[axis][g] = p->shared ? p->origin[axis][0] : v_reduce_min(origin);
      f->origin_max[axis][g] = p->shared ? p->origin[axis][0] : v_reduce_max(origin);
      /* + 0 turns -0 into 0, which is what the octant takes it for. */
      const v_float inverse = v_set(1.0f) / (v_load(&p->direction[axis][at]) + v_set(0.0f));
      v_store(&p->inverse_near[axis][at], inverse * v_set(1.0f - NODE_PAD));
      v_store(&p->inverse_far[axis][at], inverse * v_set(1.0f + NODE_PAD));
    }
    p->whole.origin_min[axis] = least_of(f->origin_min[axis], g);
    p->whole.origin_max[axis] = most_of(f->origin_max[axis], g);
  }
}

static void prepare_slopes(packet *p) {
  const int kz = p->axis, kx = v_next_axis[kz], ky = v_next_axis[kx];
  const v_float sense = v_set(p->negative[kz] ? -1.0f : 1.0f);
  frustums *f = &p->groups;
  uint32_t g = 0;
  for (uint32_t at = 0; at < p->count; at += V_LANES, g++) {
    const v_float depth = v_load(&p->direction[kz][at]);
    const v_float shear_x = v_load(&p->direction[kx][at]) / depth;
    const v_float shear_y = v_load(&p->direction[ky][at]) / depth;
    v_store(&p->shear_x[at], shear_x);
    v_store(&p->shear_y[at], shear_y);
    f->slope_min[kx][g] = v_reduce_min(shear_x * sense);
    f->slope_max[kx][g] = v_reduce_max(shear_x * sense);
    f->slope_min[ky][g] = v_reduce_min(shear_y * sense);
    f->slope_max[ky][g] = v_reduce_max(shear_y * sense);
    f->slope_min[kz][g] = f->slope_max[kz][g] = 1.0f;
    f->deepest[g] = group_deepest(p, at);
    v_storeu(&p->record[at], v_setu(WHITTLE_NONE));
    v_storeu(&p->primitive[at], v_setu(WHITTLE_NONE));
  }
  for (int axis = 0; axis < 3; axis++) {
    p->whole.slope_min[axis] = least_of(f->slope_min[axis], g);
    p->whole.slope_max[axis] = most_of(f->slope_max[axis], g);
  }
}

/* The slopes of a quarter of the packet, which in Z order is a square; NaN where it has no rays. */
static void prepare_quarters(packet *p) {
  const int x = v_next_axis[p->axis], y = v_next_axis[x];
  const uint32_t groups = packet_groups(p), step = 4 * V_LANES;
  p->quarter = (groups + step - 1) / step * V_LANES;
  for (uint32_t q = 0; q < 4; q++) {
    const uint32_t g = q * p->quarter;
    const uint32_t count = g >= groups ? 0 : groups - g < p->quarter ? groups - g : p->quarter;
    const float none = __builtin_nanf("");
    p->quarters[0][q] = count ? least_of(p->groups.slope_min[x] + g, count) : none;
    p->quarters[1][q] = count ? most_of(p->groups.slope_max[x] + g, count) : none;
    p->quarters[2][q] = count ? least_of(p->groups.slope_min[y] + g, count) : none;
    p->quarters[3][q] = count ? most_of(p->groups.slope_max[y] + g, count) : none;
  }
}

/* Derives what the tests need of each ray, and the frustums. */
static void packet_prepare(packet *p, bool lecture) {
  packet_pad(p);
  prepare_slopes(p);
  packet_deepest(p);
  p->alive = p->count;
  p->work = 0;
  p->shared = packet_shares(p);
  if (lecture || !p->shared) {
    prepare_origins(p);
    return;
  }
  prepare_quarters(p);
  for (int axis = 0; axis < 3; axis++) {
    const v_float origin = v_set(p->origin[axis][0]);
    p->whole.origin_min[axis] = p->whole.origin_max[axis] = p->origin[axis][0];
    for (uint32_t g = 0; g < packet_groups(p); g += V_LANES) {
      v_store(&p->groups.origin_min[axis][g], origin);
      v_store(&p->groups.origin_max[axis][g], origin);
    }
  }
}

/* ---- Tests
 * ---------------------------------------------------------------------------------------- */

/* The lanes of a group that enter a box before their nearest hit. */
static inline uint32_t group_enters(const packet *p, uint32_t at, const float low[3],
                                    const float high[3]) {
  v_float near = v_load(&p->t_min[at]), far = v_load(&p->t[at]);
  for (int axis = 0; axis < 3; axis++) {
    const v_float origin = v_load(&p->origin[axis][at]);
    const v_float to_near = v_set(p->negative[axis] ? high[axis] : low[axis]) - origin;
    const v_float to_far = v_set(p->negative[axis] ? low[axis] : high[axis]) - origin;
    near = v_max(to_near * v_load(&p->inverse_near[axis][at]), near);
    far = v_min(to_far * v_load(&p->inverse_far[axis][at]), far);
  }
  return v_bits(v_le(near, far));
}

static inline __attribute__((always_inline)) v_ray group_ray(const packet *p, uint32_t at) {
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
  } else {
    v_store(&p->t[at], v_select(hit, t, v_load(&p->t[at])));
    v_store(&p->u[at], v_select(hit, u, v_load(&p->u[at])));
    v_store(&p->v[at], v_select(hit, v, v_load(&p->v[at])));
    v_storeu(&p->primitive[at], v_selectu(hit, v_setu(primitive), v_loadu(&p->primitive[at])));
  }
  p->groups.deepest[at / V_LANES] = group_deepest(p, at);
}

static inline __attribute__((always_inline)) v_relative group_relative(
    const packet *p, const v_ray *ray, const triangle_record *triangle, const bool shared) {
  const float origin[3] = {p->origin[0][0], p->origin[1][0], p->origin[2][0]};
  return shared ? v_relate_common(origin, ray, triangle) : v_relate(ray, triangle);
}

/* Lanes of a group that still look for a hit, and not for the triangle that they start from. */
static inline v_mask group_open(const packet *p, uint32_t at, uint32_t record) {
  const v_mask open = v_lt(v_load(&p->t_min[at]), v_load(&p->t[at]));
  return v_andnot(open, v_equ(v_loadu(&p->skip[at]), v_setu(record)));
}

/* Whether the line of an open lane of the group meets the triangle. */
static inline __attribute__((always_inline)) bool group_meets(const packet *p, uint32_t at,
                                                              const triangle_record *triangle,
                                                              uint32_t record, const bool shared) {
  const v_ray ray = group_ray(p, at);
  const v_relative relative = group_relative(p, &ray, triangle, shared);
  v_edges edges;
  return v_any(v_edge_test(&ray, &relative, group_open(p, at, record), &edges));
}

/* The exact test of one triangle for the lanes `active` of a group; true if a hit was recorded. */
static inline __attribute__((always_inline)) bool
group_triangle(const trace_context *context, packet *p, uint32_t at, uint32_t active,
               uint32_t record, const bool any, const bool shared) {
  const triangle_record *triangle = &context->scene->triangles[record];
  const v_ray ray = group_ray(p, at);
  const v_relative relative = group_relative(p, &ray, triangle, shared);
  v_mask lanes = group_open(p, at, record);
  if (active != UINT32_MAX)
    lanes = v_and(lanes, v_from_bits(active));
  v_float t, u, v;
  const v_mask hit =
      v_triangle_test(&ray, &relative, triangle, lanes, v_load(&p->t[at]),
                      v_loadu(&p->primitive[at]), &t, &u, &v, context->own_box_misses);
  if (!v_any(hit))
    return false;
  record_hits(p, at, hit, record, t, u, v, triangle->primitive, any);
  return true;
}
