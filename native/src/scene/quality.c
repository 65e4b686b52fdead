/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Judging a built scene: the whole tree, then its parts, then what takes long and was asked for. */

#include "base/clock.h"
#include "base/memory.h"
#include "bvh/overlap.h"
#include "scene/own_trees.h"

#include <string.h>

typedef struct judging {
  judged_scene judged;
  whittle_quality_options options;
  whittle_quality *quality;
  own_order order;
  whittle_overlap overlap;
  whittle_team team;
  whittle_status status;
  whittle_error error;
} judging;

static whittle_part_quality *parts_of(size_t count) {
  whittle_part_quality *parts = whittle_allocate(count, sizeof *parts);
  if (parts)
    memset(parts, 0, count * sizeof *parts);
  return parts;
}

static whittle_status begin(judging *j, const whittle_scene *scene, whittle_error *error) {
  whittle_quality *quality = j->quality;
  quality->instance_count = scene->instance_count;
  quality->material_count = scene->material_count;
  quality->instances = parts_of(scene->instance_count);
  quality->materials = parts_of(scene->material_count);
  if (!quality->instances || !quality->materials)
    return whittle_out_of_memory(error, "the quality of the tree");
  quality->bytes = scene->stats.bytes;
  whittle_status status = whittle_judged_begin(scene, &j->judged, error);
  if (status == WHITTLE_OK && j->options.by_instance)
    status = whittle_own_order(&j->judged, scene->instance_count, &j->order, error);
  if (status != WHITTLE_OK || !j->options.overlap)
    return status;
  const uint64_t wanted = j->options.overlap_samples;
  j->overlap.count = wanted && wanted < scene->triangle_count ? wanted : scene->triangle_count;
  j->overlap.area = whittle_allocate((size_t)j->overlap.count, sizeof(double));
  j->overlap.foreign = whittle_allocate((size_t)j->overlap.count, sizeof(double));
  if (!j->overlap.area || !j->overlap.foreign)
    return whittle_out_of_memory(error, "the overlap of boxes");
  return WHITTLE_OK;
}

/* Adds up in the order of triangles, so that the sums have the same bits for any number of
 * workers. */
static void sum_overlap(const judging *j) {
  const whittle_overlap *overlap = &j->overlap;
  whittle_quality *quality = j->quality;
  double area = 0.0;
  for (uint64_t i = 0; i < overlap->count; i++)
    area += overlap->area[i];
  for (uint64_t i = 0; i < overlap->count && area > 0.0; i++) {
    const size_t triangle = whittle_overlap_triangle(&j->judged.tree, overlap->count, i);
    const double part = overlap->foreign[i] / area;
    quality->overlap += part;
    quality->instances[j->judged.instances[triangle]].overlap_part += part;
    quality->materials[j->judged.materials[triangle]].overlap_part += part;
  }
  quality->overlap_samples = overlap->count;
}

static whittle_status lead(judging *j) {
  const double traversal_cost = (double)j->judged.scene->options.traversal_cost;
  whittle_judge_shape(&j->judged.tree, traversal_cost, j->quality);
  whittle_status status = whittle_judge_parts(&j->judged, j->quality, &j->error);
  if (status == WHITTLE_OK && j->options.by_instance) {
    status = whittle_own_trees(&j->team, &j->judged, &j->order, j->quality, &j->error);
    if (status == WHITTLE_OK)
      whittle_inside_others(&j->team, &j->judged, &j->order, j->quality);
  }
  if (status == WHITTLE_OK && j->options.overlap)
    status =
        whittle_judge_overlap(&j->team, &j->judged.tree, traversal_cost, &j->overlap, &j->error);
  if (status == WHITTLE_OK && j->options.overlap && !whittle_cancelled(j->team.state))
    sum_overlap(j);
  return status;
}

static void work(void *context, uint32_t worker, whittle_run_state *state) {
  judging *j = context;
  (void)state;
  if (worker == 0) {
    j->status = lead(j);
    whittle_team_close(&j->team);
  } else {
    whittle_team_help(&j->team);
  }
}

static whittle_status run(judging *j, whittle_error *error) {
  whittle_run_state state = {.total = j->overlap.count * WHITTLE_OVERLAP_UNITS};
  if (j->options.by_instance)
    state.total += whittle_own_units(&j->order, j->quality->instance_count);
  const bool alone = !j->options.by_instance && !j->options.overlap;
  const uint32_t threads = j->options.threads ? j->options.threads : whittle_default_threads();
  whittle_team_init(&j->team, &state);
  const whittle_status status =
      whittle_run(alone ? 1 : threads, work, j, &state, &j->options.progress, error);
  whittle_team_destroy(&j->team);
  if (status == WHITTLE_OK && j->status != WHITTLE_OK)
    return whittle_fail(error, j->status, j->error.argument, "%s", j->error.message);
  return status;
}

static whittle_status judge(judging *j, const whittle_scene *scene, whittle_error *error) {
  whittle_status status = whittle_scene_read_begin(scene, error);
  if (status != WHITTLE_OK)
    return status;
  status = whittle_scene_has_binary(scene, "Its quality is", error);
  if (status == WHITTLE_OK)
    status = begin(j, scene, error);
  if (status == WHITTLE_OK)
    status = run(j, error);
  whittle_scene_read_end(scene);
  whittle_judged_free(&j->judged);
  whittle_own_order_free(&j->order);
  whittle_release(j->overlap.area);
  whittle_release(j->overlap.foreign);
  return status;
}

whittle_status whittle_scene_quality(const whittle_scene *scene,
                                     const whittle_quality_options *options,
                                     whittle_quality *quality, whittle_error *error) {
  const double started = whittle_seconds();
  memset(quality, 0, sizeof *quality);
  judging *j = whittle_allocate(1, sizeof *j);
  if (!j)
    return whittle_out_of_memory(error, "judging the tree");
  memset(j, 0, sizeof *j);
  j->quality = quality;
  if (options)
    j->options = *options;
  const whittle_status status = judge(j, scene, error);
  whittle_release(j);
  quality->seconds = whittle_seconds() - started;
  if (status != WHITTLE_OK)
    whittle_quality_free(quality);
  return status;
}

void whittle_quality_free(whittle_quality *quality) {
  if (!quality)
    return;
  whittle_release(quality->instances);
  whittle_release(quality->materials);
  memset(quality, 0, sizeof *quality);
}
