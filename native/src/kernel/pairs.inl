/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The exact test of a block's triangles and the lane groups that may hit them. */

/* Triangle i of a block relative to the rays' origins. */
static inline __attribute__((always_inline)) v_relative block_relative(const v_ray *ray,
                                                                       const block_view *view,
                                                                       uint32_t i,
                                                                       const bool common) {
  v_relative r;
  for (uint32_t vertex = 0; vertex < 3; vertex++) {
    v_float *to[3] = {r.x, r.y, r.z};
    for (uint32_t k = 0; k < 3; k++) {
      to[k][vertex] = v_set(view->vertex[3 * vertex + k][i]);
      if (!common)
        to[k][vertex] = to[k][vertex] - ray->origin[k];
    }
  }
  return r;
}

/* A pair in which a line passes the triangle's edges. */
typedef struct passed_pair {
  v_edges edges;
  v_mask lanes;
  pair pair;
} passed_pair;

/* Keeps the pairs in which a line passes the edges; gives their number. */
static inline __attribute__((always_inline)) uint32_t
pass_edges(const packet *p, const block_view *view, const pair *pairs, uint32_t count,
           passed_pair *passed, const bool any, const bool common) {
  const packet_lanes lanes = packet_lanes_of(p);
  uint32_t kept = 0;
  for (uint32_t i = 0; i < count; i++) {
    const uint32_t at = pair_at(pairs[i]);
    const v_ray ray = lanes_ray(&lanes, at);
    const v_relative relative = block_relative(&ray, view, pair_index(pairs[i]), common);
    passed_pair *next = &passed[kept];
    const v_mask open = any ? lanes_open(&lanes, at) : v_from_bits(UINT32_MAX);
    next->lanes = v_edge_test(&ray, &relative, open, &next->edges);
    next->pair = pairs[i];
    kept += v_any(next->lanes);
  }
  return kept;
}

/* Decides pairs that have passed, of rays that begin anywhere. */
static inline __attribute__((always_inline)) bool
decide_pairs(const trace_context *context, packet *p, uint32_t first, uint32_t size,
             const block_view *view, const passed_pair *passed, uint32_t count, const bool any) {
  const float *rows = whittle_rows(&context->scene->triangles, first);
  const packet_lanes lanes = packet_lanes_of(p);
  uint32_t now = WHITTLE_NONE;
  bool changed = false;
  triangle_plane plane;
  for (uint32_t i = 0; i < count; i++) {
    const uint32_t index = pair_index(passed[i].pair), at = pair_at(passed[i].pair);
    if (index != now) {
      const triangle_record triangle = whittle_block_triangle(rows, size, index);
      plane = whittle_plane(&triangle), now = index;
    }
    const v_ray ray = lanes_ray(&lanes, at);
    const v_relative relative = block_relative(&ray, view, index, false);
    v_mask open = passed[i].lanes;
    if (any)
      open = v_and(open, lanes_open(&lanes, at));
    changed |= group_decide(context, p, at, &ray, &relative, &plane, &passed[i].edges, open,
                            first + index, any);
  }
  return changed;
}

/* The same of rays that begin at one point. */
static inline __attribute__((always_inline)) bool
decide_faces(const trace_context *context, packet *p, uint32_t first, uint32_t size,
             const block_view *view, const passed_pair *passed, uint32_t count, const bool any) {
  block_faces faces;
  bool changed = false;
  if (count == 0)
    return false;
  if (!p->has_inverse)
    prepare_inverse(p), start_weights(p);
  face_normals(p, whittle_rows(&context->scene->triangles, first), size, &faces);
  face_boxes(p, view, &faces);
  face_heights(view, &faces);
  const face_lanes lanes = face_lanes_of(p);
  for (uint32_t i = 0; i < count; i++) {
    const uint32_t index = pair_index(passed[i].pair);
    changed |= face_decide(context, p, &lanes, pair_at(passed[i].pair), &faces, index,
                           &passed[i].edges, passed[i].lanes, first + index, any);
  }
  return changed;
}

/* Tests the pairs of a block. */
static inline __attribute__((always_inline)) void
test_pairs(const trace_context *context, packet *p, uint32_t first, uint32_t size,
           const block_view *view, const pair *pairs, uint32_t count, passed_pair *passed,
           const bool any, const bool common) {
  const uint32_t kept = pass_edges(p, view, pairs, count, passed, any, common);
  if (p->steps.behind)
    steps_deepest(p);
  const bool changed = common ? decide_faces(context, p, first, size, view, passed, kept, any)
                              : decide_pairs(context, p, first, size, view, passed, kept, any);
  p->work += 2 * count;
  if (changed)
    packet_deepest(p), p->steps.behind = true;
}

/* The triangles of a block that a packet does not see. */
static inline uint32_t hidden(const trace_context *context, uint32_t first, uint32_t size) {
  uint32_t bits = 0;
  for (uint32_t i = 0; i < size; i++)
    bits |= (uint32_t)!sees(context, first + i) << i;
  return bits;
}

static inline __attribute__((always_inline)) void
wide_block(const trace_context *context, packet *p, uint32_t first, uint32_t size,
           passed_pair *passed, const bool any, const packet_view from) {
  const float *rows = whittle_rows(&context->scene->triangles, first);
  pair pairs[MOST_PAIRS + PAIRS_AT_ONCE];
  block_view view;
  block_edges edges;
  uint32_t n = 0, masked = context->masked ? hidden(context, first, size) : 0;
  const uint32_t shown = ((1u << size) - 1) & ~masked;
  view.seen = view.unsure = 0, edges.made = false;
  for (uint32_t at = 0; at < size; at += V_LANES)
    view_lanes(p, rows, size, at, &view, from);
  for (uint32_t seen = view.seen & shown; seen; seen &= seen - 1)
    n = list_seen(p, rows, size, &view, &edges, (uint32_t)__builtin_ctz(seen), pairs, n, from);
  for (uint32_t unsure = view.unsure & shown; unsure; unsure &= unsure - 1)
    n = list_unsure(p, rows, size, &edges, (uint32_t)__builtin_ctz(unsure), pairs, n);
  test_pairs(context, p, first, size, &view, pairs, n, passed, any, from == FROM_ORIGIN);
}
