/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* All measurements of one scene. */

#ifndef BENCH_CONTEST_H
#define BENCH_CONTEST_H

typedef struct settings {
  const char *library;      /* Embree's */
  const char *quality;      /* of Embree's build */
  const char *kinds;        /* of records wanted, with commas between; NULL: all */
  unsigned width, height;   /* of the image that primary rays make */
  unsigned rounds, threads; /* threads: of "all" */
} settings;

/* Loads the scene of that name; both sides build it with one thread and with all, then trace
 * primary, shadow, mirror and random rays likewise. Prints a record for each measurement. */
void contest_run(const settings *s, const char *scene);

#endif
