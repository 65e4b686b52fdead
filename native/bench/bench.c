/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The benchmark: Whittle and Embree build the same meshes and trace the same rays. */

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

typedef struct settings {
  const char *library;      /* Embree's */
  const char *quality;      /* of Embree's build */
  unsigned width, height;   /* of the image that primary rays make */
  unsigned rounds, threads; /* threads: of "all" */
} settings;

/* What one scene's measurements share. */
typedef struct bench {
  const settings *settings;
  const char *name, *isa, *embree_isa; /* embree_isa NULL: its own choice */
  mesh mesh;
  ours ours;
  embree embree;
  unsigned threads; /* of the measurement at hand */
  crew *crew;
  stream stream; /* and its rays */
  hits found_ours, found_embree;
  const embree_mode *mode;
} bench;

static double run_our_build(void *user) {
  bench *b = user;
  double seconds = ours_build(&b->ours, &b->mesh, b->threads);
  ours_release(&b->ours);
  return seconds;
}

static double run_embree_build(void *user) {
  bench *b = user;
  double seconds = embree_build(&b->embree, &b->mesh, b->settings->quality);
  embree_release(&b->embree);
  return seconds;
}

static double run_our_trace(void *user) {
  bench *b = user;
  double start = clock_seconds();
  ours_trace(&b->ours, &b->stream, &b->found_ours, b->threads);
  return clock_seconds() - start;
}

typedef struct embree_run {
  bench *bench;
  const embree_mode *mode;
} embree_run;

static double run_embree_trace(void *user) {
  embree_run *r = user;
  double start = clock_seconds();
  embree_trace(&r->bench->embree, r->mode, &r->bench->stream, &r->bench->found_embree,
               r->bench->crew);
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
static void begin_record(const bench *b, const char *kind, const outcome *o, const char *mode) {
  record_begin();
  record_text("scene", b->name);
  record_count("triangles", b->mesh.triangle_count);
  record_text("kind", kind);
  record_count("threads", b->threads);
  record_text("isa", b->isa);
  record_number("whittle", o->ours);
  record_number("embree", o->embree);
  record_number("ratio", o->ratio);
  record_text("embree_mode", mode);
  record_text("embree_quality", b->settings->quality);
  record_text("embree_version", b->embree.version);
  record_text("embree_isa", b->embree_isa ? b->embree_isa : "its choice");
  record_number("spread", o->spread);
  record_number("whittle_spread", o->ours_spread);
  record_number("embree_spread", o->embree_spread);
  record_count("rounds", b->settings->rounds);
}

static void record_hits(size_t rays, size_t ours, size_t embree, size_t mismatches) {
  record_count("rays", rays);
  record_count("hits_whittle", ours);
  record_count("hits_embree", embree);
  record_count("mismatches", mismatches);
}

static void measure_build(bench *b) {
  size_t rounds = b->settings->rounds;
  double *seconds = allocate(rounds * 2, sizeof(double));
  embree_open(&b->embree, b->threads, b->embree_isa);
  contender both[2] = {{run_our_build, b, seconds}, {run_embree_build, b, seconds + rounds}};
  measure_rounds(both, 2, rounds);
  long long before = b->embree.bytes;
  embree_build(&b->embree, &b->mesh, b->settings->quality);
  long long bytes = b->embree.bytes - before;
  embree_release(&b->embree);
  embree_close(&b->embree);
  outcome o = judge(seconds, seconds + rounds, rounds, b->mesh.triangle_count);
  begin_record(b, "build", &o, "commit");
  record_hits(0, 0, 0, 0);
  record_count("whittle_bytes", b->ours.stats.bytes);
  record_count("embree_bytes", (unsigned long long)bytes);
  record_count("nodes", b->ours.stats.nodes);
  record_count("depth", b->ours.stats.depth);
  record_number("sah_cost", b->ours.stats.sah_cost);
  record_end();
  free(seconds);
}

/* The mode of Embree with the least median, and a table of all. */
static size_t best_mode(const bench *b, const double *seconds) {
  size_t rounds = b->settings->rounds, best = 0;
  for (size_t i = 1; i < b->embree.mode_count; i++)
    if (measure_quantile(seconds + i * rounds, rounds, 0.5) <
        measure_quantile(seconds + best * rounds, rounds, 0.5))
      best = i;
  return best;
}

static void record_trace(bench *b, const double *ours, const double *embree, double gigahertz) {
  size_t rounds = b->settings->rounds, best = best_mode(b, embree), count = b->stream.count;
  outcome o = judge(ours, embree + best * rounds, rounds, count);
  run_embree_trace(&(embree_run){b, &b->embree.modes[best]});
  begin_record(b, b->stream.kind, &o, b->embree.modes[best].name);
  record_hits(count, compare_count_hits(&b->stream, &b->found_ours),
              compare_count_hits(&b->stream, &b->found_embree),
              compare_mismatches(&b->stream, &b->found_ours, &b->found_embree));
  record_open("embree_modes");
  for (size_t i = 0; i < b->embree.mode_count; i++)
    record_number(b->embree.modes[i].name,
                  (double)count * 1e-6 / measure_quantile(embree + i * rounds, rounds, 0.5));
  record_close();
  record_number("ratio_single",
                measure_quantile(embree, rounds, 0.5) / measure_quantile(ours, rounds, 0.5));
  if (b->threads == 1) {
    record_number("gigahertz", gigahertz);
    record_number("whittle_cycles", gigahertz * 1000 / o.ours);
    record_number("embree_cycles", gigahertz * 1000 / o.embree);
  }
  record_end();
}

/* Times Whittle and all of Embree's modes on the stream at hand. */
static void measure_trace(bench *b) {
  size_t rounds = b->settings->rounds, modes = b->embree.mode_count;
  double *seconds = allocate(rounds * (modes + 1), sizeof(double));
  contender all[EMBREE_MODES + 1] = {{run_our_trace, b, seconds}};
  embree_run runs[EMBREE_MODES];
  for (size_t i = 0; i < modes; i++) {
    runs[i] = (embree_run){b, &b->embree.modes[i]};
    all[i + 1] = (contender){run_embree_trace, &runs[i], seconds + (i + 1) * rounds};
  }
  double before = clock_gigahertz();
  measure_rounds(all, modes + 1, rounds);
  double gigahertz = (before + clock_gigahertz()) / 2;
  record_trace(b, seconds, seconds + rounds, gigahertz);
  free(seconds);
}

/* One stream with one thread and with all; Whittle must find the same bits with both. */
static void measure_stream(bench *b, stream s) {
  b->stream = s;
  if (s.count == 0) {
    fprintf(stderr, "bench: %s: no %s rays, nothing is in view\n", b->name, s.kind);
    stream_free(&b->stream);
    return;
  }
  b->found_ours = hits_new(&s);
  b->found_embree = hits_new(&s);
  hits alone = hits_new(&s);
  unsigned counts[2] = {1, b->settings->threads};
  for (int i = 0; i < (counts[1] > 1 ? 2 : 1); i++) {
    b->threads = counts[i];
    b->crew = crew_new(b->threads);
    measure_trace(b);
    crew_free(b->crew);
    if (i == 0)
      ours_trace(&b->ours, &s, &alone, 1);
    if (!compare_identical(&s, &alone, &b->found_ours))
      fail("%s: Whittle finds other %s hits with %u threads than with 1", b->name, s.kind,
           b->threads);
  }
  hits_free(&alone);
  hits_free(&b->found_ours);
  hits_free(&b->found_embree);
  stream_free(&b->stream);
}

/* The hits that shadow and mirror rays start from are those of Embree's single rays, so that the
 * rays do not depend on what is measured. */
static hits find_surfaces(bench *b, const stream *primary) {
  hits found = hits_new(primary);
  crew *crew = crew_new(b->settings->threads);
  embree_trace(&b->embree, &b->embree.modes[0], primary, &found, crew);
  crew_free(crew);
  return found;
}

static void measure_rays(bench *b) {
  const settings *s = b->settings;
  embree_open(&b->embree, s->threads, b->embree_isa);
  embree_build(&b->embree, &b->mesh, s->quality);
  ours_build(&b->ours, &b->mesh, s->threads);
  stream primary = rays_primary(&b->mesh, s->width, s->height);
  hits found = find_surfaces(b, &primary);
  stream shadow = rays_shadow(&b->mesh, &primary, &found);
  stream mirror = rays_mirror(&b->mesh, &primary, &found);
  hits_free(&found);
  measure_stream(b, primary);
  measure_stream(b, shadow);
  measure_stream(b, mirror);
  measure_stream(b, rays_random(&b->mesh, (size_t)s->width * s->height));
  ours_release(&b->ours);
  embree_release(&b->embree);
  embree_close(&b->embree);
}

static void measure_scene(const settings *s, const char *name) {
  bench b = {.settings = s};
  int is_widest;
  b.isa = ours_isa(&is_widest);
  b.embree_isa = is_widest ? NULL : b.isa;
  b.mesh = scenes_load(name, (float)s->width / (float)s->height);
  char *label = scenes_label(name);
  b.name = label;
  embree_load(&b.embree, s->library);
  b.threads = 1;
  measure_build(&b);
  if (s->threads > 1) {
    b.threads = s->threads;
    measure_build(&b);
  }
  measure_rays(&b);
  mesh_free(&b.mesh);
  free(label);
}

static unsigned parse_count(const char *option, const char *text, unsigned most) {
  char *end;
  unsigned long value = strtoul(text, &end, 10);
  if (*text == '\0' || *end != '\0' || value < 1 || value > most)
    fail("%s must be a number from 1 to %u, not %s", option, most, text);
  return (unsigned)value;
}

static void parse_size(settings *s, const char *text) {
  char rest;
  if (sscanf(text, "%ux%u%c", &s->width, &s->height, &rest) != 2 || s->width < 1 || s->height < 1 ||
      s->width > 16384 || s->height > 16384)
    fail("--size must be WIDTHxHEIGHT, each from 1 to 16384, not %s", text);
}

static void parse_option(settings *s, const char *option, const char *value) {
  if (!value)
    fail("%s needs a value", option);
  if (strcmp(option, "--embree") == 0)
    s->library = value;
  else if (strcmp(option, "--quality") == 0)
    s->quality = value;
  else if (strcmp(option, "--size") == 0)
    parse_size(s, value);
  else if (strcmp(option, "--rounds") == 0)
    s->rounds = parse_count(option, value, 1000);
  else if (strcmp(option, "--threads") == 0)
    s->threads = parse_count(option, value, 1024);
  else
    fail("there is no option %s", option);
}

int main(int argc, char **argv) {
  settings s = {.quality = "medium",
                .width = 1280,
                .height = 800,
                .rounds = 7,
                .threads = whittle_default_threads()};
  int i = 1;
  for (; i < argc && strncmp(argv[i], "--", 2) == 0; i += 2)
    parse_option(&s, argv[i], argv[i + 1]);
  if (i >= argc || !s.library)
    fail("usage: %s --embree LIBRARY [--quality Q] [--size WxH] [--rounds N] [--threads N] "
         "SCENE...\nwhere SCENE is one of %s",
         argv[0], scenes_help);
  for (; i < argc; i++)
    measure_scene(&s, argv[i]);
  return 0;
}
