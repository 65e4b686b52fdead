/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Writing JSON. */

#include "records.h"

#include <math.h>
#include <stdio.h>

static int is_first;

static void put_string(const char *text) {
  putchar('"');
  for (const unsigned char *p = (const unsigned char *)text; *p; p++)
    if (*p == '"' || *p == '\\')
      printf("\\%c", *p);
    else if (*p < 0x20)
      printf("\\u%04x", *p);
    else
      putchar(*p);
  putchar('"');
}

static void put_name(const char *name) {
  if (!is_first)
    fputs(", ", stdout);
  is_first = 0;
  put_string(name);
  fputs(": ", stdout);
}

void record_begin(void) {
  putchar('{');
  is_first = 1;
}

void record_text(const char *name, const char *value) {
  put_name(name);
  put_string(value);
}

void record_count(const char *name, unsigned long long value) {
  put_name(name);
  printf("%llu", value);
}

void record_number(const char *name, double value) {
  put_name(name);
  if (isfinite(value))
    printf("%.6g", value);
  else
    fputs("null", stdout);
}

void record_open(const char *name) {
  put_name(name);
  record_begin();
}

void record_close(void) {
  putchar('}');
  is_first = 0;
}

void record_end(void) {
  puts("}");
  fflush(stdout);
}
