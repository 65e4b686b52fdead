/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Building and tracing one scene with both sides, in turns. */

#include "contest.h"

#include "clock.h"
#include "compare.h"
#include "embree.h"
#include "fail.h"
#include "measure.h"
#include "ours.h"
#include "records.h"
#include "scenes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What one scene's measurements share. */
typedef struct contest {
  const settings *settings;
  const char *name, *isa, *embree_isa; /* embree_isa NULL: its own choice */
  mesh mesh;
  ours ours;
  embree embree;
  unsigned threads; /* of the measurement at hand */
  crew *crew;
  stream stream; /* and its rays */
  hits found_ours, found_embree;
} contest;

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
  double seconds = embree_build(&c->embree, &c->mesh, c->settings->quality);
  embree_release(&c->embree);
  return seconds;
}

static double run_our_trace(void *user) {
  contest *c = user;
  double start = clock_seconds();
  ours_trace(&c->ours, &c->stream, &c->found_ours, c->threads);
  return clock_seconds() - start;
}

typedef struct embree_run {
  contest *contest;
  const embree_mode *mode;
} embree_run;

static double run_embree_trace(void *user) {
  embree_run *r = user;
  double start = clock_seconds();
  embree_trace(&r->contest->embree, r->mode, &r->contest->stream, &r->contest->found_embree,
               r->contest->crew);
  return clock_seconds() - start;
}

/* Rates in millions a second, from the seconds of each round. */
typedef struct outcome {
  double ours, embree, ratio, spread, ours_spread, embree_spread;
} outcome;

static outcome judge(const double *ours, const double *embree, size_t rounds, size_t work) {
  double *ratios = allocate(rounds, sizeof(double));
  for (size_t i = 0; i < rounds; i++)
    ratios[i] = embree[i] / ours[i];
  outcome o;
  o.ours = (double)work * 1e-6 / measure_quantile(ours, rounds, 0.5);
  o.embree = (double)work * 1e-6 / measure_quantile(embree, rounds, 0.5);
  o.ratio = o.ours / o.embree;
  o.spread = measure_spread(ratios, rounds);
  o.ours_spread = measure_spread(ours, rounds);
  o.embree_spread = measure_spread(embree, rounds);
  free(ratios);
  return o;
}

/* What every record holds, whatever was measured. */
static void begin_record(const contest *c, const char *kind, const outcome *o, const char *mode) {
  record_begin();
  record_text("scene", c->name);
  record_count("triangles", c->mesh.triangle_count);
  record_text("kind", kind);
  record_count("threads", c->threads);
  record_text("isa", c->isa);
  record_number("whittle", o->ours);
  record_number("embree", o->embree);
  record_number("ratio", o->ratio);
  record_text("embree_mode", mode);
  record_text("embree_quality", c->settings->quality);
  record_text("embree_version", c->embree.version);
  record_text("embree_isa", c->embree_isa ? c->embree_isa : "its choice");
  record_number("spread", o->spread);
  record_number("whittle_spread", o->ours_spread);
  record_number("embree_spread", o->embree_spread);
  record_count("rounds", c->settings->rounds);
}

static void record_hits(size_t rays, size_t ours, size_t embree, size_t mismatches) {
  record_count("rays", rays);
  record_count("hits_whittle", ours);
  record_count("hits_embree", embree);
  record_count("mismatches", mismatches);
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
  embree_build(&c->embree, &c->mesh, c->settings->quality);
  long long bytes = c->embree.bytes - before;
  embree_release(&c->embree);
  embree_close(&c->embree);
  outcome o = judge(seconds, seconds + rounds, rounds, c->mesh.triangle_count);
  begin_record(c, "build", &o, "commit");
  record_hits(0, 0, 0, 0);
  record_count("whittle_bytes", c->ours.stats.bytes);
  record_count("embree_bytes", (unsigned long long)bytes);
  record_count("nodes", c->ours.stats.nodes);
  record_count("depth", c->ours.stats.depth);
  record_number("sah_cost", c->ours.stats.sah_cost);
  record_end();
  free(seconds);
}

/* The mode of Embree with the least median, and a table of all. */
static size_t best_mode(const contest *c, const double *seconds) {
  size_t rounds = c->settings->rounds, best = 0;
  for (size_t i = 1; i < c->embree.mode_count; i++)
    if (measure_quantile(seconds + i * rounds, rounds, 0.5) <
        measure_quantile(seconds + best * rounds, rounds, 0.5))
      best = i;
  return best;
}

static void record_trace(contest *c, const double *ours, const double *embree, double gigahertz) {
  size_t rounds = c->settings->rounds, best = best_mode(c, embree), count = c->stream.count;
  outcome o = judge(ours, embree + best * rounds, rounds, count);
  run_embree_trace(&(embree_run){c, &c->embree.modes[best]});
  begin_record(c, c->stream.kind, &o, c->embree.modes[best].name);
  record_hits(count, compare_count_hits(&c->stream, &c->found_ours),
              compare_count_hits(&c->stream, &c->found_embree),
              compare_mismatches(&c->stream, &c->found_ours, &c->found_embree));
  record_open("embree_modes");
  for (size_t i = 0; i < c->embree.mode_count; i++)
    record_number(c->embree.modes[i].name,
                  (double)count * 1e-6 / measure_quantile(embree + i * rounds, rounds, 0.5));
  record_close();
  record_number("ratio_single",
                measure_quantile(embree, rounds, 0.5) / measure_quantile(ours, rounds, 0.5));
  if (c->threads == 1) {
    record_number("gigahertz", gigahertz);
    record_number("whittle_cycles", gigahertz * 1000 / o.ours);
    record_number("embree_cycles", gigahertz * 1000 / o.embree);
  }
  record_end();
}

/* Times Whittle and all of Embree's modes on the stream at hand. */
static void measure_trace(contest *c) {
  size_t rounds = c->settings->rounds, modes = c->embree.mode_count;
  double *seconds = allocate(rounds * (modes + 1), sizeof(double));
  contender all[EMBREE_MODES + 1] = {{run_our_trace, c, seconds}};
  embree_run runs[EMBREE_MODES];
  for (size_t i = 0; i < modes; i++) {
    runs[i] = (embree_run){c, &c->embree.modes[i]};
    all[i + 1] = (contender){run_embree_trace, &runs[i], seconds + (i + 1) * rounds};
  }
  double before = clock_gigahertz();
  measure_rounds(all, modes + 1, rounds);
  double gigahertz = (before + clock_gigahertz()) / 2;
  record_trace(c, seconds, seconds + rounds, gigahertz);
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
    measure_trace(c);
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

/* The hits that shadow and mirror rays start from are those of Embree's single rays, so that the
 * rays do not depend on what is measured. */
static hits find_surfaces(contest *c, const stream *primary) {
  hits found = hits_new(primary);
  crew *crew = crew_new(c->settings->threads);
  embree_trace(&c->embree, &c->embree.modes[0], primary, &found, crew);
  crew_free(crew);
  return found;
}

static void measure_rays(contest *c) {
  const settings *s = c->settings;
  embree_open(&c->embree, s->threads, c->embree_isa);
  embree_build(&c->embree, &c->mesh, s->quality);
  ours_build(&c->ours, &c->mesh, s->threads);
  stream primary = rays_primary(&c->mesh, s->width, s->height);
  hits found = find_surfaces(c, &primary);
  stream shadow = rays_shadow(&c->mesh, &primary, &found);
  stream mirror = rays_mirror(&c->mesh, &primary, &found);
  hits_free(&found);
  measure_stream(c, primary);
  measure_stream(c, shadow);
  measure_stream(c, mirror);
  measure_stream(c, rays_random(&c->mesh, (size_t)s->width * s->height));
  ours_release(&c->ours);
  embree_release(&c->embree);
  embree_close(&c->embree);
}

void contest_run(const settings *s, const char *scene) {
  contest c = {.settings = s};
  int is_widest;
  c.isa = ours_isa(&is_widest);
  c.embree_isa = is_widest ? NULL : c.isa;
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
  measure_rays(&c);
  mesh_free(&c.mesh);
  free(label);
}
