/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Rates, ratios and spread of a measurement. */

#include "outcome.h"

#include "fail.h"
#include "measure.h"
#include "records.h"

#include <stdlib.h>

outcome outcome_judge(const double *ours, const double *embree, size_t rounds, size_t work) {
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

void outcome_begin_record(const contest *c, const char *kind, const outcome *o, const char *mode) {
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

void outcome_record_hits(size_t rays, size_t ours, size_t embree, size_t mismatches) {
  record_count("rays", rays);
  record_count("hits_whittle", ours);
  record_count("hits_embree", embree);
  record_count("mismatches", mismatches);
}
