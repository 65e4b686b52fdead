/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Reading Wavefront .obj files in two passes: one counts, one fills. */

#include "obj.h"

#include "fail.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct reader {
  const char *path;
  size_t line;
  mesh *mesh; /* NULL in the pass that counts */
  size_t vertices, triangles;
} reader;

static char *read_text(const char *path) {
  FILE *file = fopen(path, "rb");
  if (!file)
    fail("cannot read %s: %s", path, strerror(errno));
  if (fseek(file, 0, SEEK_END) != 0)
    fail("cannot read %s: %s", path, strerror(errno));
  long bytes = ftell(file);
  rewind(file);
  char *text = allocate((size_t)bytes + 1, 1);
  if (fread(text, 1, (size_t)bytes, file) != (size_t)bytes)
    fail("cannot read %s to its end", path);
  fclose(file);
  /* A backslash at the end of a line continues it. */
  for (char *p = text; (p = strchr(p, '\\')) != NULL; p++)
    if (p[1] == '\n')
      p[0] = p[1] = ' ';
    else if (p[1] == '\r' && p[2] == '\n')
      p[0] = p[1] = p[2] = ' ';
  return text;
}

static void read_numbers(const reader *r, const char *p, float *numbers, int count,
                         const char *what) {
  for (int i = 0; i < count; i++) {
    char *end;
    numbers[i] = strtof(p, &end);
    if (end == p || !isfinite(numbers[i]))
      fail("%s, line %zu: %s needs %d finite numbers", r->path, r->line, what, count);
    p = end;
  }
}

static uint32_t resolve_index(const reader *r, long index) {
  size_t total = r->mesh->vertex_count;
  if (index > 0 && (size_t)index <= total)
    return (uint32_t)(index - 1);
  if (index < 0 && (size_t)-index <= r->vertices)
    return (uint32_t)(r->vertices - (size_t)-index);
  fail("%s, line %zu: there is no vertex %ld among %zu", r->path, r->line, index, total);
}

static void emit_triangle(reader *r, uint32_t a, uint32_t b, uint32_t c) {
  if (r->mesh) {
    uint32_t *t = r->mesh->triangles + r->triangles * 3;
    t[0] = a;
    t[1] = b;
    t[2] = c;
  }
  r->triangles++;
}

static void read_face(reader *r, const char *p) {
  uint32_t first = 0, previous = 0;
  size_t corners = 0;
  for (;;) {
    char *end;
    long index = strtol(p, &end, 10);
    if (end == p)
      break;
    uint32_t vertex = r->mesh ? resolve_index(r, index) : 0;
    if (corners == 0)
      first = vertex;
    if (corners >= 2)
      emit_triangle(r, first, previous, vertex);
    previous = vertex;
    corners++;
    p = end;
    if (*p == '/') /* texture and normal indices */
      p += strspn(p, "/-0123456789");
  }
  p += strspn(p, " \t\r");
  if (corners < 3 || (*p != '\0' && *p != '#'))
    fail("%s, line %zu: a face needs at least 3 vertex indices", r->path, r->line);
}

static void read_comment(reader *r, const char *p) {
  if (!r->mesh)
    return;
  float n[10];
  if (strncmp(p, "# camera:", 9) == 0) {
    read_numbers(r, p + 9, n, 10, "a camera (eye, target, up, fov)");
    r->mesh->camera = (camera){vector_from(n), vector_from(n + 3), vector_from(n + 6), n[9]};
    r->mesh->has_camera = 1;
  } else if (strncmp(p, "# light:", 8) == 0) {
    read_numbers(r, p + 8, n, 3, "a light");
    r->mesh->light = vector_from(n);
    r->mesh->has_light = 1;
  }
}

static void read_line(reader *r, const char *p) {
  while (*p == ' ' || *p == '\t')
    p++;
  if (p[0] == 'v' && (p[1] == ' ' || p[1] == '\t')) {
    if (r->mesh)
      read_numbers(r, p + 1, r->mesh->positions + r->vertices * 3, 3, "a vertex");
    r->vertices++;
  } else if (p[0] == 'f' && (p[1] == ' ' || p[1] == '\t')) {
    read_face(r, p + 1);
  } else if (p[0] == '#') {
    read_comment(r, p);
  }
}

static void read_pass(reader *r, char *text) {
  r->line = r->vertices = r->triangles = 0;
  for (char *p = text, *next; p; p = next) {
    char *end = strchr(p, '\n');
    next = end ? end + 1 : NULL;
    if (end)
      *end = '\0';
    r->line++;
    read_line(r, p);
    if (end)
      *end = '\n';
  }
}

mesh obj_read(const char *path) {
  char *text = read_text(path);
  reader r = {.path = path};
  read_pass(&r, text);
  if (r.triangles == 0)
    fail("%s holds no faces: the benchmark needs a mesh", path);
  if (r.vertices > UINT32_MAX || r.triangles > INT32_MAX)
    fail("%s is too large: at most 2^31 triangles", path);
  mesh m = mesh_new(r.vertices, r.triangles);
  r.mesh = &m;
  read_pass(&r, text);
  free(text);
  return m;
}
