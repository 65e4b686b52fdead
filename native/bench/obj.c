/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Reading Wavefront .obj files in two passes: one counts, one fills. */

#include "obj.h"

#include "fail.h"
#include "file.h"

#include <stdlib.h>
#include <string.h>

typedef struct reader {
  const char *path;
  size_t line;
  mesh *mesh; /* NULL in the pass that counts */
  size_t vertices, triangles;
} reader;

/* A backslash at the end of a line continues it. */
static void join_lines(char *text) {
  for (char *p = text; (p = strchr(p, '\\')) != NULL; p++)
    if (p[1] == '\n')
      p[0] = p[1] = ' ';
    else if (p[1] == '\r' && p[2] == '\n')
      p[0] = p[1] = p[2] = ' ';
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

static void read_line(reader *r, const char *p) {
  while (*p == ' ' || *p == '\t')
    p++;
  if (p[0] == 'v' && (p[1] == ' ' || p[1] == '\t')) {
    if (r->mesh)
      file_numbers(r->path, r->line, p + 1, r->mesh->positions + r->vertices * 3, 3, "a vertex");
    r->vertices++;
  } else if (p[0] == 'f' && (p[1] == ' ' || p[1] == '\t')) {
    read_face(r, p + 1);
  } else if (p[0] == '#' && p[1] == ' ' && r->mesh) {
    file_comment(r->path, r->line, p + 2, r->mesh);
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
  size_t bytes;
  char *text = file_read(path, &bytes);
  join_lines(text);
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
