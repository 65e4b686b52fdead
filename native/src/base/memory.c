/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Aligned memory with checked sizes. Large pieces are mapped, so that giving one back returns it to
 * the system at once, and ask for large pages. */

#include "base/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { LINE = 64, LARGE_PAGE = 1 << 21 };

/* In the line before each piece. */
typedef struct header {
  void *start;
  size_t mapped; /* bytes from start on; 0: it came from malloc */
} header;

_Static_assert(sizeof(header) <= LINE, "the header fits a line");

static void *behind_header(void *start, size_t mapped) {
  header *h = start;
  *h = (header){start, mapped};
  return (char *)start + LINE;
}

/* Maps whole large pages and gives back what alignment left over. */
static void *map(size_t bytes) {
  const size_t size = (bytes + LARGE_PAGE - 1) & ~(size_t)(LARGE_PAGE - 1);
  char *wide =
      mmap(NULL, size + LARGE_PAGE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (wide == MAP_FAILED)
    return NULL;
  char *start = (char *)(((uintptr_t)wide + LARGE_PAGE - 1) & ~(uintptr_t)(LARGE_PAGE - 1));
  if (start > wide)
    munmap(wide, (size_t)(start - wide));
  if (start < wide + LARGE_PAGE)
    munmap(start + size, (size_t)(wide + LARGE_PAGE - start));
  madvise(start, size, MADV_HUGEPAGE); /* only a wish: fewer page faults */
  return behind_header(start, size);
}

void *whittle_allocate(size_t count, size_t size) {
  size_t bytes;
  void *start = NULL;
  if (__builtin_mul_overflow(count, size, &bytes) || bytes > PTRDIFF_MAX - 2 * LARGE_PAGE - LINE)
    return NULL;
  if (bytes >= 2 * LARGE_PAGE)
    return map(bytes + LINE);
  return posix_memalign(&start, LINE, bytes + LINE) == 0 ? behind_header(start, 0) : NULL;
}

static header *header_of(void *memory) {
  return (header *)((char *)memory - LINE);
}

/* Whole large pages stay. */
static void unmap_tail(header *h, size_t bytes) {
  const size_t kept = (bytes + LINE + LARGE_PAGE - 1) & ~(size_t)(LARGE_PAGE - 1);
  if (kept >= h->mapped)
    return;
  munmap((char *)h->start + kept, h->mapped - kept);
  h->mapped = kept;
}

void *whittle_shrink(void *memory, size_t bytes) {
  header *h = header_of(memory);
  if (h->mapped) {
    unmap_tail(h, bytes);
    return memory;
  }
  void *smaller = whittle_allocate(bytes, 1);
  if (!smaller)
    return memory;
  memcpy(smaller, memory, bytes);
  whittle_release(memory);
  return smaller;
}

void whittle_release(void *memory) {
  if (!memory)
    return;
  header *h = header_of(memory);
  if (h->mapped)
    munmap(h->start, h->mapped);
  else
    free(h->start);
}
