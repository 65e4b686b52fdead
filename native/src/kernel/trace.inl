/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* A stream of rays to its hits: cuts packets, sorts them into classes and picks the traversal. */

static inline bool sees(const trace_context *context, uint32_t record) {
  const uint32_t instance = context->scene->triangles.ids[record].instance;
  return context->scene->instances[instance].visibility & context->visibility;
}

/* Whether a triangle wins over the one hit so far at equal t; a ray that has hit none ends at its
 * t_max, which is still a hit. */
static inline bool wins_tie(const triangle_store *store, uint32_t record, uint32_t other) {
#ifdef WHITTLE_BREAK_TIE
  (void)store, (void)record;
  return other == WHITTLE_NONE;
#else
  return other == WHITTLE_NONE || whittle_comes_first(store, record, other);
#endif
}

#include "kernel/prepared.inl"

#include "kernel/decide.inl"

#include "kernel/single.inl"

#include "kernel/packet.inl"

#include "kernel/prepare.inl"

#include "kernel/group.inl"

#include "kernel/lecture.inl"

#include "kernel/block.inl"

#include "kernel/edges.inl"

#include "kernel/faces.inl"

#include "kernel/pairs.inl"

#include "kernel/wide.inl"

#include "kernel/wide_ray.inl"

#include "kernel/generic_packet.inl"

#include "kernel/generic.inl"

/* Below this many rays of a class a packet costs more than it saves. */
#define PACKET_LEAST 4
#define VIEWLESS_LEAST 16
/* Dominant axis and octant: rays of a class meet a box's planes in the same order. */
#define RAY_CLASSES 24
#define RAY_ALONE RAY_CLASSES /* dead rays, and those that look behind themselves */

static inline uint32_t ray_class(const ray_stream *rays, uint32_t i) {
  if (!(rays->t[i] > rays->t_min[i] && rays->t_min[i] >= 0.0f))
    return RAY_ALONE;
  uint32_t octant = 0;
  float d[3];
  for (int axis = 0; axis < 3; axis++) {
    d[axis] = rays->direction[axis][i];
    octant |= (uint32_t)(d[axis] < 0.0f) << axis;
  }
  return (uint32_t)whittle_dominant_axis(d) * 8 + octant;
}

/* The same of V_LANES rays. */
static inline v_uint lane_classes(const ray_stream *rays, uint32_t at) {
  const v_float nothing = v_set(0.0f), t_min = v_load(rays->t_min + at);
  const v_uint none = v_setu(0);
  v_float size[3];
  v_uint octant = none;
  for (int axis = 0; axis < 3; axis++) {
    const v_float d = v_load(rays->direction[axis] + at);
    size[axis] = v_abs(d);
    octant = octant | v_selectu(v_lt(d, nothing), v_setu(1u << axis), none);
  }
  const v_mask x = v_and(v_le(size[1], size[0]), v_le(size[2], size[0]));
  const v_mask y = v_le(size[2], size[1]);
  const v_mask ahead = v_and(v_lt(t_min, v_load(rays->t + at)), v_le(nothing, t_min));
  const v_uint longest = v_selectu(x, none, v_selectu(y, v_setu(8), v_setu(16)));
  return v_selectu(ahead, octant | longest, v_setu(RAY_ALONE));
}

/* Whether these rays fill their groups of lanes, so that no other packet's rays lie in them. */
static inline bool fills_groups(const ray_stream *rays, uint32_t first, uint32_t count) {
  return first % V_LANES == 0 && (count % V_LANES == 0 || first + count == rays->count);
}

/* The rays of a list, or with list NULL first .. first + count, without a packet. */
static void trace_alone(const trace_context *context, ray_stream *rays, const uint32_t *list,
                        uint32_t first, uint32_t count, bool any) {
  wide_alone(context, rays, list, first, count, any, false);
}

/* False if the packet was given up, or has no view that the fast way could use. */
static bool traverse(const trace_context *context, packet *p, bool any) {
  if (context->mode == WHITTLE_LECTURE) {
    any ? lecture_traverse(context, p, true) : lecture_traverse(context, p, false);
    return true;
  }
  if (p->view == FROM_ORIGIN)
    return any ? wide_traverse(context, p, true, FROM_ORIGIN)
               : wide_traverse(context, p, false, FROM_ORIGIN);
  return p->view == FROM_END && wide_traverse(context, p, true, FROM_END);
}

/* Rays of one class: those of a list, or with list NULL first .. first + count. */
typedef struct ray_group {
  const uint32_t *list;
  uint32_t first, count, class;
} ray_group;

/* Packets larger than this are cut in four before their rays go alone. */
#define PACKET_SMALL 64

/* A packet, and what the ones before it have shown of the rays to come. */
typedef struct tracer {
  packet packet;
  uint32_t viewless;  /* rays that go without a view before the next small packet is tried */
  uint32_t quartered; /* large packets that are cut in four at once */
} tracer;

/* Makes a packet of a group; false if its rays may be of other classes. */
static bool make_packet(const trace_context *context, const ray_stream *rays, packet *p,
                        ray_group group, bool any, bool resume) {
  p->axis = (int)group.class / 8;
  for (int axis = 0; axis < 3; axis++)
    p->negative[axis] = group.class >> axis & 1;
  if (group.list)
    packet_gather(p, rays, group.list, group.count, any, resume);
  else
    packet_borrow(p, rays, group.first, group.count);
  return packet_prepare(p, context->mode == WHITTLE_LECTURE, any, resume);
}

/* Whether these rays may have a view, by the first and the last of them. */
static bool may_have_view(const ray_stream *rays, ray_group group, bool any) {
  const uint32_t last = group.count - 1;
  const uint32_t a = group.list ? group.list[0] : group.first;
  const uint32_t b = group.list ? group.list[last] : group.first + last;
  bool same = true;
  for (int axis = 0; axis < 3; axis++)
    same = same && rays->origin[axis][a] == rays->origin[axis][b];
  return same || (any && rays->t[a] == rays->t[b] && rays->t[a] <= FLT_MAX);
}

static void trace_viewless(const trace_context *context, ray_stream *rays, ray_group group,
                           bool any, bool resume) {
  trace_generic(context, rays, group.list, group.first, group.count, group.class, any, resume);
}

static void trace_class(const trace_context *context, ray_stream *rays, tracer *t, ray_group group,
                        bool any, bool resume);

/* The packet that was made of a group; if that has too little in common, its quarters, and at last
 * smaller ones that need no view, from where it was given up. Neighbours will hardly do better. */
static void trace_made(const trace_context *context, ray_stream *rays, tracer *t, ray_group group,
                       bool any) {
  const bool done = traverse(context, &t->packet, any);
  if (group.list)
    packet_scatter(&t->packet, rays, any);
  if (done)
    return;
  if (group.count <= PACKET_SMALL || t->packet.view == NO_VIEW) {
    t->viewless = 3 * group.count;
    trace_viewless(context, rays, group, any, true);
    return;
  }
  t->quartered = 3;
  const uint32_t step = (group.count / 4 + V_LANES - 1) / V_LANES * V_LANES;
  for (uint32_t at = 0; at < group.count; at += step) {
    ray_group part = group;
    part.list = group.list ? group.list + at : NULL, part.first += at;
    part.count = group.count - at < step ? group.count - at : step;
    trace_class(context, rays, t, part, any, true);
  }
}

/* Rays that are known to be of one class. */
static void trace_class(const trace_context *context, ray_stream *rays, tracer *t, ray_group group,
                        bool any, bool resume) {
  if (context->mode != WHITTLE_LECTURE && !may_have_view(rays, group, any)) {
    trace_viewless(context, rays, group, any, resume);
    return;
  }
  make_packet(context, rays, &t->packet, group, any, resume);
  trace_made(context, rays, t, group, any);
}

/* Rays of several classes, or that share lanes with others: a packet for each class; without
 * `views` one that needs none. */
static void trace_mixed(const trace_context *context, ray_stream *rays, tracer *t, uint32_t first,
                        uint32_t count, bool any, bool views) {
  const bool lecture = context->mode == WHITTLE_LECTURE;
  const uint32_t least = lecture ? 1 : views ? PACKET_LEAST : VIEWLESS_LEAST;
  const uint32_t before = first % V_LANES;
  uint32_t classes[WHITTLE_MAX_PACKET + 2 * V_LANES], list[WHITTLE_MAX_PACKET];
  uint32_t begin[RAY_CLASSES + 3] = {0};
  for (uint32_t i = 0; i < before + count; i += V_LANES)
    v_storeu(classes + i, lane_classes(rays, first - before + i));
  for (uint32_t i = 0; i < count; i++)
    begin[classes[before + i] + 2]++;
  for (uint32_t c = 2; c < RAY_CLASSES + 3; c++)
    begin[c] += begin[c - 1];
  for (uint32_t i = 0; i < count; i++)
    list[begin[classes[before + i] + 1]++] = first + i;
  for (uint32_t c = 0; c <= RAY_CLASSES; c++) {
    const ray_group group = {list + begin[c], 0, begin[c + 1] - begin[c], c};
    if (group.count == 0)
      continue;
    if (c == RAY_ALONE || group.count < least)
      trace_alone(context, rays, group.list, 0, group.count, any);
    else if (views)
      trace_class(context, rays, t, group, any, false);
    else
      trace_viewless(context, rays, group, any, false);
  }
}

static void trace_packet(const trace_context *context, ray_stream *rays, tracer *t, uint32_t first,
                         uint32_t count, bool any) {
  const bool lecture = context->mode == WHITTLE_LECTURE;
  const bool large = count > PACKET_SMALL && !lecture;
  const uint32_t class = ray_class(rays, first);
  const ray_group all = {NULL, first, count, class};
  if (!lecture && ((!large && t->viewless > 0) || !may_have_view(rays, all, any))) {
    t->viewless -= count < t->viewless ? count : t->viewless;
    trace_mixed(context, rays, t, first, count, any, false);
    return;
  }
  const bool cut = large && t->quartered > 0;
  if (!cut && class != RAY_ALONE && (count >= PACKET_LEAST || lecture) &&
      fills_groups(rays, first, count) && make_packet(context, rays, &t->packet, all, any, false)) {
    trace_made(context, rays, t, all, any);
    return;
  }
  if (!large) {
    trace_mixed(context, rays, t, first, count, any, true);
    return;
  }
  t->quartered -= cut;
  const uint32_t step = (count / 4 + V_LANES - 1) / V_LANES * V_LANES;
  for (uint32_t at = 0; at < count; at += step)
    trace_packet(context, rays, t, first + at, count - at < step ? count - at : step, any);
}

static void trace_stream(const trace_context *context, ray_stream *rays, bool any) {
  if (context->scene->triangle_count == 0) {
    for (uint32_t i = 0; i < rays->count; i++) {
      rays->record[i] = WHITTLE_NONE;
      if (context->count)
        rays->nodes[i] = rays->triangles[i] = 0;
    }
  } else if (context->count) {
    count_all(context, rays, any);
  } else if (context->mode == WHITTLE_SINGLE || context->packet <= 1) {
    trace_alone(context, rays, NULL, 0, rays->count, any);
  } else {
    tracer t;
    t.viewless = t.quartered = 0;
    for (uint32_t first = 0; first < rays->count; first += context->packet) {
      const uint32_t left = rays->count - first;
      trace_packet(context, rays, &t, first, left < context->packet ? left : context->packet, any);
    }
  }
}

static void kernel_closest(const trace_context *context, ray_stream *rays) {
  trace_stream(context, rays, false);
}

static void kernel_any(const trace_context *context, ray_stream *rays) {
  trace_stream(context, rays, true);
}
