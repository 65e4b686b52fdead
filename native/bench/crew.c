/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* A crew of waiting threads; see crew.h. */

#include "crew.h"

#include "fail.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

struct crew {
  unsigned helpers;
  pthread_t *threads;
  pthread_mutex_t lock;
  pthread_cond_t start, finish;
  unsigned long turn; /* counts runs; helpers wait for it to change */
  unsigned busy;      /* helpers that have not finished this turn */
  int closing;
  size_t total, chunk;
  void (*work)(void *, size_t, size_t);
  void *user;
  atomic_size_t next;
};

static void take_chunks(crew *c) {
  for (;;) {
    size_t first = atomic_fetch_add(&c->next, c->chunk);
    if (first >= c->total)
      return;
    size_t left = c->total - first;
    c->work(c->user, first, left < c->chunk ? left : c->chunk);
  }
}

static void *helper(void *user) {
  crew *c = user;
  unsigned long seen = 0;
  pthread_mutex_lock(&c->lock);
  for (;;) {
    while (c->turn == seen && !c->closing)
      pthread_cond_wait(&c->start, &c->lock);
    if (c->closing)
      break;
    seen = c->turn;
    pthread_mutex_unlock(&c->lock);
    take_chunks(c);
    pthread_mutex_lock(&c->lock);
    if (--c->busy == 0)
      pthread_cond_signal(&c->finish);
  }
  pthread_mutex_unlock(&c->lock);
  return NULL;
}

crew *crew_new(unsigned threads) {
  crew *c = allocate(1, sizeof(*c));
  c->helpers = threads - 1;
  c->threads = allocate(c->helpers, sizeof(*c->threads));
  pthread_mutex_init(&c->lock, NULL);
  pthread_cond_init(&c->start, NULL);
  pthread_cond_init(&c->finish, NULL);
  for (unsigned i = 0; i < c->helpers; i++)
    if (pthread_create(&c->threads[i], NULL, helper, c) != 0)
      fail("the system refuses thread %u of %u", i + 2, threads);
  return c;
}

void crew_free(crew *c) {
  pthread_mutex_lock(&c->lock);
  c->closing = 1;
  pthread_cond_broadcast(&c->start);
  pthread_mutex_unlock(&c->lock);
  for (unsigned i = 0; i < c->helpers; i++)
    pthread_join(c->threads[i], NULL);
  pthread_mutex_destroy(&c->lock);
  pthread_cond_destroy(&c->start);
  pthread_cond_destroy(&c->finish);
  free(c->threads);
  free(c);
}

void crew_run(crew *c, size_t total, size_t chunk, void (*work)(void *, size_t, size_t),
              void *user) {
  pthread_mutex_lock(&c->lock);
  c->total = total;
  c->chunk = chunk;
  c->work = work;
  c->user = user;
  atomic_store(&c->next, 0);
  c->busy = c->helpers;
  c->turn++;
  pthread_cond_broadcast(&c->start);
  pthread_mutex_unlock(&c->lock);
  take_chunks(c);
  pthread_mutex_lock(&c->lock);
  while (c->busy > 0)
    pthread_cond_wait(&c->finish, &c->lock);
  pthread_mutex_unlock(&c->lock);
}
