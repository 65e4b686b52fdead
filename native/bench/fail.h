/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* How the benchmark stops on an error, and memory that cannot be NULL. */

#ifndef BENCH_FAIL_H
#define BENCH_FAIL_H

#include <stddef.h>

/* Prints one sentence to standard error and exits with 1. */
_Noreturn void fail(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* `count` elements of `size` bytes, zeroed, on a cache line, with 64 readable bytes behind the
 * last: Embree reads vertices 16 bytes at a time. Free with free(). */
void *allocate(size_t count, size_t size);

#endif
