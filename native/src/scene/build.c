/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Building a scene: as one tree over all triangles, or with a subtree for each instance. Only what
 * has succeeded replaces the old. */

#include "base/clock.h"
#include "base/memory.h"
#include "scene/mesh.h"
#include "scene/subtrees_build.h"

#include <string.h>

/* What a build holds until it has succeeded. */
typedef struct build {
  whittle_scene *scene;
  whittle_build_options options; /* with the defaults filled in */
  whittle_team team;
  flat_scene flat; /* of the one tree, as all of these */
  grown_tree grown;
  double flattened;
  subtrees_build subtrees; /* or by instance */
  double started;
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

static whittle_bvh_options tree_options(const build *b) {
  return (whittle_bvh_options){.bins = b->options.bins,
                               .max_leaf = b->options.max_leaf,
                               .traversal_cost = b->options.traversal_cost,
                               .whole = b->options.lean ? WHITTLE_WIDE_LEAF : 0};
}

static whittle_status lead_whole(build *b) {
  const whittle_bvh_options options = tree_options(b);
  const world_bounds bounds = whittle_flat_bounds(&b->team, b->scene, &b->flat);
  b->flat.frame = whittle_frame_of(&bounds);
  whittle_status status = whittle_flatten(&b->team, b->scene, &b->flat, &b->error);
  if (status != WHITTLE_OK || whittle_cancelled(b->team.state))
    return status;
  b->flattened = whittle_seconds();
  status = whittle_grow(&b->team, &b->flat, &options, &b->grown, &b->error);
  if (status == WHITTLE_OK)
    status = whittle_grow_wide(&b->team, &b->grown, &b->error);
  if (b->options.lean)
    whittle_bvh_drop(&b->grown.bvh);
  if (status == WHITTLE_OK && !whittle_cancelled(b->team.state))
    whittle_flat_triangles(&b->team, b->scene, &b->flat, &b->grown.triangles);
  return status;
}

static void work(void *context, uint32_t worker, whittle_run_state *state) {
  build *b = context;
  (void)state;
  if (worker == 0) {
    b->status = b->options.by_instance ? whittle_subtrees_lead(&b->subtrees, &b->team, &b->error)
                                       : lead_whole(b);
    whittle_team_close(&b->team);
  } else {
    whittle_team_help(&b->team);
  }
}

/* The one tree takes the place of the old arrays, which are then the build's. */
static void commit_whole(build *b) {
  whittle_scene *scene = b->scene;
  grown_tree *grown = &b->grown;
  const grown_tree old = {
      .bvh = {.block = scene->node_block}, .wide = scene->wide, .triangles = scene->triangles};
  scene->frame = b->flat.frame;
  scene->nodes = grown->bvh.nodes;
  scene->node_block = grown->bvh.block;
  scene->node_count = grown->bvh.nodes ? grown->bvh.node_count : 0;
  scene->wide = grown->wide;
  scene->wide_count = grown->wide_count;
  scene->triangles = grown->triangles;
  scene->triangle_count = grown->triangle_count;
  whittle_subtrees_free(scene->subtrees);
  scene->subtrees = NULL;
  grown->bvh.block = old.bvh.block;
  grown->wide = old.wide;
  grown->triangles = old.triangles;
}

static void count_drops(const build *b) {
  whittle_scene *scene = b->scene;
  for (size_t i = 0; i < scene->mesh_count; i++)
    scene->meshes[i].dropped_non_finite = scene->meshes[i].dropped_zero_area = 0;
  for (size_t i = 0; i < scene->instance_count; i++) {
    mesh *m = &scene->meshes[scene->instances[i].mesh];
    const subtree *own = scene->subtrees ? &scene->subtrees->list[i] : NULL;
    m->dropped_non_finite += own ? own->dropped_non_finite : b->flat.drops[i].non_finite;
    m->dropped_zero_area += own ? own->dropped_zero_area : b->flat.drops[i].zero_area;
  }
}

static void fill_bytes(const whittle_scene *scene, whittle_build_stats *stats) {
  stats->bytes_binary = scene->node_count * sizeof(whittle_node);
  for (size_t i = 0; i < scene->mesh_count; i++) {
    stats->dropped_non_finite += scene->meshes[i].dropped_non_finite;
    stats->dropped_zero_area += scene->meshes[i].dropped_zero_area;
    stats->bytes_meshes += whittle_mesh_bytes(&scene->meshes[i]);
  }
  for (size_t i = 0; i < scene->instance_count; i++)
    stats->instances += !scene->instances[i].removed;
  stats->bytes_nodes =
      scene->node_count * sizeof(whittle_node) + scene->wide_count * sizeof(wide_node);
  stats->bytes_triangles = whittle_triangles_bytes(scene->triangle_count);
  stats->bytes = stats->bytes_nodes + stats->bytes_triangles + stats->bytes_meshes;
}

static void fill_times(const build *b, whittle_build_stats *stats) {
  const bool by_instance = b->options.by_instance;
  const double now = whittle_seconds();
  const double flattened = by_instance ? b->subtrees.framed : b->flattened;
  stats->seconds = now - b->started;
  stats->seconds_flatten = flattened - b->started;
  stats->seconds_tree = now - flattened;
  stats->seconds_join = by_instance ? now - b->subtrees.grew : 0.0;
}

static void fill_stats(const build *b, whittle_build_stats *stats) {
  const whittle_scene *scene = b->scene;
  const bool by_instance = b->options.by_instance;
  const whittle_bvh *tree = by_instance ? &b->subtrees.summary : &b->grown.bvh;
  memset(stats, 0, sizeof *stats);
  stats->triangles = scene->triangle_count;
  stats->meshes = (uint32_t)scene->mesh_count;
  stats->nodes = tree->node_count;
  stats->leaves = tree->leaves;
  stats->depth = tree->depth;
  stats->largest_leaf = tree->largest_leaf;
  stats->sah_cost = tree->sah_cost;
  stats->threads = b->options.threads;
  stats->bins = b->options.bins;
  stats->subtrees = by_instance ? b->subtrees.live : 0;
  stats->subtrees_built = by_instance ? b->subtrees.changed_count : 0;
  stats->frame_changed = by_instance && b->subtrees.frame_changed;
  memcpy(stats->center, scene->frame.center, sizeof stats->center);
  stats->exponent = scene->frame.exponent;
  fill_bytes(scene, stats);
  fill_times(b, stats);
}

/* The build has succeeded: its structures take the place of the old ones. */
static void commit(build *b) {
  whittle_scene *scene = b->scene;
  if (b->options.by_instance)
    whittle_subtrees_commit(&b->subtrees, scene);
  else
    commit_whole(b);
  count_drops(b);
  scene->options = b->options;
  scene->options.progress = (whittle_progress){0};
  fill_stats(b, &scene->stats);
  scene->built = true;
}

/* A thread costs more than it brings for fewer triangles than this. */
enum { TRIANGLES_PER_WORKER = 4096 };

static uint32_t workers_for(const build *b, uint64_t triangles) {
  const uint64_t useful = 1 + triangles / TRIANGLES_PER_WORKER;
  return useful < b->options.threads ? (uint32_t)useful : b->options.threads;
}

static whittle_status begin(build *b, uint64_t *triangles, whittle_error *error) {
  const whittle_bvh_options options = tree_options(b);
  const bool by_instance = b->options.by_instance;
  const whittle_status status =
      by_instance ? whittle_subtrees_begin(&b->subtrees, b->scene, &options, error)
                  : whittle_flat_begin(b->scene, 0, b->scene->instance_count, &b->flat, error);
  *triangles = by_instance ? b->subtrees.all.index.triangles : b->flat.index.triangles;
  return status;
}

static whittle_status run(build *b, whittle_error *error) {
  uint64_t triangles;
  whittle_status status = begin(b, &triangles, error);
  if (status != WHITTLE_OK)
    return status;
  whittle_run_state state = {.total = b->options.by_instance ? 0 : whittle_grow_units(triangles)};
  whittle_team_init(&b->team, &state);
  status = whittle_run(workers_for(b, triangles), work, b, &state, &b->options.progress, error);
  whittle_team_destroy(&b->team);
  if (status != WHITTLE_OK)
    return status;
  if (b->status != WHITTLE_OK)
    return whittle_fail(error, b->status, b->error.argument, "%s", b->error.message);
  return WHITTLE_OK;
}

static void end(build *b) {
  whittle_flat_free(&b->flat);
  whittle_grown_free(&b->grown);
  whittle_subtrees_end(&b->subtrees);
  whittle_release(b);
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
  end(b);
  return status;
}
