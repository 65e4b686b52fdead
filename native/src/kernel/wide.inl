/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Packets on the tree with eight children. */

/* A node's children are tested against the frustum of the whole packet, several at once. A packet
 * that has a view needs no test of single rays before the triangles: block.inl finds the lane
 * groups that a triangle covers. */

#define WIDE_LANES (V_LANES < WHITTLE_WIDTH ? V_LANES : WHITTLE_WIDTH)
#define WIDE_STACK (WHITTLE_STACK * (WHITTLE_WIDTH - 1))

/* What a packet may cost for each of its rays: tests of lane groups, counted twice, and, to find
 * nearest hits, visits to leaves, in those that a ray alone would visit. Beyond that its rays have
 * too little in common; and from less on packets without a view are as fast. */
#define WORK_PER_RAY 24
#define LEAVES_PER_LEAF 2
#define WORK_PER_BLOCKED_RAY 16
#define WORK_WORTH_A_VIEW 12
#define LEAVES_WORTH_A_VIEW 1

/* Larger packets of several classes are cut in four, and only what larger ones cost tells of those
 * to come. */
#define PACKET_SMALL 64

/* How many leaves a ray visits that shares nothing: at least 1, until more is known. */
static inline float leaves_alone(const packet_memory *memory) {
  return memory->leaves > memory->rays ? (float)memory->leaves / (float)memory->rays : 1.0f;
}

typedef struct wide_entry {
  wide_child child;
  float front; /* where the packet or ray comes to it */
} wide_entry;

/* Four lines: a node, or seven triangles of a leaf. A loop by size would be mispredicted. */
static inline void wide_prefetch(const whittle_scene *scene, wide_child child) {
  const char *first = wide_is_leaf(child)
                          ? (const char *)whittle_rows(&scene->triangles, child.first)
                          : (const char *)&scene->wide[child.first];
  whittle_prefetch(first), whittle_prefetch(first + 64);
  whittle_prefetch(first + 128), whittle_prefetch(first + 192);
}

/* Pushes the children in `reach`, if `sorted` the farthest first; gives the new height of the
 * stack.
 */
static inline uint32_t wide_push(const whittle_scene *scene, const wide_node *node, uint32_t reach,
                                 const float front[], wide_entry *stack, uint32_t height,
                                 const bool sorted) {
  const uint32_t bottom = height;
  for (; reach; reach &= reach - 1) {
    const uint32_t i = (uint32_t)__builtin_ctz(reach);
    const wide_child child = node->child[i];
    const float at_front = front[i];
    wide_prefetch(scene, child);
    uint32_t at = height++;
    for (; sorted && at > bottom && stack[at - 1].front < at_front; at--)
      stack[at] = stack[at - 1];
    stack[at].child = child, stack[at].front = at_front;
  }
  return height;
}

/* ---- Packets
 * ---------------------------------------------------------------------------------------- */

/* The children that the packet's frustum reaches, and the depths where. */
static inline uint32_t wide_reach(const packet *p, const v_frustum *f, const wide_node *node,
                                  float front[]) {
  uint32_t reach = 0;
  for (uint32_t i = 0; i < WHITTLE_WIDTH; i += WIDE_LANES) {
    v_float low[3], high[3], depth;
    for (int axis = 0; axis < 3; axis++)
      low[axis] = v_load(&node->low[axis][i]), high[axis] = v_load(&node->high[axis][i]);
    const v_mask bits = frustum_reaches(f, p->axis, p->looks_negative, low, high, &depth);
    reach |= v_bits(bits) << i;
    v_store(front + i, depth);
  }
  return reach & ((1u << WHITTLE_WIDTH) - 1);
}

/* The same of a packet with a view, for nodes that are not small beside the scene. */
static inline uint32_t wide_reach_quickly(const packet *p, const point_frustum *f,
                                          const wide_node *node, float front[]) {
  uint32_t reach = 0;
  for (uint32_t i = 0; i < WHITTLE_WIDTH; i += WIDE_LANES) {
    v_float depth;
    reach |= v_bits(point_frustum_reaches(f, (const float *)node + i, p->whole.deepest, &depth))
             << i;
    v_store(front + i, depth);
  }
  return reach & ((1u << WHITTLE_WIDTH) - 1);
}

static inline point_frustum wide_planes(const packet *p) {
  uint32_t low[3], high[3];
  for (uint32_t axis = 0; axis < 3; axis++) {
    low[axis] = (uint32_t)(offsetof(wide_node, low) / sizeof(float)) + axis * WHITTLE_WIDTH;
    high[axis] = (uint32_t)(offsetof(wide_node, high) / sizeof(float)) + axis * WHITTLE_WIDTH;
  }
  return point_frustum_of(&p->whole, p->point, p->spread, p->order, p->looks_negative, low, high);
}

/* The children that are to lie below child i on a stack, the farthest first: those that begin
 * behind it, or with it and come before it in the node. */
static inline uint32_t wide_deeper(const float front[], uint32_t i) {
  const v_float own = v_set(front[i]);
  uint32_t deeper = 0, even = 0;
  for (uint32_t k = 0; k < WHITTLE_WIDTH; k += WIDE_LANES) {
    deeper |= v_bits(v_lt(own, v_load(front + k))) << k;
    even |= v_bits(v_eq(own, v_load(front + k))) << k;
  }
  return deeper | (even & ((1u << i) - 1));
}

/* Pushes the children in `reach`, the farthest first: each goes to where its rank is, so that
 * nothing is to be foreseen but their number. */
static inline uint32_t wide_push_ranked(const whittle_scene *scene, const wide_node *node,
                                        uint32_t reach, const float front[], wide_entry *stack,
                                        uint32_t height) {
  for (uint32_t rest = reach; rest; rest &= rest - 1) {
    const uint32_t i = (uint32_t)__builtin_ctz(rest);
    const uint32_t below = wide_deeper(front, i) & reach;
    wide_prefetch(scene, node->child[i]);
    stack[height + (uint32_t)__builtin_popcount(below)] = (wide_entry){node->child[i], front[i]};
  }
  return height + (uint32_t)__builtin_popcount(reach);
}

static inline __attribute__((always_inline)) void wide_leaf(const trace_context *context, packet *p,
                                                            uint32_t first, uint32_t count,
                                                            passed_pair *passed, const bool any,
                                                            const packet_view from) {
  for (uint32_t part = 0; part < count; part += WHITTLE_BLOCK) {
    const uint32_t left = count - part;
    wide_block(context, p, first + part, left < WHITTLE_BLOCK ? left : WHITTLE_BLOCK, passed, any,
               from);
  }
}

/* False if the packet came to no end within its budget; what it found until then holds. */
static inline __attribute__((always_inline)) bool
packet_descend(const trace_context *context, packet *p, const bool any, const packet_view from) {
  const whittle_scene *scene = context->scene;
  wide_entry stack[WIDE_STACK];
  float front[WHITTLE_WIDTH + V_LANES];
  passed_pair passed[MOST_PAIRS];
  uint32_t height = 1;
  const point_frustum planes = wide_planes(p);
  const float alone = any ? 1.0f : leaves_alone(context->memory), rays = (float)p->count;
  const float work = any ? WORK_PER_BLOCKED_RAY : WORK_PER_RAY * alone;
  const uint32_t most_work = (uint32_t)s_min(work * rays, 0x1p30f);
  const bool counted = !any && p->count > PACKET_SMALL;
  const uint32_t most_leaves =
      counted ? (uint32_t)s_min(LEAVES_PER_LEAF * alone * rays, 0x1p30f) : UINT32_MAX;
  p->leaves = 0;
  stack[0] = (wide_entry){.child = {0, WIDE_NODE}};
  while (height > 0 && p->alive > 0) {
    const wide_entry entry = stack[--height];
    if (entry.front > p->whole.deepest)
      continue;
    if (p->work > most_work || p->leaves > most_leaves)
      return false;
    if (wide_is_leaf(entry.child)) {
      p->leaves++;
      wide_leaf(context, p, entry.child.first, entry.child.count, passed, any, from);
      continue;
    }
    const wide_node *node = &scene->wide[entry.child.first];
    uint32_t reach;
    if (entry.child.count == WIDE_NODE) {
      reach = wide_reach_quickly(p, &planes, node, front);
    } else {
      const v_frustum f = frustum_everywhere(&p->whole);
      reach = wide_reach(p, &f, node, front);
    }
    height = any ? wide_push(scene, node, reach, front, stack, height, false)
                 : wide_push_ranked(scene, node, reach, front, stack, height);
  }
  return true;
}

static inline __attribute__((always_inline)) bool
wide_traverse(const trace_context *context, packet *p, const bool any, const packet_view from) {
  const bool done = packet_descend(context, p, any, from);
  if (from == FROM_ORIGIN && !any && p->has_inverse)
    finish_weights(p);
  return done;
}
