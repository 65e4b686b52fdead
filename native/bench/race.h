/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Tracing one stream of rays with both sides, in turns. */

#ifndef BENCH_RACE_H
#define BENCH_RACE_H

#include "contest.h"

/* Times Whittle, every mode of Embree and its other builds on the contest's stream with its
 * threads, and prints the record. found_ours is what Whittle found. */
void race_run(contest *c);

/* A stream traced by Embree's single rays with all threads. */
void race_find(contest *c, const stream *s, const hits *found);

#endif
