/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The tree with eight children to a node, collapsed from the binary one for speed. */

#pragma once

#include "bvh/bvh.h"

enum { WHITTLE_WIDTH = 8, WHITTLE_WIDE_LEAF = 8 };

/* A child: a leaf of `count` triangles from `first` on, or a node if count is WIDE_NODE, or
 * WIDE_FINE_NODE: one so small beside the scene that its boxes need the test that rounds least. */
typedef struct wide_child {
  uint32_t first, count;
} wide_child;

#define WIDE_NODE 0u
#define WIDE_FINE_NODE UINT32_MAX
#define WIDE_FINE 0x1p-14f /* extent of such a node; scene space is about 1 wide */

/* The boxes of eight children as structures of arrays; those of missing children are NaN, which no
 * test lets pass. */
typedef struct wide_node {
  float low[3][WHITTLE_WIDTH], high[3][WHITTLE_WIDTH];
  wide_child child[WHITTLE_WIDTH];
} wide_node;

static inline uint32_t wide_node_kind(const whittle_node *node) {
  float extent = 0.0f;
  for (int axis = 0; axis < 3; axis++) {
    const float side = node->bounds_max[axis] - node->bounds_min[axis];
    extent = side > extent ? side : extent;
  }
  return extent < WIDE_FINE ? WIDE_FINE_NODE : WIDE_NODE;
}

static inline bool wide_is_leaf(wide_child child) {
  return child.count != WIDE_NODE && child.count != WIDE_FINE_NODE;
}

_Static_assert(sizeof(wide_node) == 256, "four cache lines");

/* Subtrees of at most WHITTLE_WIDE_LEAF triangles become leaves, and the nodes above them are
 * joined so that the surface of the wide nodes is the least possible (after Ylitie, Karras and
 * Laine, 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs").
 * Nodes are in depth-first order, and so are the triangles of the leaves. Called by the leader of a
 * team whose members help. NULL if memory ran out; `count` 0 for an empty tree; unfinished if the
 * run was cancelled. */
wide_node *whittle_bvh_widen(whittle_team *team, const whittle_node *nodes, size_t node_count,
                             uint32_t *count, whittle_error *error);
