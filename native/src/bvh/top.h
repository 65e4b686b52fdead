/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* A tree over trees: the same builder over their boxes, each of which becomes a leaf. */

#pragma once

#include "bvh/wide.h"

/* Leaves of both trees hold one entry each and name its position among the fragments, which lie in
 * leaf order. */
typedef struct top_tree {
  whittle_fragment *fragments;
  uint32_t count; /* of the entries */
  whittle_bvh bvh;
  wide_node *wide;
  uint32_t wide_count;
} top_tree;

/* Room for the fragments of `count` entries, to be filled before the top is built. */
whittle_status whittle_top_begin(top_tree *top, uint32_t count, whittle_error *error);
whittle_status whittle_top_build(whittle_team *team, top_tree *top,
                                 const whittle_bvh_options *options, whittle_error *error);
void whittle_top_free(top_tree *top);

/* The most wide nodes that a top over so many entries has. */
uint32_t whittle_top_wide_room(uint32_t count);
