/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* A stream of rays to its hits: cuts packets, sorts them into classes and picks the traversal. */

static inline bool sees(const trace_context *context, const triangle_record *triangle) {
  return context->scene->instances[triangle->instance].visibility & context->visibility;
}

#include "kernel/single.inl"

#include "kernel/packet.inl"

/* Below this many rays of a class a packet costs more than it saves. */
#define PACKET_LEAST 4
#define RAY_CLASSES 6 /* dominant axis and its sign; dead rays have none */

static inline uint32_t ray_class(const ray_stream *rays, uint32_t i) {
  if (!(rays->t[i] > rays->t_min[i]))
    return RAY_CLASSES;
  const float d[3] = {rays->direction[0][i], rays->direction[1][i], rays->direction[2][i]};
  const int axis = whittle_dominant_axis(d);
  return (uint32_t)axis * 2 + (d[axis] < 0.0f);
}

/* The lanes of one group that are alive and in the class of direction axis `axis` and its sign. */
static inline uint32_t class_lanes(const ray_stream *rays, uint32_t at, int axis, bool negative) {
  const v_float x = v_abs(v_load(rays->direction[axis] + at));
  v_mask in = v_lt(v_load(rays->t_min + at), v_load(rays->t + at));
  for (int other = 0; other < 3; other++) {
    const v_float y = v_abs(v_load(rays->direction[other] + at));
    if (other < axis)
      in = v_and(in, v_lt(y, x));
    else if (other > axis)
      in = v_and(in, v_le(y, x));
  }
  const v_float d = v_load(rays->direction[axis] + at);
  return v_bits(negative ? v_and(in, v_lt(d, v_set(0.0f))) : v_andnot(in, v_lt(d, v_set(0.0f))));
}

/* Whether rays first .. first + count are all of one class, as coherent packets mostly are. */
static bool one_class(const ray_stream *rays, uint32_t first, uint32_t count, uint32_t class) {
  for (uint32_t i = 0; i < count; i += V_LANES) {
    const uint32_t lanes = count - i < V_LANES ? count - i : V_LANES;
    const uint32_t all = lanes == 32 ? UINT32_MAX : (1u << lanes) - 1;
    if ((class_lanes(rays, first + i, (int)class / 2, class & 1) & all) != all)
      return false;
  }
  return true;
}

static void trace_class(const trace_context *context, ray_stream *rays, packet *p, uint32_t class,
                        uint32_t count, bool any, bool consecutive) {
  if (count < PACKET_LEAST && context->mode != WHITTLE_LECTURE) {
    for (uint32_t i = 0; i < count; i++)
      any ? single_trace(context, rays, p->slot[i], true, false)
          : single_trace(context, rays, p->slot[i], false, false);
    return;
  }
  p->axis = (int)class / 2;
  packet_load(p, rays, count, consecutive);
  packet_prepare(p);
  if (p->frustum.valid)
    packet_deepest(p);
  if (context->mode == WHITTLE_LECTURE) {
    context->packets->packets++;
    context->packets->rays += count;
    any ? packet_traverse(context, p, true, true) : packet_traverse(context, p, false, true);
  } else {
    any ? packet_traverse(context, p, true, false) : packet_traverse(context, p, false, false);
  }
  packet_save(p, rays, any, consecutive);
}

static void trace_packet(const trace_context *context, ray_stream *rays, uint32_t first,
                         uint32_t count, bool any) {
  packet p;
  const uint32_t class = ray_class(rays, first);
  if (class < RAY_CLASSES && one_class(rays, first, count, class)) {
    p.slot[0] = first;
    if (count < PACKET_LEAST)
      for (uint32_t i = 0; i < count; i++)
        p.slot[i] = first + i;
    trace_class(context, rays, &p, class, count, any, true);
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
        p.slot[members++] = first + i;
    if (c < RAY_CLASSES && members > 0)
      trace_class(context, rays, &p, c, members, any, false);
    else
      for (uint32_t i = 0; i < members; i++)
        rays->record[p.slot[i]] = WHITTLE_NONE;
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
      any ? single_trace(context, rays, i, true, true) : single_trace(context, rays, i, false, true);
  } else if (context->mode == WHITTLE_SINGLE || context->packet <= 1) {
    for (uint32_t i = 0; i < rays->count; i++)
      any ? single_trace(context, rays, i, true, false) : single_trace(context, rays, i, false, false);
  } else {
    for (uint32_t first = 0; first < rays->count; first += context->packet) {
      const uint32_t left = rays->count - first;
      trace_packet(context, rays, first, left < context->packet ? left : context->packet, any);
    }
  }
}

static void kernel_closest(const trace_context *context, ray_stream *rays) {
  trace_stream(context, rays, false);
}

static void kernel_any(const trace_context *context, ray_stream *rays) {
  trace_stream(context, rays, true);
}
