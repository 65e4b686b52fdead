/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Which lane groups pass a triangle on the outside, for many groups at once. */

/* A line through the packet's point along d = (x, y, 1), in slopes, is on the side of a triangle's
 * edge that n . d tells, with n the cross product of the edge's ends. The exact test rejects lines
 * that are on different sides of two edges. A group does so as a whole where at its centre both are
 * farther from 0 than its size and all errors together may amount to. This holds for vertices on
 * either side of the point. */

/* The edges of a block's triangles, in units of those limits. */
typedef struct block_edges {
  bool made;
  float normal[3][3][VIEW_ROOM]; /* of each edge: times x, times y, and what is added */
} block_edges;

/* The middles of the groups' slopes, and the most that a ray of any group is beside them. */
static void prepare_centers(packet *p) {
  const int axes[2] = {p->order[0], p->order[1]};
  group_centers *c = &p->centers;
  for (int k = 0; k < 2; k++) {
    const float *low = p->groups.slope_min[axes[k]], *high = p->groups.slope_max[axes[k]];
    v_float most = v_set(0.0f);
    for (uint32_t g = 0; g < packet_groups(p); g += V_LANES) {
      const v_float from = v_load(low + g), to = v_load(high + g);
      v_store(c->at[k] + g, (from + to) * v_set(0.5f));
      most = v_max(to - from, most);
    }
    c->half[k] = v_reduce_max(most) * (0.5f + 0x1p-20f) + 0x1p-22f;
  }
  c->made = true;
}

/* How far a vertex may be beside the packet's rays on either axis. */
static inline v_float beside_rays(const packet *p, const v_float vertex[3], v_float sense) {
  v_float most = v_set(0.0f);
  for (int k = 0; k < 2; k++) {
    const v_float depth = vertex[2] * sense;
    const v_float low = v_set(p->whole.slope_min[p->order[k]]) * depth;
    const v_float high = v_set(p->whole.slope_max[p->order[k]]) * depth;
    most = v_max(v_max(v_abs(vertex[k] - low), v_abs(vertex[k] - high)), most);
  }
  return most;
}

static inline v_float largest_of(const v_float a[3]) {
  return v_max(v_max(v_abs(a[0]), v_abs(a[1])), v_abs(a[2]));
}

/* Rounding in terms of R, the farthest that vertices are from the point or from a ray's origin, A,
 * the farthest that they are beside the rays, and E, the longest edge, in units of 2^-24: sheared
 * vertices are off by 4 R, U, V and W thereby and by themselves by 32 R A; the normals here by 6 R
 * E in each component, and their products with d by 24 R E more. Lines that miss the point by
 * `spread` turn the normals by 6 spread E. */
#define EDGE_ROUNDING 0x1p-18f
#define EDGE_LEAST 0x1p-100f /* of numbers so small that rounding is not relative */

static inline void edges_lanes(const packet *p, const float *rows, uint32_t size, uint32_t at,
                               block_edges *edges) {
  const v_float sense = v_set(p->looks_negative ? -1.0f : 1.0f);
  v_float vertex[3][3], side[3][3];
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++)
      vertex[i][k] = v_load(rows + (3 * (uint32_t)i + (uint32_t)p->order[k]) * size + at) -
                     v_set(p->point[p->order[k]]);
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++)
      side[i][k] = vertex[(i + 1) % 3][k] - vertex[i][k];
  const v_float longest = v_max(largest_of(side[0]), largest_of(side[1])) * v_set(2.0f);
  const v_float reach = largest_of(vertex[0]) + longest + v_set(p->away);
  const v_float beside =
      beside_rays(p, vertex[0], sense) + longest * v_set(3.0f) + reach * v_set(0x1p-21f);
  const v_float turn = v_set(p->spread) * longest * v_set(8.0f);
  const v_float off = reach * (beside + v_set(p->spread)) * v_set(EDGE_ROUNDING) + turn;
  for (int i = 0; i < 3; i++) {
    const v_float *a = vertex[i], *e = side[i];
    const v_float x = a[1] * e[2] - a[2] * e[1], y = a[2] * e[0] - a[0] * e[2];
    const v_float z = a[0] * e[1] - a[1] * e[0];
    const v_float room =
        v_abs(x) * v_set(p->centers.half[0]) + v_abs(y) * v_set(p->centers.half[1]);
    const v_float unit = v_set(1.0f) / (room + off + v_set(EDGE_LEAST));
    v_store(&edges->normal[i][0][at], x * unit);
    v_store(&edges->normal[i][1][at], y * unit);
    v_store(&edges->normal[i][2][at], z * sense * unit);
  }
}

static __attribute__((noinline)) void make_edges(packet *p, const float *rows, uint32_t size,
                                                 block_edges *edges) {
  if (!p->centers.made)
    prepare_centers(p);
  for (uint32_t at = 0; at < size; at += V_LANES)
    edges_lanes(p, rows, size, at, edges);
  edges->made = true;
}

/* Of the groups from `g` on those that triangle i may meet, by its edges. */
static inline uint64_t groups_inside(const packet *p, const block_edges *edges, uint32_t i,
                                     uint32_t g, uint64_t groups) {
  const group_centers *c = &p->centers;
  const uint32_t left = packet_groups(p) - g, end = left < V_BYTES ? left : V_BYTES;
  v_float n[3][3];
  for (int e = 0; e < 3; e++)
    for (int k = 0; k < 3; k++)
      n[e][k] = v_set(edges->normal[e][k][i]);
  for (uint32_t from = 0; from < end; from += V_LANES) {
    const v_float x = v_load(c->at[0] + g + from), y = v_load(c->at[1] + g + from);
    v_float off[3];
    for (int e = 0; e < 3; e++)
      off[e] = v_fused(x, n[e][0], v_fused(y, n[e][1], n[e][2]));
    const v_float most = v_max(v_max(off[0], off[1]), off[2]);
    const v_float least = v_min(v_min(off[0], off[1]), off[2]);
    const v_mask outside = v_and(v_lt(v_set(1.0f), most), v_lt(least, v_set(-1.0f)));
    groups &= ~((uint64_t)v_bits(outside) << from);
  }
  return groups;
}

/* Triangles that cover fewer groups are tested at once. */
#define EDGES_WORTH 8

/* The pairs of triangle i with the groups that pass through its rectangle. */
static inline __attribute__((always_inline)) uint32_t
list_seen(packet *p, const float *rows, uint32_t size, const block_view *view, block_edges *edges,
          uint32_t i, pair *pairs, uint32_t n, const packet_view from) {
  for (uint32_t g = 0; g < packet_groups(p); g += V_BYTES) {
    uint64_t groups = groups_through(p, g, view, i);
    if (from == FROM_ORIGIN && __builtin_popcountll(groups) >= EDGES_WORTH) {
      if (!edges->made)
        make_edges(p, rows, size, edges);
      groups = groups_inside(p, edges, i, g, groups);
    }
    n = add_pairs(pairs, n, i, g, groups);
  }
  return n;
}

/* The pairs of triangle i that has no rectangle. */
static __attribute__((noinline)) uint32_t list_unsure(packet *p, const float *rows, uint32_t size,
                                                      block_edges *edges, uint32_t i, pair *pairs,
                                                      uint32_t n) {
  if (!edges->made)
    make_edges(p, rows, size, edges);
  for (uint32_t g = 0; g < packet_groups(p); g += V_BYTES)
    n = add_pairs(pairs, n, i, g, groups_inside(p, edges, i, g, groups_open(p, g)));
  return n;
}
