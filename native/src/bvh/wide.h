/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The tree with eight children to a node, collapsed from the binary one for speed. */

#pragma once

#include "bvh/bvh.h"

enum { WHITTLE_WIDTH = 8, WHITTLE_WIDE_LEAF = 8 };

/* The boxes of eight children as structures of arrays; those of missing children are NaN, which no
 * test lets pass. count > 0: a leaf of that many triangles from `child` on; else a node. */
typedef struct wide_node {
  float low[3][WHITTLE_WIDTH], high[3][WHITTLE_WIDTH];
  uint32_t child[WHITTLE_WIDTH], count[WHITTLE_WIDTH];
} wide_node;

_Static_assert(sizeof(wide_node) == 256, "four cache lines");

/* Opens the largest children of each node first (Wald, Benthin, Boulos: Getting Rid of Packets,
 * 2008); subtrees of at most WHITTLE_WIDE_LEAF triangles become leaves. Triangles of a subtree lie
 * next to each other. NULL if memory ran out; `count` 0 for an empty tree; unfinished if the run
 * was cancelled. */
wide_node *whittle_bvh_widen(const whittle_node *nodes, size_t node_count, whittle_run_state *state,
                             uint32_t *count, whittle_error *error);
