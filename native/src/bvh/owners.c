/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Whose triangles lie under each node: one owner's, or those of several. */

#include "bvh/owners.h"

typedef struct owner_walk {
  const whittle_node *nodes;
  const uint32_t *labels;
  uint32_t shared;
  uint32_t *owners;
} owner_walk;

static uint32_t leaf_owner(const owner_walk *walk, const whittle_node *leaf) {
  const uint32_t *labels = walk->labels + leaf->left_first;
  for (uint32_t i = 1; i < leaf->count; i++)
    if (labels[i] != labels[0])
      return walk->shared;
  return labels[0];
}

/* As deep as the tree, so at most WHITTLE_MAX_DEPTH calls lie on the stack. */
static uint32_t settle(const owner_walk *walk, uint32_t index) {
  const whittle_node *node = &walk->nodes[index];
  uint32_t owner;
  if (node->count > 0) {
    owner = leaf_owner(walk, node);
  } else {
    const uint32_t left = settle(walk, node->left_first);
    const uint32_t right = settle(walk, node->left_first + 1);
    owner = left == right ? left : walk->shared;
  }
  return walk->owners[index] = owner;
}

void whittle_owners(const whittle_node *nodes, size_t count, const uint32_t *labels,
                    uint32_t shared, uint32_t *owners) {
  const owner_walk walk = {nodes, labels, shared, owners};
  if (count > 0)
    settle(&walk, 0);
}
