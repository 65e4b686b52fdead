/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Aligned memory with checked sizes. Large pieces are mapped, so that giving one back returns it to
 * the system, and ask for large pages. Some are kept for whoever asks next, since fresh pages can
 * cost a build more time than filling them; the system may take what is in them whenever it runs
 * short. */

#include "base/memory.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum {
  LINE = 64,
  PAGE = 4096,
  LARGE_PAGE = 1 << 21,
  LEAST_MAPPED = 1 << 17,
  LEAST_TAIL = LARGE_PAGE / 4 * 3, /* fills a large page of its own well enough */
  KEPT_PIECES = 16,
  KEPT_BYTES = 3 << 23, /* of all that are kept, and twice the most of one */
};

/* In the line before each piece. */
typedef struct header {
  void *start;
  size_t mapped; /* bytes from start on; 0: it came from malloc */
} header;

_Static_assert(sizeof(header) <= LINE, "the header fits a line");

/* Pieces that were given back. A slot is emptied before it is looked into, so that no two threads
 * look into the same. */
static struct {
  _Atomic(header *) piece[KEPT_PIECES];
  atomic_size_t bytes;
  atomic_uint turn; /* whose slot is cleared next */
} kept;

static void *behind_header(void *start, size_t mapped) {
  header *h = start;
  *h = (header){start, mapped};
  return (char *)start + LINE;
}

static header *header_of(void *memory) {
  return (header *)((char *)memory - LINE);
}

static size_t round_up(size_t bytes, size_t to) {
  return (bytes + to - 1) & ~(to - 1);
}

static header *take_slot(uint32_t i) {
  header *h = atomic_exchange_explicit(&kept.piece[i], NULL, memory_order_acquire);
  if (h)
    atomic_fetch_sub_explicit(&kept.bytes, h->mapped, memory_order_relaxed);
  return h;
}

static void drop_slot(uint32_t i) {
  header *h = take_slot(i);
  if (h)
    munmap(h->start, h->mapped);
}

/* Puts a piece into a slot, in the place of what stood there. */
static void put_slot(uint32_t i, header *h) {
  drop_slot(i);
  atomic_fetch_add_explicit(&kept.bytes, h->mapped, memory_order_relaxed);
  h = atomic_exchange_explicit(&kept.piece[i], h, memory_order_acq_rel);
  if (h) { /* another thread was quicker */
    atomic_fetch_sub_explicit(&kept.bytes, h->mapped, memory_order_relaxed);
    munmap(h->start, h->mapped);
  }
}

static bool has_room(const header *h) {
  return atomic_load_explicit(&kept.bytes, memory_order_relaxed) + h->mapped <= KEPT_BYTES;
}

/* A free slot; or one that is made free, in turns. */
static uint32_t find_slot(const header *h) {
  for (uint32_t i = 0; i < KEPT_PIECES; i++)
    if (!atomic_load_explicit(&kept.piece[i], memory_order_relaxed) && has_room(h))
      return i;
  uint32_t i = 0;
  for (uint32_t tries = 0; tries == 0 || (tries < KEPT_PIECES && !has_room(h)); tries++) {
    i = atomic_fetch_add_explicit(&kept.turn, 1, memory_order_relaxed) % KEPT_PIECES;
    drop_slot(i);
  }
  return i;
}

/* The first large page stays as it is: the header is in it. */
static void keep(header *h) {
  if (h->mapped > LARGE_PAGE)
    madvise((char *)h->start + LARGE_PAGE, h->mapped - LARGE_PAGE, MADV_FREE);
  put_slot(find_slot(h), h);
}

/* A kept piece of that size, and at most a quarter more; or NULL. */
static void *take(size_t size) {
  for (uint32_t i = 0; i < KEPT_PIECES; i++) {
    if (!atomic_load_explicit(&kept.piece[i], memory_order_relaxed))
      continue;
    header *h = take_slot(i);
    if (h && h->mapped >= size && h->mapped - size <= size / 4)
      return behind_header(h->start, h->mapped);
    if (h)
      put_slot(i, h);
  }
  return NULL;
}

/* Maps from a large page's start on and gives back what alignment left over. A tail that would not
 * fill a large page makes do with small ones. */
static void *map(size_t bytes) {
  const bool fills = (bytes & (LARGE_PAGE - 1)) >= LEAST_TAIL;
  const size_t size = round_up(bytes, fills ? LARGE_PAGE : PAGE);
  const size_t large = size & ~(size_t)(LARGE_PAGE - 1);
  char *wide =
      mmap(NULL, size + LARGE_PAGE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (wide == MAP_FAILED)
    return NULL;
  char *start = (char *)round_up((uintptr_t)wide, LARGE_PAGE);
  if (start > wide)
    munmap(wide, (size_t)(start - wide));
  if (start < wide + LARGE_PAGE)
    munmap(start + size, (size_t)(wide + LARGE_PAGE - start));
  if (large)
    madvise(start, large, MADV_HUGEPAGE); /* only a wish: fewer page faults */
  return behind_header(start, size);
}

void *whittle_allocate(size_t count, size_t size) {
  size_t bytes;
  void *start = NULL;
  if (__builtin_mul_overflow(count, size, &bytes) || bytes > PTRDIFF_MAX - 2 * LARGE_PAGE - LINE)
    return NULL;
  if (bytes >= LEAST_MAPPED) {
    void *again = take(bytes + LINE);
    return again ? again : map(bytes + LINE);
  }
  return posix_memalign(&start, LINE, bytes + LINE) == 0 ? behind_header(start, 0) : NULL;
}

void whittle_release(void *memory) {
  if (!memory)
    return;
  header *h = header_of(memory);
  if (h->mapped == 0)
    free(h->start);
  else if (h->mapped <= KEPT_BYTES / 2)
    keep(h);
  else
    munmap(h->start, h->mapped);
}
