/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What a counting render can tell of its rays beside two numbers each: who pays, how deep, where.
 */

#pragma once

#include "kernel/ray_log.h"

/* Whose triangles lie under a node, as columns of the tables of cost; the last is of several. */
typedef struct node_owner {
  uint32_t instance, material;
} node_owner;

/* Who owns what in a scene. */
typedef struct cost_owners {
  const node_owner *nodes;
  const uint32_t *materials; /* of each triangle in leaf order */
  uint32_t instance_count, material_count;
} cost_owners;

/* One worker's counts for one kind of ray: a number for each column. */
typedef struct cost_row {
  uint64_t *instance_nodes, *instance_triangles;
  uint64_t *material_nodes, *material_triangles;
} cost_row;

/* Of the packets that a pixel's rays were in, over the nodes that these entered: their rays that
 * entered too, and all their rays. */
typedef struct packet_share {
  uint64_t active, visited;
} packet_share;

/* What is wanted of the rays of one batch. */
typedef struct ray_watch {
  const uint32_t *slot;      /* of the tile's pixel, by ray */
  uint32_t *leaf_depth;      /* by slot: the deepest leaf visited */
  const cost_owners *owners; /* NULL: nobody is charged */
  const cost_row *charged;
  ray_log *log;         /* NULL: nothing is logged */
  packet_share *shares; /* by slot, of packets in the lecture mode; NULL: not wanted */
} ray_watch;
