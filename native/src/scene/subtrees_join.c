/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Putting subtrees and the tree over them into one set of arrays, which is what rays go through. */

#include "base/memory.h"
#include "bvh/measure.h"
#include "scene/subtrees_build.h"

#include <string.h>

enum { GRAIN = 16384 };

/* ---- Moving a subtree: the same numbers, counted from elsewhere ---- */

typedef struct moving {
  const whittle_node *nodes;
  const wide_node *wide;
  triangle_store triangles;
  scene_arrays to;  /* first entries of the subtree */
  subtree_place by; /* what is added, modulo 2^32 */
} moving;

static void move_nodes(void *context, uint64_t begin, uint64_t end) {
  const moving *m = context;
  for (uint64_t i = begin; i < end; i++) {
    whittle_node node = m->nodes[i];
    node.left_first += node.count ? m->by.triangle : m->by.node;
    m->to.nodes[i] = node;
  }
}

/* Missing children are named by numbers too, which no one reads. */
static void move_wide(void *context, uint64_t begin, uint64_t end) {
  const moving *m = context;
  for (uint64_t i = begin; i < end; i++) {
    wide_node node = m->wide[i];
    for (int k = 0; k < WHITTLE_WIDTH; k++)
      node.child[k].first += wide_is_leaf(node.child[k]) ? m->by.triangle : m->by.wide;
    m->to.wide[i] = node;
  }
}

static void move_triangles(void *context, uint64_t begin, uint64_t end) {
  const moving *m = context;
  whittle_triangles_move(&m->to.triangles, &m->triangles, (size_t)begin, (size_t)(end - begin));
}

static void share(whittle_team *team, uint64_t count, whittle_team_body *body, moving *m) {
  if (count == 0)
    return;
  if (team)
    whittle_team_for(team, count, GRAIN, body, m);
  else
    body(m, 0, count);
}

/* From where the subtree lies, in arrays whose numbers count from `from`, to its place. By the
 * whole team, which stops when cancelled, or without one. */
static void move_subtree(whittle_team *team, const subtree *what, moving *m, subtree_place from,
                         const scene_arrays *to) {
  m->to.nodes = to->nodes ? to->nodes + what->at.node : NULL;
  m->to.wide = to->wide + what->at.wide;
  m->to.triangles = whittle_triangles_from(&to->triangles, what->at.triangle);
  m->by = (subtree_place){what->at.node - from.node, what->at.wide - from.wide,
                          what->at.triangle - from.triangle};
  share(team, to->nodes ? what->nodes : 0, move_nodes, m);
  share(team, what->wides, move_wide, m);
  share(team, what->triangles, move_triangles, m);
}

static void move_new(whittle_team *team, subtrees_build *p, uint32_t i) {
  grown_tree *tree = &p->grown[p->news[i]].tree;
  moving m = {.nodes = tree->bvh.nodes, .wide = tree->wide, .triangles = tree->triangles};
  move_subtree(team, &p->next->list[i], &m, (subtree_place){0}, &p->made);
  whittle_grown_free(tree);
}

static void move_kept(whittle_team *team, subtrees_build *p, uint32_t i) {
  const whittle_scene *scene = p->scene;
  const subtree_place from = scene->subtrees->list[i].at;
  if (p->in_place && memcmp(&from, &p->next->list[i].at, sizeof from) == 0)
    return;
  moving m = {.nodes = scene->nodes ? scene->nodes + from.node : NULL,
              .wide = scene->wide + from.wide,
              .triangles = whittle_triangles_from(&scene->triangles, from.triangle)};
  move_subtree(team, &p->next->list[i], &m, from, &p->made);
}

/* ---- The tree over their pieces ---- */

/* The pieces of all subtrees, kept or new, in the order of the instances. */
static whittle_status gather_pieces(subtrees_build *p, whittle_error *error) {
  scene_subtrees *next = p->next;
  uint32_t count = 0;
  for (size_t i = 0; i < next->count; i++)
    count += next->list[i].pieces;
  next->pieces = whittle_allocate(count, sizeof *next->pieces);
  if (!next->pieces)
    return whittle_out_of_memory(error, "the pieces of the subtrees");
  for (size_t i = 0; i < next->count; i++) {
    subtree *each = &next->list[i];
    const subtree_piece *from = p->news[i] != NO_SUBTREE ? p->grown[p->news[i]].pieces
                                : each->pieces ? p->scene->subtrees->pieces + each->first_piece
                                               : NULL;
    if (each->pieces)
      memcpy(&next->pieces[next->piece_count], from, each->pieces * sizeof *from);
    each->first_piece = next->piece_count;
    next->piece_count += each->pieces;
  }
  return WHITTLE_OK;
}

static void set_fragment(whittle_fragment *fragment, const whittle_node *box, size_t instance,
                         uint32_t piece) {
  memcpy(fragment->lo, box->bounds_min, sizeof fragment->lo);
  memcpy(fragment->hi, box->bounds_max, sizeof fragment->hi);
  fragment->instance = (uint32_t)instance;
  fragment->triangle = piece;
}

static whittle_status build_top(subtrees_build *p, whittle_error *error) {
  scene_subtrees *next = p->next;
  uint32_t deepest = 0;
  whittle_status status = whittle_top_begin(&p->top, next->piece_count, error);
  if (status != WHITTLE_OK)
    return status;
  for (size_t i = 0; i < next->count; i++)
    for (uint32_t k = 0; k < next->list[i].pieces; k++) {
      const uint32_t piece = next->list[i].first_piece + k;
      set_fragment(&p->top.fragments[piece], &next->pieces[piece].root, i, piece);
      if (next->pieces[piece].depth > deepest)
        deepest = next->pieces[piece].depth;
    }
  whittle_bvh_options options = next->options;
  options.max_leaf = 1;
  options.whole = 0;
  options.max_depth = WHITTLE_MAX_DEPTH - deepest;
  return whittle_top_build(p->team, &p->top, &options, error);
}

static const subtree *subtree_of(const subtrees_build *p, uint32_t position) {
  return &p->next->list[p->top.fragments[position].instance];
}

static const subtree_piece *piece_of(const subtrees_build *p, uint32_t position) {
  return &p->next->pieces[p->top.fragments[position].triangle];
}

static void put_top_nodes(const subtrees_build *p) {
  for (uint32_t i = 0; i < p->top.bvh.node_count; i++) {
    whittle_node node = p->top.bvh.nodes[i];
    if (node.count) {
      const subtree *below = subtree_of(p, node.left_first);
      node = piece_of(p, node.left_first)->root;
      node.left_first += node.count ? below->at.triangle : below->at.node;
    }
    p->made.nodes[i] = node;
  }
}

static void put_top_wide(const subtrees_build *p) {
  for (uint32_t i = 0; i < p->top.wide_count; i++) {
    wide_node wide = p->top.wide[i];
    for (int k = 0; k < WHITTLE_WIDTH; k++) {
      if (!wide_is_leaf(wide.child[k]))
        continue;
      const subtree_place at = subtree_of(p, wide.child[k].first)->at;
      const subtree_piece *piece = piece_of(p, wide.child[k].first);
      wide.child[k] = piece->wides
                          ? (wide_child){at.wide + piece->first_wide, wide_node_kind(&piece->root)}
                          : (wide_child){at.triangle + piece->first_triangle, piece->triangles};
    }
    p->made.wide[i] = wide;
  }
  /* Over a single piece there is nothing to choose. */
  if (p->top.count == 1 && piece_of(p, 0)->wides)
    p->made.wide[0] = p->made.wide[subtree_of(p, 0)->at.wide];
}

static void put_top(const subtrees_build *p) {
  if (!p->lean)
    put_top_nodes(p);
  put_top_wide(p);
}

/* ---- What it all amounts to ---- */

static whittle_status find_depth(subtrees_build *p, whittle_error *error) {
  const whittle_bvh *top = &p->top.bvh;
  uint8_t *depths = whittle_allocate(top->node_count, 1);
  if (!depths)
    return whittle_out_of_memory(error, "the tree over the instances");
  if (top->node_count)
    depths[0] = 0;
  for (uint32_t i = 0; i < top->node_count; i++) {
    const whittle_node *node = &top->nodes[i];
    if (node->count == 0) {
      depths[node->left_first] = depths[node->left_first + 1] = (uint8_t)(depths[i] + 1);
      continue;
    }
    const uint32_t depth = depths[i] + piece_of(p, node->left_first)->depth;
    p->summary.depth = depth > p->summary.depth ? depth : p->summary.depth;
  }
  whittle_release(depths);
  return WHITTLE_OK;
}

/* Adds up in the order of the tree and the instances, wherever they lie. */
static whittle_status summarise(subtrees_build *p, whittle_error *error) {
  const scene_subtrees *next = p->next;
  whittle_bvh *sum = &p->summary;
  for (uint32_t i = 0; i < p->top.bvh.node_count; i++)
    if (p->top.bvh.nodes[i].count == 0)
      sum->cost += (double)next->options.traversal_cost * whittle_node_area(&p->top.bvh.nodes[i]);
  for (size_t i = 0; i < next->count; i++) {
    const subtree *each = &next->list[i];
    if (each->triangles == 0)
      continue;
    sum->cost += each->cost;
    sum->leaves += each->leaves;
    if (each->largest_leaf > sum->largest_leaf)
      sum->largest_leaf = each->largest_leaf;
  }
  const double whole = next->piece_count ? whittle_node_area(&p->top.bvh.nodes[0]) : 0.0;
  sum->sah_cost = whole > 0.0 ? sum->cost / whole : 0.0;
  sum->node_count = (uint32_t)p->made.node_count;
  return find_depth(p, error);
}

/* ---- Places ---- */

/* Kept subtrees in the order they had, then the new ones. */
static void choose_order(subtrees_build *p) {
  const scene_subtrees *old = p->scene->subtrees;
  scene_subtrees *next = p->next;
  for (uint32_t k = 0; old && k < old->used; k++) {
    const uint32_t i = old->order[k];
    if (p->news[i] == NO_SUBTREE && next->list[i].triangles)
      next->order[next->used++] = i;
  }
  for (uint32_t k = 0; k < p->changed_count; k++)
    if (next->list[p->changed[k]].triangles)
      next->order[next->used++] = p->changed[k];
}

static void choose_places(subtrees_build *p) {
  scene_subtrees *next = p->next;
  const uint32_t pieces = next->piece_count;
  scene_arrays *made = &p->made;
  made->node_count = pieces ? 2 * (size_t)pieces - 1 : 0;
  made->wide_count = whittle_top_wide_room(pieces);
  for (uint32_t k = 0; k < next->used; k++) {
    subtree *each = &next->list[next->order[k]];
    each->at = (subtree_place){(uint32_t)made->node_count, (uint32_t)made->wide_count,
                               (uint32_t)made->triangle_count};
    made->node_count += each->nodes;
    made->wide_count += each->wides;
    made->triangle_count += each->triangles;
  }
}

/* Whether the kept subtrees, which must be the larger share, can stay where they are or move up to
 * the front, and the new ones fit behind them. */
static bool fits_in_place(const subtrees_build *p) {
  const scene_subtrees *old = p->scene->subtrees, *next = p->next;
  size_t kept = 0;
  if (!old || p->made.node_count > old->node_room || p->made.wide_count > old->wide_room ||
      p->made.triangle_count > old->triangle_room)
    return false;
  for (uint32_t k = 0; k < next->used; k++) {
    const uint32_t i = next->order[k];
    if (p->news[i] != NO_SUBTREE)
      continue;
    kept += next->list[i].triangles;
    const subtree_place from = old->list[i].at, to = next->list[i].at;
    if (to.node > from.node || to.wide > from.wide || to.triangle > from.triangle)
      return false;
  }
  return 2 * kept >= p->made.triangle_count;
}

/* Room for what changes next to be larger then; pages that are never written take no memory. */
static size_t with_room(size_t total) {
  return total + total / 16 + 64;
}

static whittle_status make_room(subtrees_build *p, whittle_error *error) {
  scene_subtrees *next = p->next;
  scene_arrays *made = &p->made;
  next->node_room = with_room(made->node_count);
  next->wide_room = with_room(made->wide_count);
  next->triangle_room = with_room(made->triangle_count);
  if (!p->lean)
    made->node_block = whittle_allocate(next->node_room + 1, sizeof *made->nodes);
  made->wide = whittle_allocate(next->wide_room, sizeof *made->wide);
  const bool triangles = whittle_triangles_reserve(&made->triangles, next->triangle_room);
  if ((!p->lean && !made->node_block) || !made->wide || !triangles)
    return whittle_out_of_memory(error, "the tree of the scene");
  made->nodes = p->lean ? NULL : made->node_block + 1;
  return WHITTLE_OK;
}

static void stay_in_place(subtrees_build *p) {
  const whittle_scene *scene = p->scene;
  p->in_place = true;
  p->made.nodes = scene->nodes;
  p->made.node_block = scene->node_block;
  p->made.wide = scene->wide;
  p->made.triangles = scene->triangles;
  p->next->node_room = scene->subtrees->node_room;
  p->next->wide_room = scene->subtrees->wide_room;
  p->next->triangle_room = scene->subtrees->triangle_room;
}

whittle_status whittle_subtrees_join(subtrees_build *p, whittle_error *error) {
  whittle_status status = gather_pieces(p, error);
  if (status != WHITTLE_OK)
    return status;
  choose_order(p);
  choose_places(p);
  status = build_top(p, error);
  if (status == WHITTLE_OK && !whittle_cancelled(p->team->state))
    status = summarise(p, error);
  if (status != WHITTLE_OK || whittle_cancelled(p->team->state))
    return status;
  if (fits_in_place(p)) {
    stay_in_place(p);
    return WHITTLE_OK;
  }
  status = make_room(p, error);
  if (status != WHITTLE_OK)
    return status;
  for (uint32_t k = 0; k < p->next->used && !whittle_cancelled(p->team->state); k++) {
    const uint32_t i = p->next->order[k];
    (p->news[i] == NO_SUBTREE ? move_kept : move_new)(p->team, p, i);
  }
  if (!whittle_cancelled(p->team->state))
    put_top(p);
  return WHITTLE_OK;
}

/* Nothing can fail any more, nor be cancelled. What is kept moves to the front, each in its turn,
 * so that it overwrites nothing that is still to be moved. */
void whittle_subtrees_put(subtrees_build *p) {
  for (uint32_t k = 0; k < p->next->used; k++) {
    const uint32_t i = p->next->order[k];
    (p->news[i] == NO_SUBTREE ? move_kept : move_new)(NULL, p, i);
  }
  put_top(p);
}
