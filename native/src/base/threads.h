/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Workers, progress and cancelling: one way to run anything in parallel. */

#pragma once

#include "base/error.h"

#include <stdatomic.h>
#include <stdint.h>

/* What the workers of one run share. `done` counts finished units out of `total`; `cancelled`
 * becomes 1 when the caller's progress callback says stop, or anyone sets it. */
typedef struct whittle_run_state {
  atomic_int cancelled;
  atomic_uint_fast64_t done;
  atomic_uint_fast64_t total; /* 0 until the work is known */
} whittle_run_state;

typedef void whittle_worker(void *context, uint32_t worker, whittle_run_state *state);

/* Runs `worker` on `threads` threads (worker = 0 .. threads - 1), each in the float mode of
 * float_mode.h, and returns when all have returned. If `progress` has a callback it is called on
 * this thread at most 20 times a second; then this thread does not work itself. Without one, this
 * thread is worker 0. WHITTLE_CANCELLED if state->cancelled was set; WHITTLE_OUT_OF_MEMORY if not
 * even one thread could be had (fewer than asked for is fine: workers must share work by queue). */
whittle_status whittle_run(uint32_t threads, whittle_worker *worker, void *context,
                           whittle_run_state *state, const whittle_progress *progress,
                           whittle_error *error);

static inline int whittle_cancelled(whittle_run_state *state) {
  return atomic_load_explicit(&state->cancelled, memory_order_relaxed);
}

static inline void whittle_advance(whittle_run_state *state, uint64_t units) {
  atomic_fetch_add_explicit(&state->done, units, memory_order_relaxed);
}
