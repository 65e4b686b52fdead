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

#include "kernel/single.inl"

#include "kernel/packet.inl"

#include "kernel/lecture.inl"

#include "kernel/wide.inl"

/* Below this many rays of a class a packet costs more than it saves. */
#define PACKET_LEAST 4
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

/* The lanes of one group that are of a class. */
static inline uint32_t class_lanes(const ray_stream *rays, uint32_t at, uint32_t class) {
  const int k = (int)class / 8;
  const v_float nothing = v_set(0.0f), t_min = v_load(rays->t_min + at);
  const v_float longest = v_abs(v_load(rays->direction[k] + at));
  v_mask in = v_and(v_lt(t_min, v_load(rays->t + at)), v_le(nothing, t_min));
  for (int axis = 0; axis < 3; axis++) {
    const v_float d = v_load(rays->direction[axis] + at);
    const v_mask negative = v_lt(d, nothing);
    in = class >> axis & 1 ? v_and(in, negative) : v_andnot(in, negative);
    in = v_and(in, axis < k ? v_lt(v_abs(d), longest) : v_le(v_abs(d), longest));
  }
  return v_bits(in);
}

/* Whether rays first .. first + count are all of one class, as coherent packets mostly are. */
static bool one_class(const ray_stream *rays, uint32_t first, uint32_t count, uint32_t class) {
  for (uint32_t i = 0; i < count; i += V_LANES) {
    const uint32_t lanes = count - i < V_LANES ? count - i : V_LANES;
    const uint32_t all = (uint32_t)((1ull << lanes) - 1);
    if ((class_lanes(rays, first + i, class) & all) != all)
      return false;
  }
  return true;
}

/* Whether these rays fill their groups of lanes, so that no other packet's rays lie in them. */
static inline bool fills_groups(const ray_stream *rays, uint32_t first, uint32_t count) {
  return first % V_LANES == 0 && (count % V_LANES == 0 || first + count == rays->count);
}

/* The rays of a list, or with list NULL first .. first + count, without a packet. */
static void trace_alone(const trace_context *context, ray_stream *rays, const uint32_t *list,
                        uint32_t first, uint32_t count, bool any) {
  any ? wide_alone(context, rays, list, first, count, true, false)
      : wide_alone(context, rays, list, first, count, false, false);
}

/* False if the packet was given up. */
static bool traverse(const trace_context *context, packet *p, bool any) {
  if (context->mode == WHITTLE_LECTURE) {
    any ? lecture_traverse(context, p, true) : lecture_traverse(context, p, false);
    return true;
  }
  if (p->view == FROM_ORIGIN)
    return any ? wide_traverse(context, p, true, FROM_ORIGIN)
               : wide_traverse(context, p, false, FROM_ORIGIN);
  if (p->view == FROM_END)
    return wide_traverse(context, p, true, FROM_END);
  return any ? wide_traverse(context, p, true, NO_VIEW) : wide_traverse(context, p, false, NO_VIEW);
}

/* Ray by ray from where a packet was given up; neighbours will hardly do better. */
static void finish_alone(const trace_context *context, ray_stream *rays, packet *p,
                         bool consecutive, bool any) {
  const uint32_t *list = consecutive ? NULL : p->slot;
  p->alone = 3;
  any ? wide_alone(context, rays, list, p->slot[0], p->count, true, true)
      : wide_alone(context, rays, list, p->slot[0], p->count, false, true);
}

static void trace_class(const trace_context *context, ray_stream *rays, packet *p, uint32_t class,
                        uint32_t count, bool any, bool consecutive) {
  p->axis = (int)class / 8;
  for (int axis = 0; axis < 3; axis++)
    p->negative[axis] = class >> axis & 1;
  if (consecutive)
    packet_borrow(p, rays, count);
  else
    packet_gather(p, rays, count);
  packet_prepare(p, context->mode == WHITTLE_LECTURE, any);
  const bool done = traverse(context, p, any);
  if (!consecutive)
    packet_scatter(p, rays, any);
  if (!done)
    finish_alone(context, rays, p, consecutive, any);
}

static void trace_packet(const trace_context *context, ray_stream *rays, packet *p, uint32_t first,
                         uint32_t count, bool any) {
  const uint32_t least = context->mode == WHITTLE_LECTURE ? 1 : PACKET_LEAST;
  if (p->alone > 0) {
    p->alone--;
    trace_alone(context, rays, NULL, first, count, any);
    return;
  }
  const uint32_t class = ray_class(rays, first);
  if (class != RAY_ALONE && count >= least && fills_groups(rays, first, count) &&
      one_class(rays, first, count, class)) {
    p->slot[0] = first;
    trace_class(context, rays, p, class, count, any, true);
    return;
  }
  uint8_t classes[WHITTLE_MAX_PACKET];
  uint32_t sizes[RAY_CLASSES + 1] = {0};
  for (uint32_t i = 0; i < count; i++)
    sizes[classes[i] = (uint8_t)ray_class(rays, first + i)]++;
  for (uint32_t c = 0; c <= RAY_CLASSES; c++) {
    uint32_t members = 0;
    for (uint32_t i = 0; i < count && members < sizes[c]; i++)
      if (classes[i] == c)
        p->slot[members++] = first + i;
    if (members == 0)
      continue;
    if (c != RAY_ALONE && members >= least)
      trace_class(context, rays, p, c, members, any, false);
    else
      trace_alone(context, rays, p->slot, 0, members, any);
  }
}

static void trace_stream(const trace_context *context, ray_stream *rays, bool any) {
  if (context->scene->node_count == 0) {
    for (uint32_t i = 0; i < rays->count; i++) {
      rays->record[i] = WHITTLE_NONE;
      if (context->count)
        rays->nodes[i] = rays->triangles[i] = 0;
    }
  } else if (context->count) {
    for (uint32_t i = 0; i < rays->count; i++)
      any ? count_single(context, rays, i, true) : count_single(context, rays, i, false);
  } else if (context->mode == WHITTLE_SINGLE || context->packet <= 1) {
    trace_alone(context, rays, NULL, 0, rays->count, any);
  } else {
    packet p;
    p.alone = 0;
    for (uint32_t first = 0; first < rays->count; first += context->packet) {
      const uint32_t left = rays->count - first;
      trace_packet(context, rays, &p, first, left < context->packet ? left : context->packet, any);
    }
  }
}

static void kernel_closest(const trace_context *context, ray_stream *rays) {
  trace_stream(context, rays, false);
}

static void kernel_any(const trace_context *context, ray_stream *rays) {
  trace_stream(context, rays, true);
}
