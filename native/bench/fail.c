/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Errors end the program; see fail.h. */

#include "fail.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void fail(const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  fputs("bench: ", stderr);
  vfprintf(stderr, format, arguments);
  fputc('\n', stderr);
  va_end(arguments);
  exit(1);
}

void *allocate(size_t count, size_t size) {
  size_t slack = 128;
  if (size != 0 && count > (SIZE_MAX - slack) / size)
    fail("%zu elements of %zu bytes are more than memory can address", count, size);
  size_t bytes = (count * size + slack) / 64 * 64;
  void *memory = aligned_alloc(64, bytes);
  if (!memory)
    fail("out of memory: %zu bytes are not to be had", bytes);
  return memset(memory, 0, bytes);
}
