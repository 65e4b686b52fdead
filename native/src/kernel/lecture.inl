/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The lecture's traversal: packets through the binary tree by first ray, frustum, brute force. */

/* Wald, Boulos, Shirley: Ray Tracing Deformable Scenes using Dynamic BVHs, TOG 2007. It counts what
 * each of the three tests decided, how many rays enter the nodes that their packets visit, and how
 * many lanes of the groups tested hold a ray that the test is for. */

/* Lanes of each group of a packet. */
typedef struct lecture_lanes {
  uint16_t group[WHITTLE_MAX_PACKET / V_LANES];
} lecture_lanes;

/* A node that waits to be visited; its parent was entered by the rays of `asking`, and by none
 * before `first`. */
typedef struct lecture_entry {
  uint32_t node, first;
  lecture_lanes asking;
} lecture_entry;

static inline bool lecture_frustum_reaches(const packet *p, const whittle_node *node) {
  const v_frustum f = frustum_everywhere(&p->whole);
  v_float low[3], high[3], depth;
  for (int axis = 0; axis < 3; axis++)
    low[axis] = v_set(node->bounds_min[axis]), high[axis] = v_set(node->bounds_max[axis]);
  return v_any(frustum_reaches(&f, p->axis, p->negative[p->axis], low, high, &depth));
}

/* Notes a test of a group, where the lanes of `asking` that have not found their end need it. */
static inline void lecture_count_lanes(const packet *p, uint32_t at, uint32_t asking,
                                       uint64_t *lanes, uint64_t *used) {
  const uint32_t open = v_bits(v_lt(v_load(&p->t_min[at]), v_load(&p->t[at])));
  *lanes += V_LANES;
  *used += (uint32_t)__builtin_popcount(asking & open);
}

/* The first ray from entry->first on that enters the node, or WHITTLE_NONE if none does; `entering`
 * becomes all those that do. */
static inline uint32_t lecture_first(const packet *p, const whittle_node *node,
                                     const lecture_entry *entry, lecture_lanes *entering,
                                     packet_counters *counters) {
  const uint32_t first = entry->first;
  uint32_t found = WHITTLE_NONE, active = 0;
  for (uint32_t at = first / V_LANES * V_LANES; at < p->count; at += V_LANES) {
    const uint32_t bits = group_enters(p, at, node->bounds_min, node->bounds_max);
    const uint32_t from_first = at < first ? bits >> (first - at) << (first - at) : bits;
    lecture_count_lanes(p, at, entry->asking.group[at / V_LANES], &counters->node_lanes,
                        &counters->node_lanes_used);
    entering->group[at / V_LANES] = (uint16_t)from_first;
    active += (uint32_t)__builtin_popcount(from_first);
    if (found == WHITTLE_NONE && from_first != 0)
      found = at + (uint32_t)__builtin_ctz(from_first);
  }
  counters->nodes++;
  if (found == first)
    counters->decided_first++;
  else if (!lecture_frustum_reaches(p, node))
    counters->decided_frustum++, found = WHITTLE_NONE;
  else
    counters->decided_brute_force++;
  if (found != WHITTLE_NONE)
    counters->active_rays += active, counters->visited_rays += p->count;
  return found;
}

static inline bool lecture_triangle(const trace_context *context, packet *p, uint32_t from,
                                    const uint32_t *enters, uint32_t record, const bool any) {
  const triangle_record triangle = whittle_take_triangle(&context->scene->triangles, record);
  const triangle_plane plane = whittle_plane(&triangle);
  const packet_lanes from_packet = packet_lanes_of(p);
  bool changed = false;
  for (uint32_t at = from; at < p->count; at += V_LANES) {
    if (enters[at / V_LANES] == 0)
      continue;
    const v_ray ray = lanes_ray(&from_packet, at);
    const v_relative relative = v_relate(&ray, &triangle);
    v_edges edges;
    const v_mask open = v_and(lanes_open(&from_packet, at), v_from_bits(enters[at / V_LANES]));
    lecture_count_lanes(p, at, enters[at / V_LANES], &context->packets->triangle_lanes,
                        &context->packets->triangle_lanes_used);
    const v_mask lanes = v_edge_test(&ray, &relative, open, &edges);
    changed |= v_any(lanes) &&
               group_decide(context, p, at, &ray, &relative, &plane, &edges, lanes, record, any);
  }
  return changed;
}

static inline void lecture_leaf(const trace_context *context, packet *p, const whittle_node *leaf,
                                uint32_t first, const bool any) {
  const uint32_t from = first / V_LANES * V_LANES;
  uint32_t enters[WHITTLE_MAX_PACKET / V_LANES];
  bool changed = false;
  for (uint32_t at = from; at < p->count; at += V_LANES)
    enters[at / V_LANES] = group_enters(p, at, leaf->bounds_min, leaf->bounds_max);
  for (uint32_t record = leaf->left_first; record < leaf->left_first + leaf->count; record++)
    if (!context->masked || sees(context, record))
      changed |= lecture_triangle(context, p, from, enters, record, any);
  if (changed)
    packet_deepest(p);
}

/* Whether the first ray meets the left child before the right one. */
static inline bool left_first(const packet *p, uint32_t first, const whittle_node *left) {
  const whittle_node *right = left + 1;
  float along = 0.0f;
  for (int axis = 0; axis < 3; axis++) {
    const float apart = (right->bounds_min[axis] + right->bounds_max[axis]) -
                        (left->bounds_min[axis] + left->bounds_max[axis]);
    along += apart * p->direction[axis][first];
  }
  return along >= 0.0f;
}

/* Adds what the packet's nodes had of active rays to the pixels of all its rays. */
static void lecture_share(const ray_watch *watch, const packet *p, uint64_t active,
                          uint64_t visited) {
  for (uint32_t k = 0; k < p->count; k++) {
    packet_share *share = &watch->shares[watch->slot[p->list ? p->list[k] : p->first + k]];
    share->active += active, share->visited += visited;
  }
}

/* The root's entry: every ray asks. */
static inline void lecture_begin(const packet *p, lecture_entry *root) {
  root->node = root->first = 0;
  for (uint32_t at = 0; at < p->count; at += V_LANES) {
    const uint32_t rays = p->count - at < V_LANES ? p->count - at : V_LANES;
    root->asking.group[at / V_LANES] = (uint16_t)((1u << rays) - 1);
  }
}

/* Puts a node on the stack for the rays that entered its parent, the first of them `first`. */
static inline void lecture_push(const packet *p, lecture_entry *entry, uint32_t node,
                                uint32_t first, const lecture_lanes *asking) {
  entry->node = node, entry->first = first;
  const uint32_t from = first / V_LANES;
  memcpy(&entry->asking.group[from], &asking->group[from],
         (packet_groups(p) - from) * sizeof asking->group[0]);
}

static void lecture_traverse(const trace_context *context, packet *p, const bool any) {
  const whittle_node *nodes = context->scene->nodes;
  lecture_entry stack[WHITTLE_STACK];
  lecture_lanes entering;
  uint32_t depth = 0;
  const packet_counters before = *context->packets;
  context->packets->packets++;
  context->packets->rays += p->count;
  lecture_begin(p, &stack[depth++]);
  while (depth > 0 && p->alive > 0) {
    const lecture_entry *entry = &stack[--depth];
    const whittle_node *node = &nodes[entry->node];
    const uint32_t first = lecture_first(p, node, entry, &entering, context->packets);
    if (first == WHITTLE_NONE)
      continue;
    if (node->count > 0) {
      lecture_leaf(context, p, node, first, any);
      continue;
    }
    const uint32_t left = node->left_first;
    const uint32_t near = left_first(p, first, &nodes[left]) ? left : left + 1;
    lecture_push(p, &stack[depth++], 2 * left + 1 - near, first, &entering);
    lecture_push(p, &stack[depth++], near, first, &entering);
  }
  if (context->watch != NULL && context->watch->shares != NULL)
    lecture_share(context->watch, p, context->packets->active_rays - before.active_rays,
                  context->packets->visited_rays - before.visited_rays);
}
