/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Threads that take chunks of a range from a queue. */

#ifndef BENCH_CREW_H
#define BENCH_CREW_H

#include <stddef.h>

typedef struct crew crew;

/* The calling thread is one of the `threads`. */
crew *crew_new(unsigned threads);
void crew_free(crew *c);

/* Calls work(user, first, count) for all of [0, total) in chunks and waits for the last. */
void crew_run(crew *c, size_t total, size_t chunk, void (*work)(void *, size_t, size_t),
              void *user);

#endif
