/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The bounding volume hierarchy: what goes in, what comes out. */

#pragma once

#include "base/team.h"

_Static_assert(sizeof(whittle_node) == 32, "two nodes to a cache line");

/* Edges from the root to the deepest leaf, for up to 2^31 triangles of any shape: traversals size
 * their stacks by it. */
enum { WHITTLE_MAX_DEPTH = 64 };

/* What the builder knows of a triangle: its box, and the two numbers that find it again. Boxes lie
 * in [-1, 1] and hold neither NaN nor -0. Aligned to 32. */
typedef struct whittle_fragment {
  float lo[3];
  uint32_t triangle;
  float hi[3];
  uint32_t instance;
} whittle_fragment;

typedef struct whittle_bvh_options {
  uint32_t bins, max_leaf;
  float traversal_cost;
  uint32_t max_depth; /* 0: WHITTLE_MAX_DEPTH; at least log2(count), rounded up */
  uint32_t whole;     /* so many triangles or fewer are a leaf, whatever it costs */
} whittle_bvh_options;

typedef struct whittle_bvh {
  whittle_node *nodes; /* = block + 1: then siblings share a cache line */
  whittle_node *block; /* to be released */
  uint32_t node_count, leaves, depth, largest_leaf;
  double cost;     /* traversal cost x areas of inner nodes + sum of count x leaf area */
  double sah_cost; /* that, by the root's area */
} whittle_bvh;

/* Builds the tree over fragments, which end up in leaf order; `spare` has room for as many. Called
 * by the leader of a team whose members help. The tree depends on the fragments, their order and
 * the options alone. `count` is at most 2^31 - 1. WHITTLE_CANCELLED, or a tree of no use, if the
 * run was cancelled. */
whittle_status whittle_bvh_build(whittle_team *team, whittle_fragment *fragments,
                                 whittle_fragment *spare, uint32_t count,
                                 const whittle_bvh_options *options, whittle_bvh *bvh,
                                 whittle_error *error);

/* Releases the nodes; what is known of them stays. */
void whittle_bvh_drop(whittle_bvh *bvh);

/* How many units whittle_bvh_build adds to the run's `done`. */
uint64_t whittle_bvh_units(uint64_t count);
