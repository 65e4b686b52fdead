/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* All measurements of one scene. */

#ifndef BENCH_CONTEST_H
#define BENCH_CONTEST_H

#include "crew.h"
#include "embree.h"
#include "ours.h"
#include "rays.h"

typedef struct settings {
  const char *library;      /* Embree's */
  const char *quality;      /* of the build of Embree's that is compared with */
  int one_build;            /* leave its other builds out */
  const char *isa;          /* that both are restricted to; NULL: the best of each */
  const char *kinds;        /* of records wanted, with commas between; NULL: all */
  unsigned width, height;   /* of the image that primary rays make */
  unsigned rounds, threads; /* threads: of "all" */
} settings;

/* What one scene's measurements share. */
typedef struct contest {
  const settings *settings;
  const char *name, *isa, *embree_isa; /* embree_isa NULL: its own choice */
  mesh mesh;
  ours ours;
  embree embree;
  const char *builds[EMBREE_BUILDS]; /* qualities of Embree's scenes, that of the settings first */
  unsigned build_count;
  unsigned threads; /* of the measurement at hand */
  crew *crew;
  stream stream; /* and its rays */
  hits found_ours, found_embree;
} contest;

/* Loads the scene of that name; both sides build it with one thread and with all, then trace
 * primary, shadow, mirror and random rays likewise. Prints a record for each measurement. */
void contest_run(const settings *s, const char *scene);

#endif
