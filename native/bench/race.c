/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Timing both sides on a stream, and the record of it. */

#include "race.h"

#include "clock.h"
#include "compare.h"
#include "fail.h"
#include "measure.h"
#include "outcome.h"
#include "records.h"

#include <stdlib.h>
#include <string.h>

enum { CONTENDERS = 1 + EMBREE_MODES + EMBREE_BUILDS };

static double run_ours(void *user) {
  contest *c = user;
  double start = clock_seconds();
  ours_trace(&c->ours, &c->stream, &c->found_ours, c->threads);
  return clock_seconds() - start;
}

/* One way of Embree's. */
typedef struct entry {
  contest *contest;
  const embree_mode *mode;
  unsigned build; /* a place in embree.scenes; 0 is the one compared with */
} entry;

static double run_embree(void *user) {
  entry *e = user;
  embree_choose(&e->contest->embree, e->build);
  double start = clock_seconds();
  embree_trace(&e->contest->embree, e->mode, &e->contest->stream, &e->contest->found_embree,
               e->contest->crew);
  return clock_seconds() - start;
}

void race_find(contest *c, const stream *s, const hits *found) {
  crew *crew = crew_new(c->settings->threads);
  embree_choose(&c->embree, 0);
  embree_trace(&c->embree, &c->embree.modes[0], s, found, crew);
  crew_free(crew);
}

/* The mode of Embree with the least median. */
static size_t best_mode(const contest *c, const double *seconds, size_t rounds) {
  size_t best = 0;
  for (size_t i = 1; i < c->embree.mode_count; i++)
    if (measure_quantile(seconds + i * rounds, rounds, 0.5) <
        measure_quantile(seconds + best * rounds, rounds, 0.5))
      best = i;
  return best;
}

/* The mode that the other builds are traced with: the best of a trial. */
static const embree_mode *trial(contest *c) {
  enum { ROUNDS = 1 };
  double seconds[EMBREE_MODES * ROUNDS];
  entry entries[EMBREE_MODES];
  contender all[EMBREE_MODES];
  for (unsigned i = 0; i < c->embree.mode_count; i++) {
    entries[i] = (entry){c, &c->embree.modes[i], 0};
    all[i] = (contender){run_embree, &entries[i], seconds + (size_t)i * ROUNDS};
  }
  measure_rounds(all, c->embree.mode_count, ROUNDS);
  return &c->embree.modes[best_mode(c, seconds, ROUNDS)];
}

static double rate(const contest *c, const double *seconds) {
  return (double)c->stream.count * 1e-6 / measure_quantile(seconds, c->settings->rounds, 0.5);
}

static void record_ways(const contest *c, const entry *entries, size_t count,
                        const double *embree) {
  size_t rounds = c->settings->rounds, modes = c->embree.mode_count;
  record_open("embree_modes");
  for (size_t i = 0; i < modes; i++)
    record_number(entries[i].mode->name, rate(c, embree + i * rounds));
  record_close();
  if (count == modes)
    return;
  record_text("embree_builds_mode", entries[modes].mode->name);
  record_open("embree_builds");
  for (size_t i = modes; i < count; i++)
    record_number(c->builds[entries[i].build], rate(c, embree + i * rounds));
  record_close();
}

static void record_counts(contest *c) {
  double nodes, triangles;
  ours_count(&c->mesh, &c->stream, c->settings->threads, &nodes, &triangles);
  record_number("nodes_per_ray", nodes);
  record_number("triangles_per_ray", triangles);
}

static void record_race(contest *c, entry *entries, size_t entry_count, const double *ours,
                        double gigahertz) {
  size_t rounds = c->settings->rounds, count = c->stream.count;
  const double *embree = ours + rounds;
  size_t best = best_mode(c, embree, rounds);
  outcome o = outcome_judge(ours, embree + best * rounds, rounds, count);
  run_embree(&entries[best]);
  outcome_begin_record(c, c->stream.kind, &o, entries[best].mode->name);
  outcome_record_hits(count, compare_count_hits(&c->stream, &c->found_ours),
                      compare_count_hits(&c->stream, &c->found_embree),
                      compare_mismatches(&c->stream, &c->found_ours, &c->found_embree));
  record_ways(c, entries, entry_count, embree);
  record_number("ratio_single", o.ours / rate(c, embree));
  if (c->threads == 1) {
    record_number("gigahertz", gigahertz);
    record_number("whittle_cycles", gigahertz * 1000 / o.ours);
    record_number("embree_cycles", gigahertz * 1000 / o.embree);
    if (strcmp(c->stream.kind, "primary") == 0)
      record_counts(c);
  }
  record_end();
}

void race_run(contest *c) {
  size_t rounds = c->settings->rounds, modes = c->embree.mode_count;
  double *seconds = allocate(rounds * CONTENDERS, sizeof(double));
  contender all[CONTENDERS] = {{run_ours, c, seconds}};
  entry entries[CONTENDERS];
  /* One thread is enough to tell what the other builds are worth. */
  size_t others = c->threads == 1 ? c->build_count - 1 : 0, count = modes + others;
  const embree_mode *mode = others ? trial(c) : NULL;
  for (size_t i = 0; i < count; i++) {
    entries[i] = i < modes ? (entry){c, &c->embree.modes[i], 0}
                           : (entry){c, mode, (unsigned)(i - modes + 1)};
    all[i + 1] = (contender){run_embree, &entries[i], seconds + (i + 1) * rounds};
  }
  double before = clock_gigahertz();
  measure_rounds(all, count + 1, rounds);
  double gigahertz = (before + clock_gigahertz()) / 2;
  record_race(c, entries, count, seconds, gigahertz);
  free(seconds);
}
