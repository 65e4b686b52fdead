/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Building one scene with both sides in turns, and the streams of rays that they race on. */

#include "contest.h"

#include "compare.h"
#include "fail.h"
#include "measure.h"
#include "outcome.h"
#include "race.h"
#include "records.h"
#include "scenes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Whether a kind of record is wanted. */
static int wants(const settings *s, const char *kind) {
  size_t length = strlen(kind);
  for (const char *p = s->kinds; p; p = strchr(p, ',')) {
    p += *p == ',';
    if (strncmp(p, kind, length) == 0 && (p[length] == '\0' || p[length] == ','))
      return 1;
  }
  return s->kinds == NULL;
}

static double run_our_build(void *user) {
  contest *c = user;
  double seconds = ours_build(&c->ours, &c->mesh, c->threads);
  ours_release(&c->ours);
  return seconds;
}

static double run_embree_build(void *user) {
  contest *c = user;
  double seconds = embree_build(&c->embree, 0, &c->mesh, c->settings->quality);
  embree_release(&c->embree);
  return seconds;
}

static void measure_build(contest *c) {
  if (!wants(c->settings, "build"))
    return;
  size_t rounds = c->settings->rounds;
  double *seconds = allocate(rounds * 2, sizeof(double));
  embree_open(&c->embree, c->threads, c->embree_isa);
  contender both[2] = {{run_our_build, c, seconds}, {run_embree_build, c, seconds + rounds}};
  measure_rounds(both, 2, rounds);
  long long before = c->embree.bytes;
  embree_build(&c->embree, 0, &c->mesh, c->settings->quality);
  long long bytes = c->embree.bytes - before;
  embree_release(&c->embree);
  embree_close(&c->embree);
  outcome o = outcome_judge(seconds, seconds + rounds, rounds, c->mesh.triangle_count);
  outcome_begin_record(c, "build", &o, "commit");
  outcome_record_hits(0, 0, 0, 0);
  record_count("whittle_bytes", c->ours.stats.bytes - c->ours.stats.bytes_meshes);
  record_count("whittle_bytes_meshes", c->ours.stats.bytes_meshes);
  record_count("whittle_bytes_binary", ours_bytes_to_count(&c->mesh, c->threads));
  record_count("embree_bytes", (unsigned long long)bytes);
  record_count("nodes", c->ours.stats.nodes);
  record_count("depth", c->ours.stats.depth);
  record_number("sah_cost", c->ours.stats.sah_cost);
  record_end();
  free(seconds);
}

/* One stream with one thread and with all; Whittle must find the same bits with both. */
static void measure_stream(contest *c, stream s) {
  c->stream = s;
  if (!wants(c->settings, s.kind)) {
    stream_free(&c->stream);
    return;
  }
  if (s.count == 0) {
    fprintf(stderr, "bench: %s: no %s rays, nothing is in view\n", c->name, s.kind);
    stream_free(&c->stream);
    return;
  }
  c->found_ours = hits_new(&s);
  c->found_embree = hits_new(&s);
  hits alone = hits_new(&s);
  unsigned counts[2] = {1, c->settings->threads};
  for (int i = 0; i < (counts[1] > 1 ? 2 : 1); i++) {
    c->threads = counts[i];
    c->crew = crew_new(c->threads);
    race_run(c);
    crew_free(c->crew);
    if (i == 0)
      ours_trace(&c->ours, &s, &alone, 1);
    if (!compare_identical(&s, &alone, &c->found_ours))
      fail("%s: Whittle finds other %s hits with %u threads than with 1", c->name, s.kind,
           c->threads);
  }
  hits_free(&alone);
  hits_free(&c->found_ours);
  hits_free(&c->found_embree);
  stream_free(&c->stream);
}

/* Embree's builds side by side: the one compared with, and those that may trace faster or closer.
 */
static void build_embree(contest *c) {
  static const char *const others[] = {"medium", "robust", "high"};
  c->builds[c->build_count++] = c->settings->quality;
  for (int i = 0; i < 3 && !c->settings->one_build; i++)
    if (strcmp(others[i], c->settings->quality) != 0)
      c->builds[c->build_count++] = others[i];
  for (unsigned i = 0; i < c->build_count; i++)
    embree_build(&c->embree, i, &c->mesh, c->builds[i]);
}

/* The hits that shadow and mirror rays start from are those of Embree's single rays, so that the
 * rays do not depend on what is measured. */
static void measure_rays(contest *c) {
  const settings *s = c->settings;
  embree_open(&c->embree, s->threads, c->embree_isa);
  build_embree(c);
  ours_build(&c->ours, &c->mesh, s->threads);
  stream primary = rays_primary(&c->mesh, s->width, s->height);
  hits found = hits_new(&primary);
  race_find(c, &primary, &found);
  stream shadow = rays_shadow(&c->mesh, &primary, &found);
  stream mirror = rays_mirror(&c->mesh, &primary, &found);
  hits_free(&found);
  measure_stream(c, primary);
  measure_stream(c, shadow);
  measure_stream(c, mirror);
  measure_stream(c, rays_random(&c->mesh, ((size_t)s->width * s->height + 3) / 4));
  ours_release(&c->ours);
  embree_release(&c->embree);
  embree_close(&c->embree);
}

void contest_run(const settings *s, const char *scene) {
  contest c = {.settings = s};
  int is_widest;
  c.isa = ours_isa(&is_widest);
  c.embree_isa = is_widest && !s->isa ? NULL : c.isa;
  c.mesh = scenes_load(scene, (float)s->width / (float)s->height);
  char *label = scenes_label(scene);
  c.name = label;
  embree_load(&c.embree, s->library);
  c.threads = 1;
  measure_build(&c);
  if (s->threads > 1) {
    c.threads = s->threads;
    measure_build(&c);
  }
  if (!s->kinds || strcmp(s->kinds, "build") != 0)
    measure_rays(&c);
  mesh_free(&c.mesh);
  free(label);
}
