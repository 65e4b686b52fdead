/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Reading files, numbers and views. */

#include "file.h"

#include "fail.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

char *file_read(const char *path, size_t *bytes) {
  FILE *file = fopen(path, "rb");
  if (!file)
    fail("cannot read %s: %s", path, strerror(errno));
  if (fseek(file, 0, SEEK_END) != 0)
    fail("cannot read %s: %s", path, strerror(errno));
  *bytes = (size_t)ftell(file);
  rewind(file);
  char *text = allocate(*bytes + 1, 1);
  if (fread(text, 1, *bytes, file) != *bytes)
    fail("cannot read %s to its end", path);
  fclose(file);
  return text;
}

void file_numbers(const char *path, size_t line, const char *text, float *numbers, int count,
                  const char *what) {
  for (int i = 0; i < count; i++) {
    char *end;
    numbers[i] = strtof(text, &end);
    if (end == text || !isfinite(numbers[i]))
      fail("%s, line %zu: %s needs %d finite numbers", path, line, what, count);
    text = end;
  }
}

void file_comment(const char *path, size_t line, const char *text, mesh *m) {
  float n[10];
  if (strncmp(text, "camera:", 7) == 0) {
    file_numbers(path, line, text + 7, n, 10, "a camera (eye, target, up, fov)");
    m->camera = (camera){vector_from(n), vector_from(n + 3), vector_from(n + 6), n[9]};
    m->has_camera = 1;
  } else if (strncmp(text, "light:", 6) == 0) {
    file_numbers(path, line, text + 6, n, 3, "a light");
    m->light = vector_from(n);
    m->has_light = 1;
  }
}
