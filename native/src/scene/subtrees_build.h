/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* A build by instances: begun, led by one worker of a team, and then committed or not. */

#pragma once

#include "bvh/top.h"
#include "scene/subtrees.h"

#define NO_SUBTREE UINT32_MAX

/* The scene's arrays, and how many entries are in them. */
typedef struct scene_arrays {
  whittle_node *nodes, *node_block;
  wide_node *wide;
  triangle_store triangles;
  size_t node_count, wide_count, triangle_count;
} scene_arrays;

/* A subtree that was made anew. Its nodes are those below its pieces, and number from 0. */
typedef struct grown_subtree {
  grown_tree tree;
  subtree_piece *pieces;
} grown_subtree;

typedef struct subtrees_build {
  const whittle_scene *scene;
  bool lean; /* binary nodes are numbered and counted, but not kept */
  whittle_team *team;
  flat_scene all; /* only its index */
  scene_subtrees *next;
  uint32_t *changed; /* instances that get a new subtree, ascending */
  uint32_t changed_count, live;
  uint32_t *news;       /* by instance: its place in `changed`, or NO_SUBTREE */
  grown_subtree *grown; /* of the changed ones, in their order */
  top_tree top;
  whittle_bvh summary; /* of the whole, without nodes */
  scene_arrays made;
  bool in_place; /* `made` are the arrays that the scene has */
  bool frame_changed;
  double framed, grew;  /* when the frame was known and the subtrees had been made */
  pthread_mutex_t lock; /* of the two below */
  whittle_status status;
  whittle_error error;
} subtrees_build;

whittle_status whittle_subtrees_begin(subtrees_build *p, const whittle_scene *scene,
                                      const whittle_bvh_options *options, whittle_error *error);
whittle_status whittle_subtrees_lead(subtrees_build *p, whittle_team *team, whittle_error *error);
/* Leaves the old arrays, if they were replaced, to be released with the build. */
void whittle_subtrees_commit(subtrees_build *p, whittle_scene *scene);
void whittle_subtrees_end(subtrees_build *p);

void whittle_grown_subtree_free(grown_subtree *grown);

/* Finds the pieces of a subtree, of which `to` knows the number of triangles, and widens them. */
whittle_status whittle_subtree_open(whittle_team *team, grown_subtree *own, subtree *to,
                                    float traversal_cost, whittle_error *error);

/* The steps. */
whittle_status whittle_subtrees_bound(subtrees_build *p);
whittle_status whittle_subtrees_grow(subtrees_build *p);
whittle_status whittle_subtrees_join(subtrees_build *p, whittle_error *error);
void whittle_subtrees_put(subtrees_build *p); /* what whittle_subtrees_join left, if in place */
