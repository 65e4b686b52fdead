/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Taking a subtree apart near its root, so that the tree over the subtrees can sort its pieces
 * among those of others that overlap it (Benthin et al., 2017, "Improved Two-Level BVHs using
 * Partial Re-Braiding"). */

#include "base/memory.h"
#include "bvh/measure.h"
#include "scene/subtrees_build.h"

#include <string.h>

/* Few enough for a tree over them to cost little. */
enum { MOST_PIECES = 64 };

typedef struct opening {
  grown_subtree *own;
  subtree *sum; /* of the pieces so far */
  float traversal_cost;
  uint32_t chosen[MOST_PIECES]; /* nodes in depth-first order */
  uint32_t count;
  uint8_t *depths; /* room for the depths of all nodes */
  whittle_team *team;
} opening;

/* What is below a node follows in depth-first order: the end of that. */
static uint32_t end_below(const whittle_node *nodes, const whittle_node *node) {
  uint32_t end = 0;
  while (node->count == 0) {
    const whittle_node *left = &nodes[node->left_first], *right = left + 1;
    end = node->left_first + 2;
    node = right->count ? left : right;
  }
  return end;
}

static uint32_t first_triangle(const whittle_node *nodes, const whittle_node *node) {
  while (node->count == 0)
    node = &nodes[node->left_first];
  return node->left_first;
}

static uint32_t end_triangle(const whittle_node *nodes, const whittle_node *node) {
  while (node->count == 0)
    node = &nodes[node->left_first + 1];
  return node->left_first + node->count;
}

/* Opens the node of the largest box until there are `most` or only leaves. */
static void choose_pieces(opening *o, uint32_t most) {
  const whittle_node *nodes = o->own->tree.bvh.nodes;
  o->chosen[0] = 0;
  o->count = 1;
  while (o->count < most) {
    uint32_t widest = o->count;
    double area = -1.0;
    for (uint32_t i = 0; i < o->count; i++) {
      const whittle_node *node = &nodes[o->chosen[i]];
      if (node->count == 0 && whittle_node_area(node) > area)
        widest = i, area = whittle_node_area(node);
    }
    if (widest == o->count)
      return;
    memmove(&o->chosen[widest + 2], &o->chosen[widest + 1],
            (o->count - widest - 1) * sizeof o->chosen[0]);
    o->chosen[widest] = nodes[o->chosen[widest]].left_first;
    o->chosen[widest + 1] = o->chosen[widest] + 1;
    o->count++;
  }
}

static void count_node(opening *o, subtree_piece *piece, const whittle_node *node, uint32_t depth) {
  subtree *sum = o->sum;
  piece->depth = depth > piece->depth ? depth : piece->depth;
  sum->leaves += node->count > 0;
  sum->largest_leaf = node->count > sum->largest_leaf ? node->count : sum->largest_leaf;
  sum->cost +=
      (node->count ? (double)node->count : (double)o->traversal_cost) * whittle_node_area(node);
}

/* Moves the nodes below a piece's root up, over those that were opened, and counts them. */
static void pack_piece(opening *o, subtree_piece *piece) {
  whittle_node *nodes = o->own->tree.bvh.nodes;
  const bool leaf = piece->root.count > 0;
  const uint32_t first = piece->root.left_first, packed = o->sum->nodes;
  piece->first_triangle = first_triangle(nodes, &piece->root);
  piece->triangles = end_triangle(nodes, &piece->root) - piece->first_triangle;
  piece->nodes = leaf ? 0 : end_below(nodes, &piece->root) - first;
  piece->first_node = packed;
  count_node(o, piece, &piece->root, 0);
  if (leaf)
    return;
  o->depths[0] = o->depths[1] = 1;
  for (uint32_t i = 0; i < piece->nodes; i++) {
    whittle_node node = nodes[first + i];
    count_node(o, piece, &node, o->depths[i]);
    if (node.count == 0) {
      const uint32_t child = node.left_first - first;
      o->depths[child] = o->depths[child + 1] = (uint8_t)(o->depths[i] + 1);
      node.left_first = child + packed;
    }
    nodes[packed + i] = node;
  }
  piece->root.left_first = packed;
  o->sum->nodes += piece->nodes;
}

/* The piece as a tree of its own, to be released. */
static whittle_node *copy_piece(const opening *o, const subtree_piece *piece) {
  whittle_node *nodes = whittle_allocate((size_t)piece->nodes + 1, sizeof *nodes);
  if (!nodes)
    return NULL;
  nodes[0] = piece->root;
  memcpy(nodes + 1, o->own->tree.bvh.nodes + piece->first_node, piece->nodes * sizeof *nodes);
  for (uint32_t i = 0; i <= piece->nodes; i++)
    if (nodes[i].count == 0)
      nodes[i].left_first -= piece->first_node - 1;
  return nodes;
}

/* Pieces of a single leaf need no wide node: a leaf can be anyone's child. */
static whittle_status widen_piece(opening *o, subtree_piece *piece, whittle_error *error) {
  piece->first_wide = o->sum->wides;
  piece->wides = 0;
  if (piece->root.count || piece->triangles <= WHITTLE_WIDE_LEAF) {
    whittle_triangles_place_leaf(&o->own->tree.triangles, piece->first_triangle, piece->triangles);
    return WHITTLE_OK;
  }
  whittle_node *nodes = copy_piece(o, piece);
  if (!nodes)
    return whittle_out_of_memory(error, "the wide tree");
  wide_node *wide =
      whittle_bvh_widen(o->team, nodes, (size_t)piece->nodes + 1, &piece->wides, error);
  whittle_release(nodes);
  if (!wide)
    return WHITTLE_OUT_OF_MEMORY;
  for (uint32_t i = 0; i < piece->wides && !whittle_cancelled(o->team->state); i++) {
    for (int k = 0; k < WHITTLE_WIDTH; k++)
      wide[i].child[k].first += wide_is_leaf(wide[i].child[k]) ? 0 : piece->first_wide;
    o->own->tree.wide[piece->first_wide + i] = wide[i];
  }
  whittle_release(wide);
  if (!whittle_cancelled(o->team->state))
    whittle_triangles_place(&o->own->tree.triangles, o->own->tree.wide + piece->first_wide,
                            piece->wides);
  o->sum->wides += piece->wides;
  return WHITTLE_OK;
}

static whittle_status take_apart(opening *o, whittle_error *error) {
  subtree_piece *pieces = o->own->pieces;
  whittle_status status = WHITTLE_OK;
  /* Packing overwrites the roots of pieces that follow. */
  for (uint32_t k = 0; k < o->count; k++)
    pieces[k] = (subtree_piece){.root = o->own->tree.bvh.nodes[o->chosen[k]]};
  for (uint32_t k = 0; k < o->count && !whittle_cancelled(o->team->state); k++)
    pack_piece(o, &pieces[k]);
  o->own->tree.wide = whittle_allocate(o->sum->nodes / 2 + o->count, sizeof(wide_node));
  if (!o->own->tree.wide)
    return whittle_out_of_memory(error, "the wide tree");
  for (uint32_t k = 0; k < o->count && status == WHITTLE_OK && !whittle_cancelled(o->team->state);
       k++)
    status = widen_piece(o, &pieces[k], error);
  return status;
}

whittle_status whittle_subtree_open(whittle_team *team, grown_subtree *own, subtree *to,
                                    float traversal_cost, whittle_error *error) {
  const uint32_t wanted = 1 + to->triangles / PIECE_TRIANGLES;
  opening o = {.own = own, .sum = to, .traversal_cost = traversal_cost, .team = team};
  to->nodes = to->wides = to->leaves = to->largest_leaf = to->pieces = 0;
  to->cost = 0.0;
  if (to->triangles == 0)
    return WHITTLE_OK;
  choose_pieces(&o, wanted < MOST_PIECES ? wanted : MOST_PIECES);
  to->pieces = o.count;
  own->pieces = whittle_allocate(o.count, sizeof *own->pieces);
  o.depths = whittle_allocate(own->tree.bvh.node_count, 1);
  const whittle_status status = own->pieces && o.depths
                                    ? take_apart(&o, error)
                                    : whittle_out_of_memory(error, "the pieces of a subtree");
  whittle_release(o.depths);
  return status;
}
