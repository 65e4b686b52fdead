/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Growing the subtrees of the instances that have changed: large ones by the whole team one after
 * the other, small ones each by one worker. */

#include "base/memory.h"
#include "scene/subtrees_build.h"

#include <string.h>

/* Triangles from which on a subtree keeps a team busy, and small subtrees taken at a time. */
enum { LARGE = 16384, GRAIN = 4 };

void whittle_grown_subtree_free(grown_subtree *grown) {
  whittle_grown_free(&grown->tree);
  whittle_release(grown->pieces);
  grown->pieces = NULL;
}

typedef whittle_status subtree_work(subtrees_build *p, whittle_team *team, uint32_t k,
                                    whittle_error *error);

typedef struct subtree_loop {
  subtrees_build *p;
  subtree_work *work;
} subtree_loop;

static bool is_large(const subtrees_build *p, uint32_t k) {
  const instance *where = &p->scene->instances[p->changed[k]];
  const mesh *m = &p->scene->meshes[where->mesh];
  return m->triangle_count >= LARGE || m->vertex_count >= LARGE;
}

static bool failed(subtrees_build *p) {
  pthread_mutex_lock(&p->lock);
  const bool bad = p->status != WHITTLE_OK;
  pthread_mutex_unlock(&p->lock);
  return bad || whittle_cancelled(p->team->state);
}

/* The first failure is what the build reports. */
static void work_on(const subtree_loop *loop, whittle_team *team, uint32_t k) {
  subtrees_build *p = loop->p;
  whittle_error error = {0};
  if (failed(p))
    return;
  const whittle_status status = loop->work(p, team, k, &error);
  pthread_mutex_lock(&p->lock);
  if (status != WHITTLE_OK && p->status == WHITTLE_OK) {
    p->status = status;
    p->error = error;
  }
  pthread_mutex_unlock(&p->lock);
}

static void work_on_small(void *context, uint64_t begin, uint64_t end) {
  const subtree_loop *loop = context;
  whittle_team alone;
  whittle_team_init(&alone, loop->p->team->state);
  for (uint64_t k = begin; k < end; k++)
    if (!is_large(loop->p, (uint32_t)k))
      work_on(loop, &alone, (uint32_t)k);
  whittle_team_destroy(&alone);
}

static whittle_status work_on_changed(subtrees_build *p, subtree_work *work) {
  subtree_loop loop = {p, work};
  for (uint32_t k = 0; k < p->changed_count; k++)
    if (is_large(p, k))
      work_on(&loop, p->team, k);
  whittle_team_for(p->team, p->changed_count, GRAIN, work_on_small, &loop);
  return p->status;
}

static whittle_status bound(subtrees_build *p, whittle_team *team, uint32_t k,
                            whittle_error *error) {
  const uint32_t i = p->changed[k];
  flat_scene flat;
  const whittle_status status = whittle_flat_begin(p->scene, i, 1, &flat, error);
  if (status == WHITTLE_OK)
    p->next->list[i].bounds = whittle_flat_bounds(team, p->scene, &flat);
  whittle_flat_free(&flat);
  return status;
}

whittle_status whittle_subtrees_bound(subtrees_build *p) {
  return work_on_changed(p, bound);
}

static whittle_status grow(subtrees_build *p, whittle_team *team, uint32_t k,
                           whittle_error *error) {
  const uint32_t i = p->changed[k];
  subtree *to = &p->next->list[i];
  grown_subtree *own = &p->grown[k];
  flat_scene flat;
  whittle_status status = whittle_flat_begin(p->scene, i, 1, &flat, error);
  flat.frame = p->next->frame;
  if (status == WHITTLE_OK)
    status = whittle_flatten(team, p->scene, &flat, error);
  if (status == WHITTLE_OK && !whittle_cancelled(team->state))
    status = whittle_grow(team, &flat, &p->next->options, &own->tree, error);
  if (status == WHITTLE_OK && !whittle_cancelled(team->state)) {
    to->dropped_non_finite = flat.drops[0].non_finite;
    to->dropped_zero_area = flat.drops[0].zero_area;
    to->triangles = (uint32_t)own->tree.triangle_count;
    status = whittle_subtree_open(team, own, to, p->next->options.traversal_cost, error);
  }
  if (p->lean)
    whittle_bvh_drop(&own->tree.bvh);
  if (status == WHITTLE_OK && !whittle_cancelled(team->state))
    whittle_flat_triangles(team, p->scene, &flat, &own->tree.triangles);
  whittle_flat_free(&flat);
  return status;
}

whittle_status whittle_subtrees_grow(subtrees_build *p) {
  p->grown = whittle_allocate(p->changed_count, sizeof *p->grown);
  if (!p->grown)
    return p->status = whittle_out_of_memory(&p->error, "the subtrees of the instances");
  memset(p->grown, 0, p->changed_count * sizeof *p->grown);
  return work_on_changed(p, grow);
}
