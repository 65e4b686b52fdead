/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What tests need of a packet: where it is seen from, its frustums, and its rays' numbers. */

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
  p->away = v_reduce_max(length) * 2.0f;
  p->spread = 2.0f * v_reduce_max(off) + reach * FRUSTUM_SLACK;
  return v_bits(same) == (uint32_t)((1ull << V_LANES) - 1) && reach <= FLT_MAX &&
         p->spread <= v_reduce_max(length) * END_SPREAD;
}

static packet_view choose_view(packet *p, bool any) {
  p->spread = p->away = 0.0f;
  p->looks_negative = p->negative[p->axis];
  if (p->one_origin || shares_origin(p)) {
    for (int axis = 0; axis < 3; axis++)
      p->point[axis] = p->origin[axis][0];
    return FROM_ORIGIN;
  }
  if (!any || !shares_end(p))
    return NO_VIEW;
  p->looks_negative = !p->negative[p->axis];
  return FROM_END;
}

/* What slab tests read. + 0 turns -0 into 0, which is what the octant takes it for. */
static void prepare_inverse(packet *p) {
  for (int axis = 0; axis < 3; axis++)
    for (uint32_t at = 0; at < p->count; at += V_LANES)
      v_store(&p->inverse[axis][at], v_set(1.0f) / (v_load(&p->direction[axis][at]) + v_set(0.0f)));
  p->has_inverse = true;
}

/* The ranges of the origins. */
static void prepare_origins(packet *p) {
  for (int axis = 0; axis < 3; axis++) {
    frustums *f = &p->groups;
    uint32_t g = 0;
    for (uint32_t at = 0; at < p->count; at += V_LANES, g++) {
      const v_float origin = v_load(&p->origin[axis][at]);
      f->origin_min[axis][g] = v_reduce_min(origin);
      f->origin_max[axis][g] = v_reduce_max(origin);
    }
    p->whole.origin_min[axis] = least_of(f->origin_min[axis], g);
    p->whole.origin_max[axis] = most_of(f->origin_max[axis], g);
  }
}

/* The same of a packet with a view; its groups are not asked for theirs. */
static void prepare_point(packet *p) {
  for (int axis = 0; axis < 3; axis++) {
    const float low = p->point[axis] - p->spread, high = p->point[axis] + p->spread;
    p->whole.origin_min[axis] = low, p->whole.origin_max[axis] = high;
  }
}

/* What the pass over all rays reads and writes, as values that the compiler can hold on to, and
 * what it tells of the rays' class. */
typedef struct slope_pass {
  const float *direction[3], *t_min, *t; /* in the order of the sheared space */
  float *shear[2];
  v_float view, forward; /* the senses of the view and of the rays along the axis: 1 or -1 */
  lane_bits turned[2];   /* the highest bit, where the packet's shears are negative */
  lane_bits signs;       /* with the highest bit where a sign is not that of the packet */
  v_mask in; /* lanes that are dead or may hit something, and look along the packet's axis */
} slope_pass;

static slope_pass slope_pass_of(packet *p) {
  const int k = p->order[2];
  slope_pass s = {.t_min = p->t_min, .t = p->t, .shear = {p->shear_x, p->shear_y}};
  s.view = v_set(p->looks_negative ? -1.0f : 1.0f),
  s.forward = v_set(p->negative[k] ? -1.0f : 1.0f);
  s.in = v_from_bits(UINT32_MAX);
  for (int i = 0; i < 3; i++)
    s.direction[i] = p->direction[p->order[i]];
  for (int i = 0; i < 2; i++)
    s.turned[i] = s.signs + ((uint32_t)(p->negative[p->order[i]] != p->negative[k]) << 31);
  return s;
}

/* The shears of a group, and in column i the rows that prepare_slopes reduces: least and most
 * slopes, and depths; those of which the most is wanted are turned round. */
static inline __attribute__((always_inline)) void
group_slopes(slope_pass *s, uint32_t at, v_float rows[5][V_LANES], uint32_t i) {
  const v_float depth = v_load(s->direction[2] + at), nothing = v_set(0.0f);
  const v_float t_min = v_load(s->t_min + at), t = v_load(s->t + at);
  for (int k = 0; k < 2; k++) {
    const v_float shear = v_load(s->direction[k] + at) / depth, slope = shear * s->view;
    v_store(s->shear[k] + at, shear);
    rows[2 * k][i] = slope, rows[2 * k + 1][i] = nothing - slope;
    s->signs |= (lane_bits)shear ^ s->turned[k];
  }
  rows[4][i] = nothing - t * v_abs(depth);
  s->signs |= (lane_bits)t_min;
  const v_mask open = v_or(v_lt(t_min, t), v_lt(t, v_set(-FLT_MAX))); /* or dead */
  s->in = v_and(s->in, v_and(open, v_lt(nothing, depth * s->forward)));
}

/* Whether all rays are of the packet's class. False also of some at its limits. */
static inline bool slopes_fit(const packet *p, const slope_pass *s) {
  const uint32_t every = (uint32_t)((1ull << V_LANES) - 1);
  bool in = (v_bits(s->in) & every) == every && lane_bits_any(s->signs) >> 31 == 0;
  for (int i = 0; i < 2; i++) {
    const float least = p->whole.slope_min[p->order[i]], most = p->whole.slope_max[p->order[i]];
    in = in && least > -1.0f && most < 1.0f;
    /* -0 is not negative. */
    in = in && (!p->negative[p->order[i]] || least > 0.0f || most < 0.0f);
  }
  return in;
}

/* Whether all rays are of the packet's class; if not, some numbers are not sound. */
static bool prepare_slopes(packet *p) {
  const int kx = p->order[0], ky = p->order[1], kz = p->order[2];
  const uint32_t groups = packet_groups(p);
  const v_float nothing = v_set(0.0f), one = v_set(1.0f);
  slope_pass s = slope_pass_of(p);
  frustums *f = &p->groups;
  for (uint32_t g = 0; g < groups; g += V_LANES) {
    v_float rows[5][V_LANES];
    if (g + V_LANES <= groups)
      for (uint32_t i = 0; i < V_LANES; i++)
        group_slopes(&s, (g + i) * V_LANES, rows, i);
    else
      for (uint32_t i = 0; i < V_LANES; i++)
        group_slopes(&s, (g + i < groups ? g + i : g) * V_LANES, rows, i);
    v_store(&f->slope_min[kx][g], v_least_of_rows(rows[0]));
    v_store(&f->slope_max[kx][g], nothing - v_least_of_rows(rows[1]));
    v_store(&f->slope_min[ky][g], v_least_of_rows(rows[2]));
    v_store(&f->slope_max[ky][g], nothing - v_least_of_rows(rows[3]));
    v_store(&f->slope_min[kz][g], one), v_store(&f->slope_max[kz][g], one);
    v_store(&f->deepest[g], (nothing - v_least_of_rows(rows[4])) * v_set(1.0f + FRUSTUM_SLACK));
  }
  for (int axis = 0; axis < 3; axis++) {
    p->whole.slope_min[axis] = least_of(f->slope_min[axis], groups);
    p->whole.slope_max[axis] = most_of(f->slope_max[axis], groups);
  }
  return slopes_fit(p, &s);
}

static inline v_float to_steps(v_float slope, float origin, float scale) {
  const v_float steps = (slope - v_set(origin)) * v_set(scale);
  return v_min(v_max(steps, v_set(0.0f)), v_set(STEPS));
}

static inline int16_t depth_step(float depth) {
  return (int16_t)(float_bits(depth) >> 16);
}

/* Takes over how deep the groups are. What was stored just now is slow to be read as vectors, so
 * this comes a block later: what is listed until then is a little more than need be. */
static inline void steps_deepest(packet *p) {
  for (uint32_t g = 0; g < packet_groups(p); g += V_BYTES)
    v_store_shorts(p->steps.deepest + g, p->groups.deepest + g);
  p->steps.behind = false;
}

static inline float steps_scale(float low, float high) {
  return STEPS / s_max(high - low, 0x1p-60f);
}

static void prepare_steps(packet *p) {
  const int x = v_next_axis[p->axis], y = v_next_axis[x];
  const frustums *f = &p->groups;
  group_steps *s = &p->steps;
  s->origin_x = p->whole.slope_min[x], s->origin_y = p->whole.slope_min[y];
  s->scale_x = steps_scale(s->origin_x, p->whole.slope_max[x]);
  s->scale_y = steps_scale(s->origin_y, p->whole.slope_max[y]);
  for (uint32_t g = 0; g < packet_groups(p); g += V_LANES) {
    v_store_bytes(s->low_x + g, to_steps(v_load(&f->slope_min[x][g]), s->origin_x, s->scale_x));
    v_store_bytes(s->high_x + g, to_steps(v_load(&f->slope_max[x][g]), s->origin_x, s->scale_x));
    v_store_bytes(s->low_y + g, to_steps(v_load(&f->slope_min[y][g]), s->origin_y, s->scale_y));
    v_store_bytes(s->high_y + g, to_steps(v_load(&f->slope_max[y][g]), s->origin_y, s->scale_y));
  }
  steps_deepest(p);
}

/* What hits leave undone: weights over determinants. A lane that was not hit since has 1. */
static void start_weights(packet *p) {
  for (uint32_t at = 0; at < p->count; at += V_LANES)
    v_store(&p->determinant[at], v_set(1.0f));
}

static void finish_weights(packet *p) {
  for (uint32_t at = 0; at < p->count; at += V_LANES) {
    const v_float determinant = v_load(&p->determinant[at]);
    v_store(&p->u[at], v_weight(v_load(&p->u[at]), determinant));
    v_store(&p->v[at], v_weight(v_load(&p->v[at]), determinant));
  }
}

/* Derives what the tests need of each ray, and the frustums. False if the rays may not all be of
 * the packet's class: then it is not to be traced, unless they are known to be. */
static bool packet_prepare(packet *p, bool lecture, bool any) {
  packet_pad(p);
  p->alive = p->count;
  for (uint32_t at = 0; at < p->count; at += V_LANES)
    v_storeu(&p->record[at], v_setu(WHITTLE_NONE));
  p->work = 0, p->has_inverse = p->centers.made = false;
  for (int k = 0, axis = p->axis; k < 3; k++)
    p->order[k] = axis = v_next_axis[axis];
  p->view = choose_view(p, any);
  if (lecture)
    p->view = NO_VIEW, p->looks_negative = p->negative[p->axis];
  const bool fits = prepare_slopes(p);
  packet_deepest(p);
  if (p->view == NO_VIEW) {
    prepare_origins(p);
    prepare_inverse(p);
  } else {
    prepare_point(p);
    prepare_steps(p);
  }
  return fits;
}
