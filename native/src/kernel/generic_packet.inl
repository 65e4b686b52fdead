/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Packets of rays that share no more than their class: filling, the frustum, emptying. */

#define GENERIC_RAYS 32
#define GENERIC_GROUPS (GENERIC_RAYS / V_LANES)

typedef struct generic_room {
  float numbers[10][GENERIC_RAYS];
  uint32_t record[GENERIC_RAYS], skip[GENERIC_RAYS];
} generic_room;

typedef struct generic_packet {
  ray_stream rays; /* where they stand or in `room`; the first are the packet's */
  prepared_rays prepared[GENERIC_GROUPS];
  frustum whole;
  int axis;
  bool negative;            /* the sense in which they look along it */
  uint32_t near[3], far[3]; /* floats into a node: the bounds that they meet first and last */
  uint32_t alive;           /* the packet's rays, as bits, without those that are blocked */
  generic_room room;
} generic_packet;

/* As many rays as a packet has from `first` on, where they stand. */
static void generic_borrow(generic_packet *p, const ray_stream *rays, uint32_t first) {
  ray_stream *own = &p->rays;
  own->count = GENERIC_RAYS;
  for (int axis = 0; axis < 3; axis++) {
    own->origin[axis] = rays->origin[axis] + first;
    own->direction[axis] = rays->direction[axis] + first;
  }
  own->t_min = rays->t_min + first, own->t = rays->t + first;
  own->u = rays->u + first, own->v = rays->v + first;
  own->record = rays->record + first, own->skip = rays->skip + first;
}

/* Copies of the rays of a list, with `resume` also of what they have hit; what follows them is a
 * copy of the first. */
static void generic_gather(generic_packet *p, const ray_stream *rays, const uint32_t *list,
                           uint32_t count, bool resume) {
  generic_room *room = &p->room;
  ray_stream *own = &p->rays;
  own->count = GENERIC_RAYS;
  for (int axis = 0; axis < 3; axis++)
    own->origin[axis] = room->numbers[axis], own->direction[axis] = room->numbers[3 + axis];
  own->t_min = room->numbers[6], own->t = room->numbers[7];
  own->u = room->numbers[8], own->v = room->numbers[9];
  own->record = room->record, own->skip = room->skip;
  for (uint32_t i = 0; i < GENERIC_RAYS; i++) {
    const uint32_t from = list[i < count ? i : 0];
    for (int axis = 0; axis < 3; axis++) {
      own->origin[axis][i] = rays->origin[axis][from];
      own->direction[axis][i] = rays->direction[axis][from];
    }
    own->t_min[i] = rays->t_min[from], own->t[i] = rays->t[from];
    own->skip[i] = rays->skip[from];
  }
  for (uint32_t i = 0; resume && i < count; i++) {
    const uint32_t from = list[i];
    own->u[i] = rays->u[from], own->v[i] = rays->v[from], own->record[i] = rays->record[from];
  }
}

static void generic_scatter(const generic_packet *p, ray_stream *rays, const uint32_t *list,
                            uint32_t count) {
  const ray_stream *own = &p->rays;
  for (uint32_t i = 0; i < count; i++) {
    const uint32_t to = list[i];
    rays->record[to] = own->record[i];
    rays->t[to] = own->t[i], rays->u[to] = own->u[i], rays->v[to] = own->v[i];
  }
}

/* The least and the most of a row in the lanes of `live`, of which lane `one` is one. */
static inline void generic_range(const v_float row[GENERIC_GROUPS], uint32_t live, float one,
                                 float *least, float *most) {
  v_float low = v_set(one), high = low;
  for (uint32_t g = 0; g < GENERIC_GROUPS; g++) {
    const v_float x = v_select(v_from_bits(live >> g * V_LANES), row[g], v_set(one));
    low = v_min(x, low), high = v_max(x, high);
  }
  *least = v_reduce_min(low), *most = v_reduce_max(high);
}

static void generic_deepest(generic_packet *p) {
  v_float most = v_set(-__builtin_inff());
  for (uint32_t g = 0; g < GENERIC_GROUPS; g++) {
    const v_float d = v_abs(v_load(p->rays.direction[p->axis] + g * V_LANES));
    const v_float depth = v_load(p->rays.t + g * V_LANES) * d;
    most = v_max(v_select(v_from_bits(p->alive >> g * V_LANES), depth, most), most);
  }
  p->whole.deepest = v_reduce_max(most) * (1.0f + FRUSTUM_SLACK);
}

static void generic_frustum(generic_packet *p) {
  const int kz = p->axis, kx = v_next_axis[kz], ky = v_next_axis[kx];
  const uint32_t one = (uint32_t)__builtin_ctz(p->alive), lane = one % V_LANES;
  const prepared_rays *of_one = &p->prepared[one / V_LANES];
  const float sense = p->negative ? -1.0f : 1.0f;
  v_float row[GENERIC_GROUPS], slope_x[GENERIC_GROUPS], slope_y[GENERIC_GROUPS];
  frustum *f = &p->whole;
  for (int axis = 0; axis < 3; axis++) {
    for (uint32_t g = 0; g < GENERIC_GROUPS; g++)
      row[g] = v_load(p->rays.origin[axis] + g * V_LANES);
    generic_range(row, p->alive, p->rays.origin[axis][one], &f->origin_min[axis],
                  &f->origin_max[axis]);
  }
  for (uint32_t g = 0; g < GENERIC_GROUPS; g++) {
    slope_x[g] = v_load(p->prepared[g].shear_x) * v_set(sense);
    slope_y[g] = v_load(p->prepared[g].shear_y) * v_set(sense);
  }
  generic_range(slope_x, p->alive, of_one->shear_x[lane] * sense, &f->slope_min[kx],
                &f->slope_max[kx]);
  generic_range(slope_y, p->alive, of_one->shear_y[lane] * sense, &f->slope_min[ky],
                &f->slope_max[ky]);
  f->slope_min[kz] = f->slope_max[kz] = 1.0f;
  generic_deepest(p);
}

/* The first `count` rays are the packet's, all of `class`; without `resume` they have not hit
 * anything yet. */
static void generic_prepare(generic_packet *p, uint32_t count, uint32_t class, bool any,
                            bool resume) {
  const uint32_t low = offsetof(wide_node, low) / sizeof(float);
  const uint32_t high = offsetof(wide_node, high) / sizeof(float);
  p->axis = (int)class / 8;
  p->negative = class >> p->axis & 1;
  for (uint32_t i = 0; i < 3; i++) {
    const uint32_t swap = (class >> i & 1) * (high - low);
    p->near[i] = low + WHITTLE_WIDTH * i + swap, p->far[i] = high + WHITTLE_WIDTH * i - swap;
  }
  p->alive = (uint32_t)((1ull << count) - 1);
  for (uint32_t i = 0; !resume && i < GENERIC_RAYS; i += V_LANES)
    v_storeu(p->rays.record + i, v_setu(WHITTLE_NONE));
  for (uint32_t i = 0; resume && any && i < count; i++)
    p->alive &= ~((uint32_t)(p->rays.record[i] != WHITTLE_NONE) << i);
  for (uint32_t g = 0; g < GENERIC_GROUPS; g++)
    prepare_group(&p->rays, g, &p->prepared[g]);
  if (p->alive != 0)
    generic_frustum(p);
}

static inline __attribute__((always_inline)) v_ray generic_ray(const generic_packet *p,
                                                               uint32_t g) {
  v_ray ray;
  v_set_axes(&ray, p->axis);
  for (int i = 0; i < 3; i++) {
    ray.origin[i] = v_load(p->rays.origin[ray.axis[i]] + g * V_LANES);
    ray.inverse[i] = v_load(p->prepared[g].inverse[ray.axis[i]]);
  }
  ray.shear_x = v_load(p->prepared[g].shear_x), ray.shear_y = v_load(p->prepared[g].shear_y);
  ray.t_min = v_load(p->rays.t_min + g * V_LANES);
  return ray;
}
