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

#include "kernel/generic_few.inl"

#include "kernel/generic_walk.inl"

/* Below this many rays of a class a packet costs more than it saves. */
#define PACKET_LEAST 4
#define VIEWLESS_LEAST 16
/* Dominant axis and octant: rays of a class meet a box's planes in the same order. */
#define RAY_CLASSES 24
#define RAY_ALONE RAY_CLASSES /* dead rays, and those that look behind themselves */
#define RAY_TAKEN (RAY_ALONE + 1)

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

/* So many packets' rays go without a view after one for which it did not pay; twice as many each
 * time that the next one tried is of the kind, up to 2^6 times. */
#define VIEWLESS_FIRST 4
#define VIEWLESS_DOUBLINGS 6

/* Makes a packet of a group; false if its rays may be of other classes. */
static bool make_packet(const trace_context *context, const ray_stream *rays, packet *p,
                        ray_group group, bool any) {
  p->axis = (int)group.class / 8;
  for (int axis = 0; axis < 3; axis++)
    p->negative[axis] = group.class >> axis & 1;
  if (group.list)
    packet_gather(p, rays, group.list, group.count);
  else
    packet_borrow(p, rays, group.first, group.count);
  return packet_prepare(p, context->mode == WHITTLE_LECTURE, any);
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

/* Neighbours will hardly do better or worse than a packet did, unless it was a rest of few rays. */
static void remember(packet_memory *memory, const packet *p, bool done, bool any) {
  const float rays = (float)p->count;
  const bool hard = any ? (float)p->work > WORK_WORTH_A_VIEW * rays
                        : (float)p->leaves > LEAVES_WORTH_A_VIEW * leaves_alone(memory) * rays;
  if (done && !hard) {
    memory->doublings = 0;
    return;
  }
  memory->viewless = (VIEWLESS_FIRST * p->count) << memory->doublings;
  memory->doublings += memory->doublings < VIEWLESS_DOUBLINGS;
}

/* Rays of one class without a view; with `resume` they go on from what they have hit. */
static void trace_generic(const trace_context *context, ray_stream *rays, ray_group group, bool any,
                          bool resume) {
  generic_jobs jobs;
  jobs.count = 0;
  generic_add(&jobs, group.list, group.first, group.count, group.class);
  generic_trace(context, rays, &jobs, any, resume);
}

/* The packet that was made of a group; if that has too little in common, smaller ones that need no
 * view, from where it was given up. */
static void trace_made(const trace_context *context, ray_stream *rays, packet *p, ray_group group,
                       bool any) {
  const bool done = traverse(context, p, any);
  if (group.list)
    packet_scatter(p, rays, any);
  if (p->view != NO_VIEW && p->count > PACKET_SMALL)
    remember(context->memory, p, done, any);
  if (!done)
    trace_generic(context, rays, group, any, true);
}

/* Rays that are known to be of one class. */
static void trace_class(const trace_context *context, ray_stream *rays, packet *p, ray_group group,
                        bool any) {
  if (context->mode != WHITTLE_LECTURE && !may_have_view(rays, group, any)) {
    trace_generic(context, rays, group, any, false);
    return;
  }
  make_packet(context, rays, p, group, any);
  trace_made(context, rays, p, group, any);
}

/* Rays by class, and where each class begins. */
typedef struct sorted_rays {
  uint32_t class[WHITTLE_MAX_PACKET + 2 * V_LANES];
  uint32_t list[WHITTLE_MAX_PACKET], begin[RAY_TAKEN + 3];
} sorted_rays;

static void find_classes(sorted_rays *sorted, const ray_stream *rays, uint32_t first,
                         uint32_t count) {
  for (uint32_t i = 0; i < first % V_LANES + count; i += V_LANES)
    v_storeu(sorted->class + i, lane_classes(rays, first - first % V_LANES + i));
}

/* Packets of rays that stand next to each other, which need not be sorted. */
static void take_runs(sorted_rays *sorted, uint32_t first, uint32_t count, generic_jobs *jobs) {
  if (first % V_LANES != 0)
    return;
  for (uint32_t at = 0; at + GENERIC_RAYS <= count; at += GENERIC_RAYS) {
    const uint32_t class = sorted->class[at];
    v_uint differs = v_setu(0);
    for (uint32_t i = 0; i < GENERIC_RAYS; i += V_LANES)
      differs = differs | (v_loadu(sorted->class + at + i) ^ v_setu(class));
    if (class == RAY_ALONE || v_bits(v_equ(differs, v_setu(0))) != (1ull << V_LANES) - 1)
      continue;
    generic_add(jobs, NULL, first + at, GENERIC_RAYS, class);
    for (uint32_t i = 0; i < GENERIC_RAYS; i += V_LANES)
      v_storeu(sorted->class + at + i, v_setu(RAY_TAKEN));
  }
}

static void sort_classes(sorted_rays *sorted, uint32_t first, uint32_t count) {
  const uint32_t *class = sorted->class + first % V_LANES;
  uint32_t *begin = sorted->begin;
  memset(begin, 0, sizeof sorted->begin);
  for (uint32_t i = 0; i < count; i++)
    begin[class[i] + 2]++;
  for (uint32_t c = 2; c < RAY_TAKEN + 3; c++)
    begin[c] += begin[c - 1];
  for (uint32_t i = 0; i < count; i++)
    sorted->list[begin[class[i] + 1]++] = first + i;
}

/* Rays of several classes, or that share lanes with others: packets for each class. */
static void trace_mixed(const trace_context *context, ray_stream *rays, packet *p, uint32_t first,
                        uint32_t count, bool any) {
  const uint32_t least = context->mode == WHITTLE_LECTURE ? 1 : PACKET_LEAST;
  sorted_rays sorted;
  find_classes(&sorted, rays, first, count);
  sort_classes(&sorted, first, count);
  for (uint32_t c = 0; c <= RAY_ALONE; c++) {
    const uint32_t begin = sorted.begin[c], here = sorted.begin[c + 1] - begin;
    const ray_group group = {sorted.list + begin, 0, here, c};
    if (here > 0 && (c == RAY_ALONE || here < least))
      trace_alone(context, rays, group.list, 0, here, any);
    else if (here > 0)
      trace_class(context, rays, p, group, any);
  }
}

/* Rays of any classes in packets without a view. */
static void trace_viewless(const trace_context *context, ray_stream *rays, uint32_t first,
                           uint32_t count, bool any) {
  generic_jobs jobs;
  jobs.count = 0;
  sorted_rays sorted;
  find_classes(&sorted, rays, first, count);
  take_runs(&sorted, first, count, &jobs);
  if (jobs.count * GENERIC_RAYS < count) {
    sort_classes(&sorted, first, count);
    for (uint32_t c = 0; c <= RAY_ALONE; c++) {
      const uint32_t *list = sorted.list + sorted.begin[c];
      const uint32_t here = sorted.begin[c + 1] - sorted.begin[c];
      if (c == RAY_ALONE || here < VIEWLESS_LEAST)
        trace_alone(context, rays, list, 0, here, any);
      else
        generic_add(&jobs, list, 0, here, c);
    }
  }
  generic_trace(context, rays, &jobs, any, false);
}

static void trace_packet(const trace_context *context, ray_stream *rays, packet *p, uint32_t first,
                         uint32_t count, bool any) {
  const bool lecture = context->mode == WHITTLE_LECTURE;
  const uint32_t class = ray_class(rays, first);
  const ray_group all = {NULL, first, count, class};
  packet_memory *memory = context->memory;
  if (!lecture && (memory->viewless > 0 || !may_have_view(rays, all, any))) {
    memory->viewless -= count < memory->viewless ? count : memory->viewless;
    trace_viewless(context, rays, first, count, any);
    return;
  }
  if (class != RAY_ALONE && (count >= PACKET_LEAST || lecture) &&
      fills_groups(rays, first, count) && make_packet(context, rays, p, all, any)) {
    trace_made(context, rays, p, all, any);
    return;
  }
  if (count <= PACKET_SMALL || lecture) {
    trace_mixed(context, rays, p, first, count, any);
    return;
  }
  const uint32_t step = (count / 4 + V_LANES - 1) / V_LANES * V_LANES;
  for (uint32_t at = 0; at < count; at += step)
    trace_packet(context, rays, p, first + at, count - at < step ? count - at : step, any);
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
    packet p;
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
