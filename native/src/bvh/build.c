/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Growing the tree from the root: by tasks while spans are large, then by recursion.
 *
 * Nodes are numbered by places: a span of n fragments has room for the 2 (n - 1) nodes below it,
 * its two children first, then the left child's room, then the right one's. So a node's place
 * follows from the splits above it alone, never from who made it when; leaves of several triangles
 * leave gaps, which the layout closes. */

#include "base/memory.h"
#include "bvh/divide.h"
#include "bvh/layout.h"

#include <string.h>

/* Spans up to this are one worker's from here on down. */
enum { BLOCK = 2048 };

typedef struct builder {
  divide_context divide;
  pthread_mutex_t lock; /* of all below */
  segment_list list;
  whittle_node *pool; /* for nodes that find no room among the spare fragments */
  uint32_t pool_count;
  uint32_t depth;
} builder;

/* One worker within a block: nodes are counted from the block's first. */
typedef struct grower {
  const builder *b;
  uint32_t count, depth;
  bins bins;
  whittle_node nodes[2 * BLOCK];
} grower;

static uint64_t units(uint32_t count) {
  return count ? (uint64_t)count * (31 - (uint32_t)__builtin_clz(count)) : 0;
}

uint64_t whittle_bvh_units(uint64_t count) {
  return units((uint32_t)count);
}

static void set_node(whittle_node *node, const span *s, uint32_t left_first, uint32_t count) {
  _Alignas(16) float lo[4], hi[4];
  float4_store(lo, s->bounds.lo);
  float4_store(hi, s->bounds.hi);
  memcpy(node->bounds_min, lo, sizeof node->bounds_min);
  memcpy(node->bounds_max, hi, sizeof node->bounds_max);
  node->left_first = left_first;
  node->count = count;
}

/* Leaves keep their fragments in buffer 0. */
static void make_leaf(grower *g, const span *s) {
  const divide_context *c = &g->b->divide;
  set_node(s->node, s, s->first, s->count);
  if (s->buffer == 1)
    memcpy(c->buffer[0] + s->first, c->buffer[1] + s->first, s->count * sizeof(whittle_fragment));
  if (s->depth > g->depth)
    g->depth = s->depth;
}

/* Grows the whole subtree of a span. */
static void grow(grower *g, const span *s) {
  span children[2];
  if (!whittle_divide(&g->b->divide, &g->bins, s, children)) {
    make_leaf(g, s);
    return;
  }
  set_node(s->node, s, g->count, 0);
  children[0].node = &g->nodes[g->count];
  children[1].node = &g->nodes[g->count + 1];
  g->count += 2;
  grow(g, &children[0]);
  grow(g, &children[1]);
}

/* Nodes that were made together are kept, and this is where. */
static whittle_node *keep(builder *b, segment made, whittle_node *room, uint32_t depth) {
  pthread_mutex_lock(&b->lock);
  whittle_node *nodes = room ? room : b->pool + b->pool_count;
  b->pool_count += room ? 0 : made.count;
  made.nodes = nodes;
  if (made.count)
    b->list.segments[b->list.count++] = made;
  if (depth > b->depth)
    b->depth = depth;
  pthread_mutex_unlock(&b->lock);
  return nodes;
}

/* A block's fragments end in buffer 0, and then buffer 1 has room for as many nodes: enough if its
 * leaves hold two triangles or more on average. */
static void grow_block(builder *b, const span *s) {
  grower g;
  g.b = b;
  g.count = 0;
  g.depth = 0;
  grow(&g, s);
  if (s->node->count == 0)
    s->node->left_first = s->room;
  void *spare = b->divide.buffer[1] + s->first;
  const segment made = {.count = g.count, .place = s->room, .subtree = true};
  memcpy(keep(b, made, g.count <= s->count ? spare : NULL, g.depth), g.nodes,
         g.count * sizeof *g.nodes);
  whittle_advance(b->divide.team->state, units(s->count));
}

_Static_assert(sizeof(whittle_fragment) == sizeof(whittle_node), "one takes the other's room");

static void divide_span(builder *b, const span *s, span children[2]) {
  bins bins;
  if (s->count > DIVIDE_LARGE)
    whittle_divide_by_team(&b->divide, &bins, s, children);
  else
    whittle_divide(&b->divide, &bins, s, children);
}

/* Divides a span until what is left is a block, sharing out the larger sides. */
static void grow_span(void *context, const void *argument) {
  builder *b = context;
  whittle_team *team = b->divide.team;
  span s;
  memcpy(&s, argument, sizeof s);
  while (s.count > BLOCK) {
    span children[2];
    divide_span(b, &s, children);
    if (whittle_cancelled(team->state))
      return;
    whittle_node *pair = keep(b, (segment){.count = 2, .place = s.room}, NULL, 0);
    set_node(s.node, &s, s.room, 0);
    children[0].node = pair;
    children[1].node = pair + 1;
    children[0].room = s.room + 2;
    children[1].room = s.room + 2 * children[0].count;
    whittle_advance(team->state,
                    units(s.count) - units(children[0].count) - units(children[1].count));
    const uint32_t larger = children[0].count < children[1].count;
    if (!whittle_team_share(team, grow_span, b, &children[larger], sizeof(span)))
      grow_span(b, &children[larger]);
    s = children[1 - larger];
  }
  if (!whittle_cancelled(team->state))
    grow_block(b, &s);
}

typedef struct measure {
  builder *b;
  span *root;
} measure;

static void measure_piece(void *context, uint64_t begin, uint64_t end) {
  const measure *m = context;
  const whittle_fragment *fragments = m->b->divide.buffer[0];
  box4 bounds = box4_empty(), middles = box4_empty();
  for (uint64_t i = begin; i < end; i++) {
    const box4 box = fragment_box(&fragments[i]);
    const float4 middle = box4_middle(box);
    bounds = box4_union(bounds, box);
    middles = box4_union(middles, (box4){middle, middle});
  }
  pthread_mutex_lock(&m->b->lock);
  m->root->bounds = box4_union(m->root->bounds, bounds);
  m->root->middles = box4_union(m->root->middles, middles);
  pthread_mutex_unlock(&m->b->lock);
}

static whittle_status grow_tree(builder *b, uint32_t count, whittle_bvh *bvh,
                                whittle_error *error) {
  whittle_team *team = b->divide.team;
  span root = {.bounds = box4_empty(),
               .middles = box4_empty(),
               .node = &b->list.root,
               .room = 1,
               .count = count};
  measure m = {b, &root};
  whittle_team_for(team, count, DIVIDE_GRAIN, measure_piece, &m);
  if (!whittle_cancelled(team->state))
    grow_span(b, &root);
  whittle_team_finish(team);
  if (whittle_cancelled(team->state))
    return WHITTLE_CANCELLED;
  bvh->depth = b->depth;
  return whittle_layout(team, &b->list, b->divide.options.traversal_cost, bvh, error);
}

whittle_status whittle_bvh_build(whittle_team *team, whittle_fragment *fragments,
                                 whittle_fragment *spare, uint32_t count,
                                 const whittle_bvh_options *options, whittle_bvh *bvh,
                                 whittle_error *error) {
  memset(bvh, 0, sizeof *bvh);
  if (count == 0)
    return WHITTLE_OK;
  builder b = {.divide = {.team = team, .options = *options, .buffer = {fragments, spare}}};
  if (b.divide.options.max_depth == 0)
    b.divide.options.max_depth = WHITTLE_MAX_DEPTH;
  /* At most count / BLOCK spans above BLOCK at each depth, each with a pair and two blocks. */
  const size_t segments = 3 * WHITTLE_MAX_DEPTH * (size_t)(count / BLOCK) + 1;
  b.divide.piece_counts =
      whittle_allocate(whittle_piece_counts(count, options->bins), sizeof(int32_t));
  b.pool = whittle_allocate(2 * (size_t)count, sizeof(whittle_node));
  b.list.segments = whittle_allocate(segments, sizeof(segment));
  pthread_mutex_init(&b.divide.lock, NULL);
  pthread_mutex_init(&b.lock, NULL);
  whittle_status status;
  if (b.divide.piece_counts && b.pool && b.list.segments)
    status = grow_tree(&b, count, bvh, error);
  else
    status = whittle_out_of_memory(error, "building the tree");
  pthread_mutex_destroy(&b.lock);
  pthread_mutex_destroy(&b.divide.lock);
  whittle_release(b.divide.piece_counts);
  whittle_release(b.pool);
  whittle_release(b.list.segments);
  return status;
}

void whittle_bvh_drop(whittle_bvh *bvh) {
  whittle_release(bvh->block);
  bvh->nodes = bvh->block = NULL;
}
