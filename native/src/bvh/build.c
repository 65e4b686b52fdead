/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Growing the tree from the root: by tasks while spans are large, then by recursion.
 *
 * A span of n fragments has room reserved for the 2 (n - 1) nodes below it: its two children at the
 * start, then the left child's room, then the right one's. So each node's place follows from the
 * splits above it alone, never from who built it when. */

#include "base/memory.h"
#include "bvh/layout.h"
#include "bvh/median.h"
#include "bvh/partition.h"

#include <string.h>

enum {
  GRAIN = 8192,      /* fragments in a piece of a loop */
  LARGE = 4 * GRAIN, /* spans above this are binned and divided by the whole team */
  BLOCK = 2048,      /* spans up to this are one worker's, without a gap between nodes */
};

typedef struct builder {
  whittle_team *team;
  whittle_bvh_options options;
  whittle_fragment *buffer[2];
  whittle_node *nodes; /* reserved; nodes[0] is the root */
  uint32_t *left_counts;
  pthread_mutex_t lock; /* of all below */
  segment *segments;
  uint64_t segment_count;
  uint32_t depth;
} builder;

/* One worker within a block. */
typedef struct grower {
  builder *b;
  whittle_node *next;
  uint32_t depth;
  bins bins;
} grower;

static uint32_t floor_log2(uint32_t n) {
  return 31 - (uint32_t)__builtin_clz(n);
}
static uint32_t ceil_log2(uint32_t n) {
  return n > 1 ? floor_log2(n - 1) + 1 : 0;
}

static uint64_t units(uint32_t count) {
  return count ? (uint64_t)count * floor_log2(count) : 0;
}

uint64_t whittle_bvh_units(uint64_t count) {
  return units((uint32_t)count);
}

static void set_bounds(whittle_node *node, box4 bounds) {
  _Alignas(16) float lo[4], hi[4];
  float4_store(lo, bounds.lo);
  float4_store(hi, bounds.hi);
  memcpy(node->bounds_min, lo, sizeof node->bounds_min);
  memcpy(node->bounds_max, hi, sizeof node->bounds_max);
}

/* Whether halving from here on would use up the depth that is left: then it must begin. Spans keep
 * ceil_log2(count) <= WHITTLE_MAX_DEPTH - depth, so no leaf can lie deeper. */
static bool must_halve(const span *s) {
  return ceil_log2(s->count) >= WHITTLE_MAX_DEPTH - s->depth;
}

static bool leaf_is_cheaper(const builder *b, const split *best) {
  return best->leaf_cost <= b->options.traversal_cost * best->area + best->cost;
}

/* Makes the node an inner one and prepares the children, but for their bounds. */
static void divide(const builder *b, const span *s, whittle_node *pair, uint32_t left,
                   span children[2]) {
  set_bounds(s->node, s->bounds);
  s->node->left_first = (uint32_t)(pair - b->nodes);
  s->node->count = 0;
  for (uint32_t side = 0; side < 2; side++) {
    span *child = &children[side];
    child->node = pair + side;
    child->first = side ? s->first + left : s->first;
    child->count = side ? s->count - left : left;
    child->depth = s->depth + 1;
    child->buffer = 1 - s->buffer;
  }
}

/* Leaves keep their fragments in buffer 0. */
static void make_leaf(grower *g, const span *s) {
  builder *b = g->b;
  set_bounds(s->node, s->bounds);
  s->node->left_first = s->first;
  s->node->count = s->count;
  if (s->buffer == 1)
    memcpy(b->buffer[0] + s->first, b->buffer[1] + s->first, s->count * sizeof(whittle_fragment));
  if (s->depth > g->depth)
    g->depth = s->depth;
}

static void halve(const builder *b, const span *s, whittle_node *pair, span children[2]) {
  const uint32_t left = s->count / 2;
  whittle_fragment *to = b->buffer[1 - s->buffer] + s->first;
  divide(b, s, pair, left, children);
  whittle_median(s, b->buffer[s->buffer] + s->first, to, to + left, children, b->team->state);
}

static void bound_children(const bins *bins, const split *best, uint32_t count, span children[2]) {
  children[0].bounds = whittle_bins_bounds(bins, best->axis, 0, best->plane);
  children[1].bounds = whittle_bins_bounds(bins, best->axis, best->plane, count);
}

static uint32_t count_below(const bins *bins, const split *best) {
  uint32_t left = 0;
  for (uint32_t i = 0; i < best->plane; i++)
    left += (uint32_t)bins->count[i][best->axis];
  return left;
}

static void split_by_bins(const builder *b, const span *s, const bin_map *map, const bins *bins,
                          const split *best, whittle_node *pair, span children[2]) {
  const divider d = whittle_divider(map, best);
  const uint32_t left = count_below(bins, best);
  whittle_fragment *to = b->buffer[1 - s->buffer] + s->first;
  box4 middles[2];
  divide(b, s, pair, left, children);
  bound_children(bins, best, map->bins, children);
  whittle_partition(&d, b->buffer[s->buffer] + s->first, s->count, to, to + left, middles);
  children[0].middles = middles[0];
  children[1].middles = middles[1];
}

/* What a span becomes. */
typedef enum choice { LEAF, SPLIT, HALVE } choice;

static choice choose(const builder *b, const span *s, bool found, const split *best) {
  if (s->count <= b->options.max_leaf && (!found || leaf_is_cheaper(b, best)))
    return LEAF;
  return found && !must_halve(s) ? SPLIT : HALVE;
}

/* Divides a span by ranks; false: it is a leaf. */
static bool divide_ranked(grower *g, const span *s, span children[2]) {
  builder *b = g->b;
  const whittle_fragment *fragments = b->buffer[s->buffer] + s->first;
  whittle_fragment *to = b->buffer[1 - s->buffer] + s->first;
  ranks ranks;
  split best;
  whittle_bins_rank(&g->bins, &ranks, fragments, s->count);
  const bool found =
      whittle_bins_split(&g->bins, s->count, float4_every(), s->bounds, s->count, &best);
  const choice choice = choose(b, s, found, &best);
  if (choice == LEAF)
    return false;
  if (choice == HALVE)
    best.plane = s->count / 2;
  divide(b, s, g->next, best.plane, children);
  bound_children(&g->bins, &best, s->count, children);
  for (uint32_t i = 0; i < s->count; i++)
    to[ranks.rank[i][best.axis]] = fragments[i];
  return true;
}

/* Divides a span by bins; false: it is a leaf. */
static bool divide_binned(grower *g, const span *s, span children[2]) {
  builder *b = g->b;
  const whittle_fragment *fragments = b->buffer[s->buffer] + s->first;
  const bin_map map = whittle_bin_map(s->middles, b->options.bins);
  split best;
  whittle_bins_clear(&g->bins, map.bins);
  whittle_bins_add(&g->bins, &map, fragments, s->count);
  const bool found = whittle_bins_split(&g->bins, map.bins, map.usable, s->bounds, s->count, &best);
  const choice choice = choose(b, s, found, &best);
  if (choice == LEAF)
    return false;
  if (choice == HALVE) {
    halve(b, s, g->next, children);
    return true;
  }
  split_by_bins(b, s, &map, &g->bins, &best, g->next, children);
  return true;
}

/* Grows the whole subtree of a span into the nodes from g->next on. */
static void grow(grower *g, const span *s) {
  span children[2];
  const uint32_t few = g->b->options.bins < MOST_RANKED ? g->b->options.bins : MOST_RANKED;
  if (s->count == 1 ||
      !(s->count <= few ? divide_ranked(g, s, children) : divide_binned(g, s, children))) {
    make_leaf(g, s);
    return;
  }
  g->next += 2;
  grow(g, &children[0]);
  grow(g, &children[1]);
}

static void add_segment(builder *b, const whittle_node *first, uint32_t count, uint32_t depth) {
  pthread_mutex_lock(&b->lock);
  if (count)
    b->segments[b->segment_count++] =
        (segment){.place = (uint64_t)(first - b->nodes), .count = count};
  if (depth > b->depth)
    b->depth = depth;
  pthread_mutex_unlock(&b->lock);
}

static void grow_block(builder *b, const span *s) {
  grower g;
  g.b = b;
  g.next = s->room;
  g.depth = 0;
  grow(&g, s);
  add_segment(b, s->room, (uint32_t)(g.next - s->room), g.depth);
  whittle_advance(b->team->state, units(s->count));
}

/* What the team shares while it works on one large span. */
typedef struct large {
  builder *b;
  const span *s;
  bin_map map;
  bins bins;
  divider divider;
  uint32_t *left_counts; /* by piece; then how many went left before it */
  uint32_t left;
  box4 middles[2];
} large;

static void bin_piece(void *context, uint64_t begin, uint64_t end) {
  large *l = context;
  bins own;
  whittle_bins_clear(&own, l->map.bins);
  whittle_bins_add(&own, &l->map, l->b->buffer[l->s->buffer] + l->s->first + begin,
                   (uint32_t)(end - begin));
  pthread_mutex_lock(&l->b->lock);
  whittle_bins_merge(&l->bins, &own, l->map.bins);
  pthread_mutex_unlock(&l->b->lock);
}

static void count_piece(void *context, uint64_t begin, uint64_t end) {
  large *l = context;
  l->left_counts[begin / GRAIN] = whittle_count_left(
      &l->divider, l->b->buffer[l->s->buffer] + l->s->first + begin, (uint32_t)(end - begin));
}

static void move_piece(void *context, uint64_t begin, uint64_t end) {
  large *l = context;
  const uint32_t before = l->left_counts[begin / GRAIN];
  whittle_fragment *to = l->b->buffer[1 - l->s->buffer] + l->s->first;
  box4 middles[2];
  whittle_partition(&l->divider, l->b->buffer[l->s->buffer] + l->s->first + begin,
                    (uint32_t)(end - begin), to + before, to + l->left + (begin - before), middles);
  pthread_mutex_lock(&l->b->lock);
  for (int side = 0; side < 2; side++)
    l->middles[side] = box4_union(l->middles[side], middles[side]);
  pthread_mutex_unlock(&l->b->lock);
}

static void divide_large(large *l, const split *best, whittle_node *pair, span children[2]) {
  builder *b = l->b;
  const span *s = l->s;
  l->left = count_below(&l->bins, best);
  l->divider = whittle_divider(&l->map, best);
  /* Spans above 4 GRAIN have fewer pieces than twice their share of the counters. */
  l->left_counts = b->left_counts + 2 * (uint64_t)s->first / GRAIN;
  l->middles[0] = l->middles[1] = box4_empty();
  divide(b, s, pair, l->left, children);
  bound_children(&l->bins, best, l->map.bins, children);
  whittle_team_for(b->team, s->count, GRAIN, count_piece, l);
  uint32_t before = 0;
  for (uint64_t piece = 0; piece * GRAIN < s->count; piece++) {
    const uint32_t here = l->left_counts[piece];
    l->left_counts[piece] = before;
    before += here;
  }
  if (!whittle_cancelled(b->team->state))
    whittle_team_for(b->team, s->count, GRAIN, move_piece, l);
  children[0].middles = l->middles[0];
  children[1].middles = l->middles[1];
}

/* Divides a span above BLOCK, which is never a leaf. */
static void divide_span(builder *b, const span *s, whittle_node *pair, span children[2]) {
  large l = {.b = b, .s = s, .map = whittle_bin_map(s->middles, b->options.bins)};
  split best;
  whittle_bins_clear(&l.bins, l.map.bins);
  if (s->count > LARGE)
    whittle_team_for(b->team, s->count, GRAIN, bin_piece, &l);
  else
    whittle_bins_add(&l.bins, &l.map, b->buffer[s->buffer] + s->first, s->count);
  if (whittle_cancelled(b->team->state))
    return;
  const bool found =
      whittle_bins_split(&l.bins, l.map.bins, l.map.usable, s->bounds, s->count, &best);
  if (choose(b, s, found, &best) == HALVE)
    halve(b, s, pair, children);
  else if (s->count > LARGE)
    divide_large(&l, &best, pair, children);
  else
    split_by_bins(b, s, &l.map, &l.bins, &best, pair, children);
}

static void grow_span(void *context, const void *argument) {
  builder *b = context;
  span s;
  memcpy(&s, argument, sizeof s);
  while (s.count > BLOCK) {
    span children[2];
    whittle_node *pair = s.room;
    divide_span(b, &s, pair, children);
    if (whittle_cancelled(b->team->state))
      return;
    children[0].room = s.room + 2;
    children[1].room = s.room + 2 * (size_t)children[0].count;
    add_segment(b, pair, 2, 0);
    whittle_advance(b->team->state,
                    units(s.count) - units(children[0].count) - units(children[1].count));
    const uint32_t shared = children[0].count < children[1].count;
    if (!whittle_team_share(b->team, grow_span, b, &children[shared], sizeof(span)))
      grow_span(b, &children[shared]);
    s = children[1 - shared];
  }
  if (!whittle_cancelled(b->team->state))
    grow_block(b, &s);
}

typedef struct measure {
  builder *b;
  span *root;
} measure;

static void measure_piece(void *context, uint64_t begin, uint64_t end) {
  const measure *m = context;
  const whittle_fragment *fragments = m->b->buffer[0];
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
  span root = {.bounds = box4_empty(),
               .middles = box4_empty(),
               .node = b->nodes,
               .room = b->nodes + 1,
               .count = count};
  measure m = {b, &root};
  whittle_team_for(b->team, count, GRAIN, measure_piece, &m);
  if (!whittle_cancelled(b->team->state))
    grow_span(b, &root);
  whittle_team_finish(b->team);
  if (whittle_cancelled(b->team->state))
    return WHITTLE_CANCELLED;
  bvh->depth = b->depth;
  return whittle_layout(b->team, b->nodes, b->segments, b->segment_count, b->options.traversal_cost,
                        bvh, error);
}

whittle_status whittle_bvh_build(whittle_team *team, whittle_fragment *fragments, uint32_t count,
                                 const whittle_bvh_options *options, whittle_bvh *bvh,
                                 whittle_error *error) {
  memset(bvh, 0, sizeof *bvh);
  if (count == 0)
    return WHITTLE_OK;
  builder b = {.team = team, .options = *options};
  /* At most count / BLOCK spans above BLOCK at each depth, each with a pair and two blocks. */
  const uint64_t segments = 3 * WHITTLE_MAX_DEPTH * (uint64_t)(count / BLOCK) + 3;
  b.buffer[0] = fragments;
  b.buffer[1] = whittle_allocate(count, sizeof *b.buffer[1]);
  b.nodes = whittle_allocate(2 * (size_t)count, sizeof *b.nodes);
  b.left_counts = whittle_allocate(2 * (size_t)count / GRAIN + 2, sizeof *b.left_counts);
  b.segments = whittle_allocate(segments, sizeof *b.segments);
  pthread_mutex_init(&b.lock, NULL);
  whittle_status status;
  if (b.buffer[1] && b.nodes && b.left_counts && b.segments)
    status = grow_tree(&b, count, bvh, error);
  else
    status = whittle_out_of_memory(error, "building the tree");
  pthread_mutex_destroy(&b.lock);
  whittle_release(b.buffer[1]);
  whittle_release(b.nodes);
  whittle_release(b.left_counts);
  whittle_release(b.segments);
  return status;
}
