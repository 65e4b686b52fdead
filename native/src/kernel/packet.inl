/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Packets of rays: what both packet traversals load, test and record. */

/* Arrays of exactly 4 KiB would all compete for the same lines of the first cache. */
#define PACKET_ROOM (WHITTLE_MAX_PACKET + 16)

/* Memory for the rays of a class that do not lie next to each other in their stream. */
typedef struct packet_room {
  float origin[3][PACKET_ROOM] __attribute__((aligned(64)));
  float direction[3][PACKET_ROOM];
  float t_min[PACKET_ROOM], t[PACKET_ROOM], u[PACKET_ROOM], v[PACKET_ROOM];
  uint32_t record[PACKET_ROOM], skip[PACKET_ROOM];
} packet_room;

/* Where a packet's lines are seen from: they meet in a point. That is where the rays begin, or, for
 * shadow rays, the light at which they end. */
typedef enum packet_view { NO_VIEW, FROM_ORIGIN, FROM_END } packet_view;

/* Rays of one class: same dominant axis, same octant, t_min >= 0. The arrays are the stream's own,
 * or those of `room`; the lanes behind `count` in the last group are dead. */
typedef struct packet {
  uint32_t count;
  int axis;
  bool negative[3]; /* signs of the directions */
  packet_view view;
  float point[3];       /* where it is seen from */
  float spread;         /* how far the lines may miss that point, and more for rounding */
  bool looks_negative;  /* the sense in which the view sees along the axis */
  uint32_t alive;       /* lanes not yet blocked, for any-hit rays */
  uint32_t work;        /* tests of lane groups so far */
  uint32_t first;       /* where the rays stand in their stream, */
  const uint32_t *list; /* or if not NULL where each does */
  frustum whole;
  frustums groups;
  float *origin[3], *direction[3], *t_min, *t, *u, *v; /* t of a blocked lane is -infinity */
  uint32_t *record, *skip;
  float inverse[3][PACKET_ROOM]; /* 1 / direction; unless there is a view */
  float shear_x[PACKET_ROOM], shear_y[PACKET_ROOM];
  packet_room room;
} packet;

/* ---- Filling and emptying -----------------------------------------------------------------------
 */

/* Takes `count` rays from `first` on, where they stand. */
static void packet_borrow(packet *p, const ray_stream *rays, uint32_t first, uint32_t count) {
  p->count = count, p->first = first, p->list = NULL;
  for (int axis = 0; axis < 3; axis++) {
    p->origin[axis] = rays->origin[axis] + first;
    p->direction[axis] = rays->direction[axis] + first;
  }
  p->t_min = rays->t_min + first, p->t = rays->t + first;
  p->u = rays->u + first, p->v = rays->v + first;
  p->record = rays->record + first, p->skip = rays->skip + first;
}

/* Takes copies of the rays of a list; with `resume` also of what they have hit. */
static void packet_gather(packet *p, const ray_stream *rays, const uint32_t *list, uint32_t count,
                          bool any, bool resume) {
  packet_room *room = &p->room;
  p->count = count, p->list = list;
  for (int axis = 0; axis < 3; axis++)
    p->origin[axis] = room->origin[axis], p->direction[axis] = room->direction[axis];
  p->t_min = room->t_min, p->t = room->t, p->u = room->u, p->v = room->v;
  p->record = room->record, p->skip = room->skip;
  for (uint32_t i = 0; i < count; i++) {
    const uint32_t from = list[i];
    for (int axis = 0; axis < 3; axis++) {
      p->origin[axis][i] = rays->origin[axis][from];
      p->direction[axis][i] = rays->direction[axis][from];
    }
    p->t_min[i] = rays->t_min[from], p->t[i] = rays->t[from], p->skip[i] = rays->skip[from];
    if (!resume)
      continue;
    p->u[i] = rays->u[from], p->v[i] = rays->v[from], p->record[i] = rays->record[from];
    if (any && p->record[i] != WHITTLE_NONE)
      p->t[i] = -__builtin_inff();
  }
}

/* Gives what packet_gather's copies found back to the stream. */
static void packet_scatter(const packet *p, ray_stream *rays, bool any) {
  for (uint32_t i = 0; i < p->count; i++) {
    const uint32_t to = p->list[i];
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
static bool shares_origin(const packet *p) {
  v_mask same = v_from_bits((uint32_t)((1ull << V_LANES) - 1));
  for (int axis = 0; axis < 3; axis++) {
    const v_float origin = v_set(p->origin[axis][0]);
    for (uint32_t at = 0; at < p->count; at += V_LANES)
      same = v_and(same, v_eq(origin, v_load(&p->origin[axis][at])));
  }
  return v_bits(same) == (uint32_t)((1ull << V_LANES) - 1);
}

/* Ends this much of their length apart still count as one: the rectangles are grown by it. */
#define END_SPREAD 0x1p-10f

/* Whether all rays end at nearly one point; then `point` is it. */
static bool shares_end(packet *p) {
  const float t = p->t[0];
  v_float off = v_set(0.0f), size = off, length = off;
  v_mask same = v_from_bits((uint32_t)((1ull << V_LANES) - 1));
  for (int axis = 0; axis < 3; axis++)
    p->point[axis] = p->origin[axis][0] + p->direction[axis][0] * t;
  for (uint32_t at = 0; at < p->count; at += V_LANES) {
    same = v_and(same, v_eq(v_load(&p->t[at]), v_set(t)));
    for (int axis = 0; axis < 3; axis++) {
      const v_float origin = v_load(&p->origin[axis][at]);
      const v_float along = v_load(&p->direction[axis][at]) * v_set(t);
      off = v_max(v_abs((origin + along) - v_set(p->point[axis])), off);
      size = v_max(v_abs(origin), size), length = v_max(v_abs(along), length);
    }
  }
  const float reach = v_reduce_max(size) + v_reduce_max(length);
  p->spread = 2.0f * v_reduce_max(off) + reach * FRUSTUM_SLACK;
  return v_bits(same) == (uint32_t)((1ull << V_LANES) - 1) && reach <= FLT_MAX &&
         p->spread <= v_reduce_max(length) * END_SPREAD;
}

static packet_view choose_view(packet *p, bool any) {
  p->spread = 0.0f;
  p->looks_negative = p->negative[p->axis];
  if (shares_origin(p)) {
    for (int axis = 0; axis < 3; axis++)
      p->point[axis] = p->origin[axis][0];
    return FROM_ORIGIN;
  }
  if (!any || !shares_end(p))
    return NO_VIEW;
  p->looks_negative = !p->negative[p->axis];
  return FROM_END;
}

/* What the slab test of single rays reads, and the ranges of their origins. */
static void prepare_origins(packet *p) {
  for (int axis = 0; axis < 3; axis++) {
    frustums *f = &p->groups;
    uint32_t g = 0;
    for (uint32_t at = 0; at < p->count; at += V_LANES, g++) {
      const v_float origin = v_load(&p->origin[axis][at]);
      f->origin_min[axis][g] = v_reduce_min(origin);
      f->origin_max[axis][g] = v_reduce_max(origin);
      /* + 0 turns -0 into 0, which is what the octant takes it for. */
      const v_float inverse = v_set(1.0f) / (v_load(&p->direction[axis][at]) + v_set(0.0f));
      v_store(&p->inverse[axis][at], inverse);
    }
    p->whole.origin_min[axis] = least_of(f->origin_min[axis], g);
    p->whole.origin_max[axis] = most_of(f->origin_max[axis], g);
  }
}

/* The same of a packet with a view. */
static void prepare_point(packet *p) {
  for (int axis = 0; axis < 3; axis++) {
    const float low = p->point[axis] - p->spread, high = p->point[axis] + p->spread;
    p->whole.origin_min[axis] = low, p->whole.origin_max[axis] = high;
    for (uint32_t g = 0; g < packet_groups(p); g += V_LANES) {
      v_store(&p->groups.origin_min[axis][g], v_set(low));
      v_store(&p->groups.origin_max[axis][g], v_set(high));
    }
  }
}

static void prepare_slopes(packet *p) {
  const int kz = p->axis, kx = v_next_axis[kz], ky = v_next_axis[kx];
  const v_float sense = v_set(p->looks_negative ? -1.0f : 1.0f);
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
  }
  for (int axis = 0; axis < 3; axis++) {
    p->whole.slope_min[axis] = least_of(f->slope_min[axis], g);
    p->whole.slope_max[axis] = most_of(f->slope_max[axis], g);
  }
}

/* Derives what the tests need of each ray, and the frustums. */
static void packet_prepare(packet *p, bool lecture, bool any, bool resume) {
  packet_pad(p);
  p->alive = p->count;
  for (uint32_t at = 0; !resume && at < p->count; at += V_LANES)
    v_storeu(&p->record[at], v_setu(WHITTLE_NONE));
  for (uint32_t i = 0; resume && any && i < p->count; i++)
    p->alive -= p->record[i] != WHITTLE_NONE;
  p->work = 0;
  p->view = choose_view(p, any);
  if (lecture)
    p->view = NO_VIEW, p->looks_negative = p->negative[p->axis];
  prepare_slopes(p);
  packet_deepest(p);
  if (p->view == NO_VIEW) {
    prepare_origins(p);
    return;
  }
  prepare_point(p);
}

/* ---- Tests
 * ---------------------------------------------------------------------------------------- */

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

/* Records the lanes of `hit`; a blocked lane leaves the packet. */
static inline void record_hits(packet *p, uint32_t at, v_mask hit, uint32_t record, v_float t,
                               v_float u, v_float v, const bool any) {
  v_storeu(&p->record[at], v_selectu(hit, v_setu(record), v_loadu(&p->record[at])));
  if (any) {
    p->alive -= (uint32_t)__builtin_popcount(v_bits(hit));
    v_store(&p->t[at], v_select(hit, v_set(-__builtin_inff()), v_load(&p->t[at])));
  } else {
    v_store(&p->t[at], v_select(hit, t, v_load(&p->t[at])));
    v_store(&p->u[at], v_select(hit, u, v_load(&p->u[at])));
    v_store(&p->v[at], v_select(hit, v, v_load(&p->v[at])));
  }
  p->groups.deepest[at / V_LANES] = group_deepest(p, at);
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
  const uint32_t even = v_bits(tied);
  if (__builtin_expect(even != 0, 0))
    hit = v_andnot(hit, v_from_bits(lost_ties(context, p, at, even, record)));
  if (!v_any(hit))
    return false;
  whittle_prefetch(&context->scene->triangles.ids[record]); /* to be asked for when all is done */
  record_hits(p, at, hit, record, t, u, v, any);
  return true;
}
