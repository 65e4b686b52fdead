/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Aligned memory with checked sizes; large pieces ask for large pages. */

#include "base/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>

enum { LINE = 64, LARGE_PAGE = 1 << 21 };

void *whittle_allocate(size_t count, size_t size) {
  size_t bytes;
  if (__builtin_mul_overflow(count, size, &bytes) || bytes > PTRDIFF_MAX - LARGE_PAGE)
    return NULL;
  const size_t alignment = bytes >= 2 * LARGE_PAGE ? LARGE_PAGE : LINE;
  void *memory = NULL;
  if (posix_memalign(&memory, alignment, bytes ? bytes : 1) != 0)
    return NULL;
  /* Fewer page faults while it is filled, and quicker to give back; only a wish. */
  if (alignment == LARGE_PAGE)
    madvise(memory, bytes & ~(size_t)(LARGE_PAGE - 1), MADV_HUGEPAGE);
  return memory;
}

void whittle_release(void *memory) { free(memory); }
