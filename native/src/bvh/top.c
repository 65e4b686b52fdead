/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* A tree over trees. */

#include "bvh/top.h"
#include "base/memory.h"

#include <string.h>

/* A wide leaf of several entries becomes a node with a child for each. */
_Static_assert(WHITTLE_WIDE_LEAF <= WHITTLE_WIDTH, "a wide leaf's entries fit a wide node");

whittle_status whittle_top_begin(top_tree *top, uint32_t count, whittle_error *error) {
  memset(top, 0, sizeof *top);
  top->count = count;
  top->fragments = whittle_allocate(2 * (size_t)count, sizeof *top->fragments);
  return top->fragments ? WHITTLE_OK : whittle_out_of_memory(error, "the tree over the instances");
}

void whittle_top_free(top_tree *top) {
  whittle_release(top->fragments);
  whittle_release(top->bvh.block);
  whittle_release(top->wide);
  memset(top, 0, sizeof *top);
}

/* The wide tree has at most a node for each entry, of which each leaf of two or more adds one. */
uint32_t whittle_top_wide_room(uint32_t count) {
  return count <= WHITTLE_WIDTH ? count > 0 : count + count / 2;
}

/* A wide node over entries that follow each other. */
static void fill(const top_tree *top, wide_node *wide, uint32_t first, uint32_t count) {
  memset(wide, 0xff, sizeof *wide); /* every float a NaN */
  for (uint32_t i = 0; i < count; i++) {
    const whittle_fragment *fragment = &top->fragments[first + i];
    for (int axis = 0; axis < 3; axis++) {
      wide->low[axis][i] = fragment->lo[axis];
      wide->high[axis][i] = fragment->hi[axis];
    }
    wide->child[i] = (wide_child){first + i, 1};
  }
}

/* Gives each leaf of several entries a node of its own. */
static void open_leaves(top_tree *top, uint32_t made) {
  for (uint32_t w = 0; w < made; w++) {
    wide_node *wide = &top->wide[w];
    for (uint32_t i = 0; i < WHITTLE_WIDTH; i++) {
      const wide_child child = wide->child[i];
      if (!wide_is_leaf(child) || child.count < 2)
        continue; /* an inner node, no child, or a single entry */
      fill(top, &top->wide[top->wide_count], child.first, child.count);
      wide->child[i] = (wide_child){top->wide_count++, WIDE_NODE};
    }
  }
}

static whittle_status widen(whittle_team *team, top_tree *top, whittle_error *error) {
  top->wide = whittle_allocate(whittle_top_wide_room(top->count), sizeof *top->wide);
  if (!top->wide)
    return whittle_out_of_memory(error, "the tree over the instances");
  if (top->count <= WHITTLE_WIDTH) {
    fill(top, top->wide, 0, top->count);
    top->wide_count = 1;
    return WHITTLE_OK;
  }
  wide_node *made =
      whittle_bvh_widen(team, top->bvh.nodes, top->bvh.node_count, &top->wide_count, error);
  if (!made)
    return WHITTLE_OUT_OF_MEMORY;
  memcpy(top->wide, made, top->wide_count * sizeof *made);
  whittle_release(made);
  if (!whittle_cancelled(team->state))
    open_leaves(top, top->wide_count);
  return WHITTLE_OK;
}

whittle_status whittle_top_build(whittle_team *team, top_tree *top,
                                 const whittle_bvh_options *options, whittle_error *error) {
  if (top->count == 0)
    return WHITTLE_OK;
  const whittle_status status = whittle_bvh_build(team, top->fragments, top->fragments + top->count,
                                                  top->count, options, &top->bvh, error);
  return status == WHITTLE_OK ? widen(team, top, error) : status;
}
