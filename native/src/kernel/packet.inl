/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Packets of rays: what both packet traversals keep, and how they are filled and emptied. */

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

/* The lane groups as few bits each, so that many are compared at once: slopes in 255 steps of the
 * packet's range, depths as the upper halves of floats. All are rounded down, and so is what they
 * are compared with: that keeps the order of any two, or makes them equal. */
#define STEPS 255.0f
#define STEPS_ROOM (WHITTLE_MAX_PACKET / V_LANES + V_BYTES)
typedef struct group_steps {
  uint8_t low_x[STEPS_ROOM], high_x[STEPS_ROOM], low_y[STEPS_ROOM], high_y[STEPS_ROOM];
  int16_t deepest[STEPS_ROOM]; /* as v_store_shorts makes them */
  bool behind;                 /* some group is not as deep any more */
  float origin_x, origin_y, scale_x, scale_y;
} group_steps;

/* Of a packet with a view when first needed: see edges.inl. */
typedef struct group_centers {
  bool made;
  float at[2][FRUSTUM_ROOM], half[2];
} group_centers;

/* Rays of one class: same dominant axis, same octant, t_min >= 0. The arrays are the stream's own,
 * or those of `room`; the lanes behind `count` in the last group are dead. */
typedef struct packet {
  uint32_t count;
  int axis;
  bool negative[3]; /* signs of the directions */
  packet_view view;
  bool one_origin;      /* known of its stream */
  float point[3];       /* where it is seen from */
  float spread;         /* how far the lines may miss that point, and more for rounding */
  float away;           /* from that point to where rays begin, at most, on each axis */
  bool looks_negative;  /* the sense in which the view sees along the axis */
  uint32_t alive;       /* lanes not yet blocked, for any-hit rays */
  uint32_t work;        /* tests of lane groups so far, twice */
  uint32_t leaves;      /* visited with a view */
  uint32_t first;       /* where the rays stand in their stream, */
  const uint32_t *list; /* or if not NULL where each does */
  frustum whole;
  frustums groups;
  group_centers centers;
  group_steps steps;                                   /* of a packet with a view */
  float *origin[3], *direction[3], *t_min, *t, *u, *v; /* t of a blocked lane is -infinity */
  uint32_t *record, *skip;
  bool has_inverse;               /* with a view `inverse` is made when first needed */
  int order[3];                   /* the axes of the sheared space */
  float inverse[3][PACKET_ROOM];  /* 1 / direction */
  float determinant[PACKET_ROOM]; /* by which u and v are still to be divided */
  float shear_x[PACKET_ROOM], shear_y[PACKET_ROOM];
  packet_room room;
} packet;

/* ---- Filling and emptying -----------------------------------------------------------------------
 */

/* Takes `count` rays from `first` on, where they stand. */
static void packet_borrow(packet *p, const ray_stream *rays, uint32_t first, uint32_t count) {
  p->count = count, p->first = first, p->list = NULL, p->one_origin = rays->one_origin;
  for (int axis = 0; axis < 3; axis++) {
    p->origin[axis] = rays->origin[axis] + first;
    p->direction[axis] = rays->direction[axis] + first;
  }
  p->t_min = rays->t_min + first, p->t = rays->t + first;
  p->u = rays->u + first, p->v = rays->v + first;
  p->record = rays->record + first, p->skip = rays->skip + first;
}

/* Takes copies of the rays of a list. */
static void packet_gather(packet *p, const ray_stream *rays, const uint32_t *list, uint32_t count) {
  packet_room *room = &p->room;
  p->count = count, p->list = list, p->one_origin = rays->one_origin;
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

/* How deep rays of these lengths can still hit, given the directions' longest components. */
static inline float deepest_of(v_float t, v_float length) {
  return v_reduce_max(t * v_abs(length)) * (1.0f + FRUSTUM_SLACK);
}

static inline float group_deepest(const packet *p, uint32_t at) {
  return deepest_of(v_load(&p->t[at]), v_load(&p->direction[p->axis][at]));
}

static inline uint32_t packet_groups(const packet *p) {
  return (p->count + V_LANES - 1) / V_LANES;
}

/* Least and most of a row of the groups' numbers. */
static inline float least_of(const float *row, uint32_t count) {
  v_float least = v_set(row[0]);
  float rest = row[0];
  uint32_t i = 0;
  for (; i + V_LANES <= count; i += V_LANES)
    least = v_min(v_load(row + i), least);
  for (; i < count; i++)
    rest = s_min(row[i], rest);
  return s_min(rest, v_reduce_min(least));
}

static inline float most_of(const float *row, uint32_t count) {
  v_float most = v_set(row[0]);
  float rest = row[0];
  uint32_t i = 0;
  for (; i + V_LANES <= count; i += V_LANES)
    most = v_max(v_load(row + i), most);
  for (; i < count; i++)
    rest = s_max(row[i], rest);
  return s_max(rest, v_reduce_max(most));
}

static inline void packet_deepest(packet *p) {
  p->whole.deepest = most_of(p->groups.deepest, packet_groups(p));
}
