/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The workers of one run as a team: one leads through a program, all share its loops and tasks. */

#pragma once

#include "base/threads.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { WHITTLE_TEAM_ARGUMENT = 192, WHITTLE_TEAM_TASKS = 256 };

typedef void whittle_team_body(void *context, uint64_t begin, uint64_t end);
typedef void whittle_team_work(void *context, const void *argument);

typedef struct whittle_team_task {
  _Alignas(16) unsigned char argument[WHITTLE_TEAM_ARGUMENT];
  whittle_team_work *work;
  void *context;
} whittle_team_task;

typedef struct whittle_team_loop whittle_team_loop;

typedef struct whittle_team {
  pthread_mutex_t lock;
  pthread_cond_t changed;
  whittle_run_state *state;
  whittle_team_loop *loops;                    /* that may still have pieces to take */
  whittle_team_task tasks[WHITTLE_TEAM_TASKS]; /* a stack: the newest is still in a cache */
  uint32_t waiting_tasks, unfinished_tasks;
  bool closed;
  atomic_uint news; /* rises whenever something changes */
} whittle_team;

void whittle_team_init(whittle_team *team, whittle_run_state *state);
void whittle_team_destroy(whittle_team *team);

/* What every worker but the leader does: helps until the leader closes the team. */
void whittle_team_help(whittle_team *team);
void whittle_team_close(whittle_team *team);

/* Calls `body` for [0, count) in pieces of at most `grain`, on any workers in any order, and
 * returns when all are done. Once the run is cancelled the pieces that are left are skipped. */
void whittle_team_for(whittle_team *team, uint64_t count, uint64_t grain, whittle_team_body *body,
                      void *context);

/* Leaves a copy of `argument` (size bytes, at most WHITTLE_TEAM_ARGUMENT) to whoever comes first:
 * false if there is no room, and then the caller does the work itself. Tasks may share out more.
 * Only the leader waits for them, with whittle_team_finish. They run even if cancelled. */
bool whittle_team_share(whittle_team *team, whittle_team_work *work, void *context,
                        const void *argument, size_t size);
void whittle_team_finish(whittle_team *team);
