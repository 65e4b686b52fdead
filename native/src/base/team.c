/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Loops and tasks shared by the workers of a run, under one lock that is rarely taken. */

#include "base/team.h"

#include <immintrin.h>
#include <stdatomic.h>
#include <string.h>

/* How often news are looked for before a worker goes to sleep: some 50 microseconds, which is what
 * waking it takes. */
enum { LOOKS = 2000 };

struct whittle_team_loop {
  whittle_team_body *body;
  void *context;
  uint64_t count, grain;
  atomic_uint_fast64_t next;
  uint32_t helpers;
  whittle_team_loop *below;
};

void whittle_team_init(whittle_team *team, whittle_run_state *state) {
  pthread_mutex_init(&team->lock, NULL);
  pthread_cond_init(&team->changed, NULL);
  team->state = state;
  team->loops = NULL;
  team->waiting_tasks = team->unfinished_tasks = 0;
  team->closed = false;
  atomic_init(&team->news, 0);
}

void whittle_team_destroy(whittle_team *team) {
  pthread_cond_destroy(&team->changed);
  pthread_mutex_destroy(&team->lock);
}

static void run_pieces(whittle_team *team, whittle_team_loop *loop) {
  while (!whittle_cancelled(team->state)) {
    const uint64_t begin =
        atomic_fetch_add_explicit(&loop->next, loop->grain, memory_order_relaxed);
    if (begin >= loop->count)
      return;
    const uint64_t left = loop->count - begin;
    loop->body(loop->context, begin, begin + (left < loop->grain ? left : loop->grain));
  }
}

/* Called with the lock held. */
static void tell(whittle_team *team) {
  atomic_fetch_add_explicit(&team->news, 1, memory_order_relaxed);
  pthread_cond_broadcast(&team->changed);
}

/* Until someone tells something. Called and left with the lock held. */
static void wait_for_news(whittle_team *team) {
  const uint32_t known = atomic_load_explicit(&team->news, memory_order_relaxed);
  pthread_mutex_unlock(&team->lock);
  for (uint32_t look = 0; look < LOOKS; look++) {
    if (atomic_load_explicit(&team->news, memory_order_relaxed) != known)
      break;
    _mm_pause();
  }
  pthread_mutex_lock(&team->lock);
  if (atomic_load_explicit(&team->news, memory_order_relaxed) == known)
    pthread_cond_wait(&team->changed, &team->lock);
}

/* Takes part in a loop or runs a task; false if there is neither. Called and left with the lock
 * held. */
static bool help_once(whittle_team *team) {
  for (whittle_team_loop *loop = team->loops; loop; loop = loop->below) {
    if (atomic_load_explicit(&loop->next, memory_order_relaxed) >= loop->count ||
        whittle_cancelled(team->state))
      continue;
    loop->helpers++;
    pthread_mutex_unlock(&team->lock);
    run_pieces(team, loop);
    pthread_mutex_lock(&team->lock);
    if (--loop->helpers == 0)
      tell(team);
    return true;
  }
  if (team->waiting_tasks == 0)
    return false;
  const whittle_team_task task = team->tasks[--team->waiting_tasks];
  pthread_mutex_unlock(&team->lock);
  task.work(task.context, task.argument);
  pthread_mutex_lock(&team->lock);
  if (--team->unfinished_tasks == 0)
    tell(team);
  return true;
}

void whittle_team_help(whittle_team *team) {
  pthread_mutex_lock(&team->lock);
  while (!team->closed)
    if (!help_once(team))
      wait_for_news(team);
  pthread_mutex_unlock(&team->lock);
}

void whittle_team_close(whittle_team *team) {
  pthread_mutex_lock(&team->lock);
  team->closed = true;
  tell(team);
  pthread_mutex_unlock(&team->lock);
}

void whittle_team_for(whittle_team *team, uint64_t count, uint64_t grain, whittle_team_body *body,
                      void *context) {
  whittle_team_loop loop = {.body = body, .context = context, .count = count, .grain = grain};
  atomic_init(&loop.next, 0);
  if (count <= grain) {
    run_pieces(team, &loop);
    return;
  }
  pthread_mutex_lock(&team->lock);
  loop.below = team->loops;
  team->loops = &loop;
  tell(team);
  pthread_mutex_unlock(&team->lock);
  run_pieces(team, &loop);
  pthread_mutex_lock(&team->lock);
  whittle_team_loop **link = &team->loops;
  while (*link != &loop)
    link = &(*link)->below;
  *link = loop.below;
  while (loop.helpers)
    wait_for_news(team);
  pthread_mutex_unlock(&team->lock);
}

bool whittle_team_share(whittle_team *team, whittle_team_work *work, void *context,
                        const void *argument, size_t size) {
  pthread_mutex_lock(&team->lock);
  const bool room = team->waiting_tasks < WHITTLE_TEAM_TASKS;
  if (room) {
    whittle_team_task *task = &team->tasks[team->waiting_tasks++];
    task->work = work;
    task->context = context;
    memcpy(task->argument, argument, size);
    team->unfinished_tasks++;
    tell(team);
  }
  pthread_mutex_unlock(&team->lock);
  return room;
}

void whittle_team_finish(whittle_team *team) {
  pthread_mutex_lock(&team->lock);
  while (team->unfinished_tasks)
    if (!help_once(team))
      wait_for_news(team);
  pthread_mutex_unlock(&team->lock);
}
