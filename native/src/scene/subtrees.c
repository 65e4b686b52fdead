/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Building by instances: which have changed, in which frame, and the order of the steps. */

#include "scene/subtrees.h"
#include "base/clock.h"
#include "base/memory.h"
#include "scene/subtrees_build.h"

#include <string.h>

void whittle_subtrees_free(scene_subtrees *subtrees) {
  if (!subtrees)
    return;
  whittle_release(subtrees->list);
  whittle_release(subtrees->order);
  whittle_release(subtrees->pieces);
  whittle_release(subtrees);
}

static scene_subtrees *new_subtrees(size_t count) {
  scene_subtrees *subtrees = whittle_allocate(1, sizeof *subtrees);
  if (!subtrees)
    return NULL;
  memset(subtrees, 0, sizeof *subtrees);
  subtrees->count = count;
  subtrees->list = whittle_allocate(count, sizeof *subtrees->list);
  subtrees->order = whittle_allocate(count, sizeof *subtrees->order);
  if (subtrees->list && subtrees->order)
    return subtrees;
  whittle_subtrees_free(subtrees);
  return NULL;
}

static bool same_origin(const subtree *before, const instance *where, const mesh *m) {
  return before->version == m->version &&
         memcmp(before->transform, where->transform, sizeof before->transform) == 0;
}

/* Takes over what is known of an instance; false if there is nothing: it is new or has changed. */
static bool carry_over(const scene_subtrees *old, const whittle_scene *scene, size_t i,
                       subtree *to) {
  const instance *where = &scene->instances[i];
  const mesh *m = &scene->meshes[where->mesh];
  if (old && i < old->count && !where->removed && same_origin(&old->list[i], where, m)) {
    *to = old->list[i];
    return true;
  }
  memset(to, 0, sizeof *to);
  if (where->removed)
    return true;
  to->version = m->version;
  memcpy(to->transform, where->transform, sizeof to->transform);
  return false;
}

whittle_status whittle_subtrees_begin(subtrees_build *p, const whittle_scene *scene,
                                      const whittle_bvh_options *options, whittle_error *error) {
  const size_t count = scene->instance_count;
  memset(p, 0, sizeof *p);
  p->scene = scene;
  p->lean = options->whole > 0;
  const whittle_status status = whittle_flat_begin(scene, 0, count, &p->all, error);
  if (status != WHITTLE_OK)
    return status;
  p->next = new_subtrees(count);
  p->changed = whittle_allocate(count, sizeof *p->changed);
  p->news = whittle_allocate(count, sizeof *p->news);
  if (!p->next || !p->changed || !p->news)
    return whittle_out_of_memory(error, "the list of instances");
  p->next->options = *options;
  p->next->options.max_depth = SUBTREE_DEPTH;
  for (size_t i = 0; i < count; i++) {
    p->live += !scene->instances[i].removed;
    if (!carry_over(scene->subtrees, scene, i, &p->next->list[i]))
      p->changed[p->changed_count++] = (uint32_t)i;
  }
  if (p->live > MOST_SUBTREES)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "by_instance",
                        "%u instances: at most %d can have subtrees of their own. Join some meshes "
                        "or build without by_instance.",
                        p->live, (int)MOST_SUBTREES);
  return WHITTLE_OK;
}

void whittle_subtrees_end(subtrees_build *p) {
  for (uint32_t k = 0; p->grown && k < p->changed_count; k++)
    whittle_grown_subtree_free(&p->grown[k]);
  whittle_release(p->grown);
  whittle_release(p->changed);
  whittle_release(p->news);
  whittle_flat_free(&p->all);
  whittle_top_free(&p->top);
  whittle_subtrees_free(p->next);
  if (!p->in_place) {
    whittle_release(p->made.node_block);
    whittle_release(p->made.wide);
    whittle_triangles_release(&p->made.triangles);
  }
}

static bool same_frame(const scene_frame *a, const scene_frame *b) {
  return a->exponent == b->exponent && a->center[0] == b->center[0] &&
         a->center[1] == b->center[1] && a->center[2] == b->center[2];
}

static bool same_options(const whittle_bvh_options *a, const whittle_bvh_options *b) {
  return a->bins == b->bins && a->max_leaf == b->max_leaf &&
         a->traversal_cost == b->traversal_cost && a->max_depth == b->max_depth &&
         a->whole == b->whole;
}

/* With the frame known, all is known that a subtree depends on. */
static void choose_changed(subtrees_build *p) {
  scene_subtrees *next = p->next;
  const scene_subtrees *old = p->scene->subtrees;
  world_bounds bounds = WORLD_EMPTY;
  for (size_t i = 0; i < next->count; i++)
    if (next->list[i].version)
      world_unite(&bounds, &next->list[i].bounds);
  next->frame = whittle_frame_of(&bounds);
  p->frame_changed = old && !same_frame(&old->frame, &next->frame);
  if (!old || p->frame_changed || !same_options(&old->options, &next->options)) {
    p->changed_count = 0;
    for (size_t i = 0; i < next->count; i++)
      if (next->list[i].version)
        p->changed[p->changed_count++] = (uint32_t)i;
  }
  for (size_t i = 0; i < next->count; i++)
    p->news[i] = NO_SUBTREE;
  for (uint32_t k = 0; k < p->changed_count; k++)
    p->news[p->changed[k]] = k;
}

static uint64_t units(const subtrees_build *p) {
  uint64_t sum = 0;
  for (uint32_t k = 0; k < p->changed_count; k++) {
    const instance *where = &p->scene->instances[p->changed[k]];
    sum += whittle_grow_units(p->scene->meshes[where->mesh].triangle_count);
  }
  return sum;
}

whittle_status whittle_subtrees_lead(subtrees_build *p, whittle_team *team, whittle_error *error) {
  p->team = team;
  pthread_mutex_init(&p->lock, NULL);
  if (whittle_subtrees_bound(p) == WHITTLE_OK && !whittle_cancelled(team->state)) {
    choose_changed(p);
    p->framed = whittle_seconds();
    atomic_store(&team->state->total, units(p));
    whittle_subtrees_grow(p);
  }
  p->grew = whittle_seconds();
  if (p->status == WHITTLE_OK && !whittle_cancelled(team->state))
    p->status = whittle_subtrees_join(p, &p->error);
  pthread_mutex_destroy(&p->lock);
  if (p->status == WHITTLE_OK)
    return WHITTLE_OK;
  return whittle_fail(error, p->status, p->error.argument, "%s", p->error.message);
}

void whittle_subtrees_commit(subtrees_build *p, whittle_scene *scene) {
  scene_arrays *made = &p->made;
  const scene_arrays old = {
      .node_block = scene->node_block, .wide = scene->wide, .triangles = scene->triangles};
  if (p->in_place)
    whittle_subtrees_put(p);
  scene->frame = p->next->frame;
  scene->nodes = made->nodes;
  scene->node_block = made->node_block;
  scene->node_count = p->lean ? 0 : made->node_count;
  scene->wide = made->wide;
  scene->wide_count = (uint32_t)made->wide_count;
  scene->triangles = made->triangles;
  scene->triangle_count = made->triangle_count;
  scene_subtrees *before = scene->subtrees;
  scene->subtrees = p->next;
  p->next = before;
  *made = old;
}
