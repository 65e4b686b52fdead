/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Workers on POSIX threads, with the caller's thread reporting progress. */

#include "base/threads.h"
#include "base/float_mode.h"
#include "base/memory.h"

#include <pthread.h>
#include <time.h>

enum { REPORT_NANOSECONDS = 50 * 1000 * 1000, MOST_THREADS = 1024 };

typedef struct run {
  whittle_worker *worker;
  void *context;
  whittle_run_state *state;
  pthread_mutex_t lock;
  pthread_cond_t ended; /* the last worker has returned */
  uint32_t running;
} run;

typedef struct run_thread {
  run *run;
  pthread_t thread;
  uint32_t index;
} run_thread;

static void work(run *run, uint32_t index) {
  const unsigned mode = whittle_float_mode_enter();
  run->worker(run->context, index, run->state);
  whittle_float_mode_leave(mode);
}

static void *thread_main(void *argument) {
  run_thread *self = argument;
  work(self->run, self->index);
  pthread_mutex_lock(&self->run->lock);
  if (--self->run->running == 0)
    pthread_cond_signal(&self->run->ended);
  pthread_mutex_unlock(&self->run->lock);
  return NULL;
}

/* Starts workers `first` to `count - 1` and returns how many there are then. */
static uint32_t start_threads(run *run, run_thread *threads, uint32_t first, uint32_t count) {
  for (uint32_t i = first; i < count; i++) {
    threads[i].run = run;
    threads[i].index = i;
    pthread_mutex_lock(&run->lock);
    run->running++;
    pthread_mutex_unlock(&run->lock);
    if (pthread_create(&threads[i].thread, NULL, thread_main, &threads[i]) != 0) {
      pthread_mutex_lock(&run->lock);
      run->running--;
      pthread_mutex_unlock(&run->lock);
      return i;
    }
  }
  return count;
}

static void report(whittle_run_state *state, const whittle_progress *progress) {
  const uint64_t done = atomic_load_explicit(&state->done, memory_order_relaxed);
  double fraction = state->total ? (double)done / (double)state->total : 0.0;
  if (fraction > 1.0)
    fraction = 1.0;
  if (!progress->report(progress->user, fraction))
    atomic_store_explicit(&state->cancelled, 1, memory_order_relaxed);
}

static void wait_reporting(run *run, const whittle_progress *progress) {
  struct timespec next;
  clock_gettime(CLOCK_MONOTONIC, &next);
  pthread_mutex_lock(&run->lock);
  while (run->running) {
    next.tv_nsec += REPORT_NANOSECONDS;
    if (next.tv_nsec >= 1000000000) {
      next.tv_nsec -= 1000000000;
      next.tv_sec++;
    }
    int late = 0;
    while (run->running && late == 0)
      late = pthread_cond_timedwait(&run->ended, &run->lock, &next);
    if (!run->running)
      break;
    pthread_mutex_unlock(&run->lock);
    if (!whittle_cancelled(run->state))
      report(run->state, progress);
    clock_gettime(CLOCK_MONOTONIC, &next);
    pthread_mutex_lock(&run->lock);
  }
  pthread_mutex_unlock(&run->lock);
}

static void init(run *run) {
  pthread_condattr_t attributes;
  pthread_condattr_init(&attributes);
  pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
  pthread_mutex_init(&run->lock, NULL);
  pthread_cond_init(&run->ended, &attributes);
  pthread_condattr_destroy(&attributes);
}

whittle_status whittle_run(uint32_t threads, whittle_worker *worker, void *context,
                           whittle_run_state *state, const whittle_progress *progress,
                           whittle_error *error) {
  const int reporting = progress && progress->report;
  if (threads > MOST_THREADS)
    threads = MOST_THREADS;
  if (threads == 0)
    threads = 1;
  run run = {.worker = worker, .context = context, .state = state};
  run_thread *list = whittle_allocate(threads, sizeof *list);
  if (!list)
    return whittle_out_of_memory(error, "threads");
  init(&run);
  if (reporting)
    report(state, progress);
  /* Without reports this thread is worker 0, and the started ones are the others. */
  const uint32_t first = reporting ? 0 : 1;
  const uint32_t last = start_threads(&run, list, first, threads);
  const int none = last == 0;
  if (!none && !reporting)
    work(&run, 0);
  if (!none && reporting)
    wait_reporting(&run, progress);
  for (uint32_t i = first; i < last; i++)
    pthread_join(list[i].thread, NULL);
  pthread_cond_destroy(&run.ended);
  pthread_mutex_destroy(&run.lock);
  whittle_release(list);
  if (none)
    return whittle_out_of_memory(error, "a thread");
  if (whittle_cancelled(state))
    return whittle_fail(error, WHITTLE_CANCELLED, "", "Cancelled.");
  return WHITTLE_OK;
}
