/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Reading the data of .ply files; faces in two passes: one counts, one fills. */

#include "ply.h"

#include "fail.h"
#include "file.h"
#include "ply_header.h"

#include <stdlib.h>
#include <string.h>

typedef struct reader {
  const char *path, *at, *end;
  ply_format format;
  mesh *mesh;
  size_t triangles;
  int fills; /* the pass that fills */
} reader;

_Noreturn static void fail_early(const reader *r) {
  fail("%s ends too early, or holds what is no number", r->path);
}

static double binary_number(const unsigned char *bytes, ply_type type) {
  union {
    int8_t i8;
    uint8_t u8;
    int16_t i16;
    uint16_t u16;
    int32_t i32;
    uint32_t u32;
    float f;
    double d;
  } n;
  memcpy(&n, bytes, sizeof(n));
  const double values[] = {n.i8, n.u8, n.i16, n.u16, n.i32, n.u32};
  return type == PLY_DOUBLE ? n.d : type == PLY_FLOAT ? (double)n.f : values[type];
}

static double next_number(reader *r, ply_type type) {
  static const size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  if (r->format == PLY_ASCII) {
    char *end;
    double number = strtod(r->at, &end);
    if (end == r->at)
      fail_early(r);
    r->at = end;
    return number;
  }
  size_t size = sizes[type];
  if ((size_t)(r->end - r->at) < size)
    fail_early(r);
  unsigned char bytes[8] = {0};
  for (size_t i = 0; i < size; i++)
    bytes[r->format == PLY_BIG ? size - 1 - i : i] = (unsigned char)r->at[i];
  r->at += size;
  return binary_number(bytes, type);
}

static size_t next_count(reader *r, const ply_property *p) {
  double count = next_number(r, p->count_type);
  if (!(count >= 0 && count <= 1e9))
    fail("%s: a list has %g entries", r->path, count);
  return (size_t)count;
}

static void skip(reader *r, const ply_property *p) {
  for (size_t left = p->is_list ? next_count(r, p) : 1; left > 0; left--)
    next_number(r, p->type);
}

static uint32_t next_vertex(reader *r, const ply_property *p, size_t face) {
  double index = next_number(r, p->type);
  if (!(index >= 0 && index < (double)r->mesh->vertex_count))
    fail("%s, face %zu: there is no vertex %g among %zu, counted from 0", r->path, face, index,
         r->mesh->vertex_count);
  return (uint32_t)index;
}

static void read_fan(reader *r, const ply_property *p, size_t face) {
  size_t corners = next_count(r, p);
  if (corners < 3)
    fail("%s, face %zu: %zu corners make no polygon", r->path, face, corners);
  uint32_t first = next_vertex(r, p, face), previous = next_vertex(r, p, face);
  for (size_t i = 2; i < corners; i++) {
    uint32_t corner = next_vertex(r, p, face);
    const uint32_t triangle[3] = {first, previous, corner};
    if (r->fills)
      memcpy(r->mesh->triangles + r->triangles * 3, triangle, sizeof(triangle));
    r->triangles++;
    previous = corner;
  }
}

static int is_corners(const ply_property *p) {
  return p->is_list &&
         (strcmp(p->name, "vertex_indices") == 0 || strcmp(p->name, "vertex_index") == 0);
}

static void read_faces(reader *r, const ply_element *e) {
  for (size_t i = 0; i < e->count; i++)
    for (size_t k = 0; k < e->property_count; k++)
      if (is_corners(e->properties + k))
        read_fan(r, e->properties + k, i);
      else
        skip(r, e->properties + k);
}

/* Counts the triangles, then goes back and keeps them. */
static void read_faces_twice(reader *r, const ply_element *e) {
  const char *start = r->at;
  read_faces(r, e);
  if (r->triangles == 0 || r->triangles > INT32_MAX)
    fail("%s holds no faces, or more than 2^31 triangles", r->path);
  r->mesh->triangles = allocate(r->triangles * 3, sizeof(uint32_t));
  r->mesh->triangle_count = r->triangles;
  r->at = start;
  r->triangles = 0;
  r->fills = 1;
  read_faces(r, e);
}

static void read_vertices(reader *r, const ply_element *e) {
  for (size_t i = 0; i < e->count; i++)
    for (size_t k = 0; k < e->property_count; k++) {
      const ply_property *p = e->properties + k;
      const char *axis = strlen(p->name) == 1 ? strchr("xyz", p->name[0]) : NULL;
      if (p->is_list || !axis) {
        skip(r, p);
        continue;
      }
      float value = (float)next_number(r, p->type);
      if (!isfinite(value))
        fail("%s, vertex %zu: %s is not a finite number", r->path, i, p->name);
      r->mesh->positions[i * 3 + (size_t)(axis - "xyz")] = value;
    }
}

static void read_element(reader *r, const ply_element *e) {
  if (strcmp(e->name, "vertex") == 0)
    read_vertices(r, e);
  else if (strcmp(e->name, "face") == 0)
    read_faces_twice(r, e);
  else
    for (size_t i = 0; i < e->count * e->property_count; i++)
      skip(r, e->properties + i % e->property_count);
}

mesh ply_read(const char *path) {
  size_t bytes;
  char *text = file_read(path, &bytes);
  ply_header h;
  mesh m = {0};
  ply_read_header(&h, path, text, &m);
  const ply_element *vertices = ply_find_element(&h, "vertex");
  if (!vertices || !ply_find_element(&h, "face"))
    fail("%s has no vertices or no faces: the benchmark needs a mesh", path);
  if (vertices->count > UINT32_MAX)
    fail("%s is too large: at most 2^32 vertices", path);
  m.vertex_count = vertices->count;
  m.positions = allocate(m.vertex_count * 3, sizeof(float));
  reader r = {.path = path, .at = text + h.bytes, .end = text + bytes, .format = h.format};
  r.mesh = &m;
  for (size_t i = 0; i < h.element_count; i++)
    read_element(&r, h.elements + i);
  free(text);
  return m;
}
