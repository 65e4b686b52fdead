/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Building a scene: flatten, grow the tree, gather the triangles, and only then replace the old. */

#include "base/clock.h"
#include "base/memory.h"
#include "bvh/wide.h"
#include "scene/flatten.h"
#include "scene/mesh.h"

#include <math.h>
#include <string.h>

/* What a build holds until it has succeeded. */
typedef struct build {
  whittle_scene *scene;
  whittle_build_options options; /* with the defaults filled in */
  whittle_team team;
  flat_scene flat;
  whittle_bvh bvh;
  wide_node *wide;
  uint32_t wide_count;
  triangle_record *records;
  double started, flattened;
  whittle_status status;
  whittle_error error;
} build;

static whittle_status fill_options(const whittle_build_options *given, whittle_build_options *all,
                                   whittle_error *error) {
  memset(all, 0, sizeof *all);
  if (given)
    *all = *given;
  all->threads = all->threads ? all->threads : whittle_default_threads();
  all->bins = all->bins ? all->bins : 16;
  all->max_leaf = all->max_leaf ? all->max_leaf : 8;
  all->traversal_cost = all->traversal_cost != 0.0f ? all->traversal_cost : 1.0f;
  if (all->bins < 2 || all->bins > 64)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "bins",
                        "%u bins: choose 2 to 64, or 0 for 16.", all->bins);
  if (all->max_leaf > 64)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "max_leaf",
                        "%u triangles in a leaf: choose 1 to 64, or 0 for 8.", all->max_leaf);
  if (!(all->traversal_cost > 0.0f && all->traversal_cost <= 1e6f))
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "traversal_cost",
                        "A traversal cost of %g: choose a number above 0 and at most 1e6, or 0 for "
                        "1.",
                        (double)all->traversal_cost);
  return WHITTLE_OK;
}

static whittle_status lead(build *b) {
  whittle_error *error = &b->error;
  whittle_status status = whittle_flatten(&b->team, b->scene, &b->flat, error);
  if (status != WHITTLE_OK || whittle_cancelled(b->team.state))
    return status;
  b->flattened = whittle_seconds();
  const whittle_bvh_options options = {
      .bins = b->options.bins,
      .max_leaf = b->options.max_leaf,
      .traversal_cost = b->options.traversal_cost,
  };
  status = whittle_bvh_build(&b->team, b->flat.fragments, b->flat.spare, (uint32_t)b->flat.count,
                             &options, &b->bvh, error);
  if (status != WHITTLE_OK)
    return status;
  b->records = whittle_flat_records(&b->team, b->scene, &b->flat);
  b->wide =
      whittle_bvh_widen(b->bvh.nodes, b->bvh.node_count, b->team.state, &b->wide_count, error);
  return b->wide ? WHITTLE_OK : WHITTLE_OUT_OF_MEMORY;
}

static void work(void *context, uint32_t worker, whittle_run_state *state) {
  build *b = context;
  (void)state;
  if (worker == 0) {
    b->status = lead(b);
    whittle_team_close(&b->team);
  } else {
    whittle_team_help(&b->team);
  }
}

static void fill_stats(const build *b, whittle_build_stats *stats) {
  const whittle_scene *scene = b->scene;
  const double now = whittle_seconds();
  memset(stats, 0, sizeof *stats);
  stats->triangles = b->flat.count;
  for (size_t i = 0; i < scene->mesh_count; i++) {
    stats->dropped_non_finite += b->flat.drops[i].non_finite;
    stats->dropped_zero_area += b->flat.drops[i].zero_area;
    stats->bytes_meshes += whittle_mesh_bytes(&scene->meshes[i]);
  }
  stats->meshes = (uint32_t)scene->mesh_count;
  stats->instances = (uint32_t)scene->instance_count;
  stats->nodes = b->bvh.node_count;
  stats->leaves = b->bvh.leaves;
  stats->depth = b->bvh.depth;
  stats->largest_leaf = b->bvh.largest_leaf;
  stats->threads = b->options.threads;
  stats->bins = b->options.bins;
  stats->sah_cost = b->bvh.sah_cost;
  stats->bytes_nodes = b->bvh.node_count * sizeof(whittle_node) + b->wide_count * sizeof(wide_node);
  stats->bytes_triangles = b->flat.count * sizeof(triangle_record);
  stats->bytes = stats->bytes_nodes + stats->bytes_triangles + stats->bytes_meshes;
  stats->seconds = now - b->started;
  stats->seconds_flatten = b->flattened - b->started;
  stats->seconds_tree = now - b->flattened;
  memcpy(stats->center, b->flat.frame.center, sizeof stats->center);
  stats->exponent = b->flat.frame.exponent;
}

/* The build has succeeded: its structures take the place of the old ones. */
static void commit(build *b) {
  whittle_scene *scene = b->scene;
  whittle_release(scene->node_block);
  whittle_release(scene->triangles);
  whittle_release(scene->wide);
  scene->frame = b->flat.frame;
  scene->nodes = b->bvh.nodes;
  scene->node_block = b->bvh.block;
  scene->node_count = b->bvh.node_count;
  scene->wide = b->wide;
  scene->wide_count = b->wide_count;
  scene->triangles = b->records;
  scene->triangle_count = (size_t)b->flat.count;
  b->bvh.block = NULL;
  b->wide = NULL;
  b->records = NULL;
  for (size_t i = 0; i < scene->mesh_count; i++) {
    scene->meshes[i].dropped_non_finite = b->flat.drops[i].non_finite;
    scene->meshes[i].dropped_zero_area = b->flat.drops[i].zero_area;
  }
  scene->options = b->options;
  scene->options.progress = (whittle_progress){0};
  fill_stats(b, &scene->stats);
  scene->built = true;
}

/* A thread costs more than it brings for fewer triangles than this. */
enum { TRIANGLES_PER_WORKER = 4096 };

static uint32_t workers_for(const build *b) {
  const uint64_t useful = 1 + b->flat.index.triangles / TRIANGLES_PER_WORKER;
  return useful < b->options.threads ? (uint32_t)useful : b->options.threads;
}

static whittle_status run(build *b, whittle_error *error) {
  whittle_run_state state = {.total = 0};
  whittle_status status = whittle_flat_begin(b->scene, &b->flat, error);
  if (status != WHITTLE_OK)
    return status;
  state.total = whittle_flat_units(&b->flat) + whittle_bvh_units(b->flat.index.triangles);
  whittle_team_init(&b->team, &state);
  status = whittle_run(workers_for(b), work, b, &state, &b->options.progress, error);
  whittle_team_destroy(&b->team);
  if (status != WHITTLE_OK)
    return status;
  if (b->status != WHITTLE_OK)
    return whittle_fail(error, b->status, b->error.argument, "%s", b->error.message);
  return WHITTLE_OK;
}

whittle_status whittle_scene_build(whittle_scene *scene, const whittle_build_options *options,
                                   whittle_build_stats *stats, whittle_error *error) {
  build *b = whittle_allocate(1, sizeof *b);
  if (!b)
    return whittle_out_of_memory(error, "a build");
  memset(b, 0, sizeof *b);
  b->scene = scene;
  b->started = whittle_seconds();
  whittle_status status = fill_options(options, &b->options, error);
  if (status == WHITTLE_OK)
    status = whittle_scene_write_begin(scene, error);
  if (status == WHITTLE_OK) {
    status = run(b, error);
    if (status == WHITTLE_OK)
      commit(b);
    if (status == WHITTLE_OK && stats)
      *stats = scene->stats;
    whittle_scene_write_end(scene);
  }
  whittle_flat_free(&b->flat);
  whittle_release(b->bvh.block);
  whittle_release(b->wide);
  whittle_release(b->records);
  whittle_release(b);
  return status;
}
