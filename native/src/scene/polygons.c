/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Triangles of polygons: quads are divided here where there is no doubt, in pieces that threads
 * share. */

#include "base/threads.h"
#include "scene/diagonal.h"
#include "scene/mesh.h"

#include <stdbool.h>
#include <string.h>

enum { PIECES = 64, LARGE = 1 << 15, MOST_SPLITTERS = 8 };

typedef struct splitting {
  const whittle_polygons *from;
  uint32_t *to;
  bool by_corner;
  uint32_t pieces;
  atomic_uint next;
  atomic_int bad;
  atomic_size_t open;
} splitting;

/* A polygon's triangles, and its first corner: those before it have two more corners each than
 * triangles. */
typedef struct polygon {
  size_t triangle, triangles, corner;
} polygon;

static polygon polygon_at(const whittle_polygons *from, size_t triangle) {
  const uint32_t face = from->faces[triangle];
  size_t end = triangle + 1;
  while (end < from->triangle_count && from->faces[end] == face)
    end++;
  return (polygon){triangle, end - triangle, triangle + 2 * (size_t)face};
}

static bool is_good(const whittle_polygons *from, const polygon *p) {
  const bool follows = p->triangle == 0 || from->faces[p->triangle - 1] < from->faces[p->triangle];
  if (!follows || p->corner + p->triangles + 2 > from->corner_count)
    return false;
  for (size_t i = 0; i < p->triangles + 2; i++)
    if (from->corners[p->corner + i] >= from->vertex_count)
      return false;
  return true;
}

static void write_triangle(uint32_t *to, const uint32_t *index, int a, int b, int c) {
  to[0] = index[a], to[1] = index[b], to[2] = index[c];
}

static void write_quad(uint32_t *to, const uint32_t *index, quad_diagonal diagonal) {
  write_triangle(to, index, 0, 1, diagonal == DIAGONAL_FIRST ? 2 : 3);
  write_triangle(to + 3, index, diagonal == DIAGONAL_FIRST ? 0 : 1, 2, 3);
}

static quad_diagonal diagonal_of(const whittle_polygons *from, size_t corner) {
  const float *at[4];
  for (int i = 0; i < 4; i++)
    at[i] = from->positions + 3 * (size_t)from->corners[corner + (size_t)i];
  return whittle_quad_diagonal(at);
}

/* How many triangles are left open. */
static size_t split_polygon(const splitting *s, const polygon *p) {
  const uint32_t first = (uint32_t)p->corner;
  const uint32_t numbers[4] = {first, first + 1, first + 2, first + 3};
  const uint32_t *index = s->by_corner ? numbers : s->from->corners + p->corner;
  uint32_t *to = s->to + 3 * p->triangle;
  quad_diagonal diagonal = DIAGONAL_OPEN;
  if (p->triangles == 1) {
    write_triangle(to, index, 0, 1, 2);
    return 0;
  }
  if (p->triangles == 2)
    diagonal = diagonal_of(s->from, p->corner);
  if (diagonal == DIAGONAL_OPEN) {
    memset(to, 0xff, 3 * p->triangles * sizeof *to);
    return p->triangles;
  }
  write_quad(to, index, diagonal);
  return 0;
}

/* Whether the polygons of the eight triangles are four quads, all of whose corners are there and
 * none of them the last vertex. Vertices below 2^31 are told by signs, as the compiler can do four
 * at once then. */
static bool are_four_quads(const whittle_polygons *from, size_t t, size_t corner) {
  const uint32_t *face = from->faces + t, *index = from->corners + corner;
  if ((t + 8 < from->triangle_count && face[8] <= face[7]) || (t > 0 && face[-1] >= face[0]) ||
      corner + 16 > from->corner_count || from->vertex_count < 2 || from->vertex_count > INT32_MAX)
    return false;
  const uint32_t limit = (uint32_t)from->vertex_count - 2;
  uint32_t other = 0, beyond = 0;
  for (uint32_t k = 0; k < 8; k++)
    other |= face[k] ^ (face[0] + k / 2);
  for (uint32_t k = 0; k < 16; k++)
    beyond |= index[k] | (limit - index[k]);
  return !other && beyond <= INT32_MAX;
}

/* The next four polygons, if they are plain quads. */
static bool split_four(const splitting *s, size_t t) {
  const whittle_polygons *from = s->from;
  const size_t corner = t + 2 * (size_t)from->faces[t];
  if (!are_four_quads(from, t, corner))
    return false;
  const float *at[16];
  for (int k = 0; k < 16; k++)
    at[k] = from->positions + 3 * (size_t)from->corners[corner + (size_t)k];
  if (whittle_four_plain_quads(at) != 15)
    return false;
  for (uint32_t k = 0; k < 4; k++) {
    const uint32_t first = (uint32_t)corner + 4 * k;
    const uint32_t numbers[4] = {first, first + 1, first + 2, first + 3};
    write_quad(s->to + 3 * (t + 2 * k), s->by_corner ? numbers : from->corners + first,
               DIAGONAL_FIRST);
  }
  return true;
}

/* The polygons that begin in a range of triangles. */
static void split_piece(splitting *s, size_t begin, size_t end) {
  const whittle_polygons *from = s->from;
  size_t t = begin, open = 0;
  while (t > 0 && t < end && from->faces[t] == from->faces[t - 1])
    t++;
  while (t < end) {
    if (t + 8 <= from->triangle_count && split_four(s, t)) {
      t += 8;
      continue;
    }
    const polygon p = polygon_at(from, t);
    if (!is_good(from, &p)) {
      atomic_store(&s->bad, 1);
      return;
    }
    open += split_polygon(s, &p);
    t += p.triangles;
  }
  atomic_fetch_add(&s->open, open);
}

static void split_pieces(void *context, uint32_t worker, whittle_run_state *state) {
  (void)worker;
  (void)state;
  splitting *s = context;
  const size_t count = s->from->triangle_count;
  for (uint32_t k = atomic_fetch_add(&s->next, 1); k < s->pieces; k = atomic_fetch_add(&s->next, 1))
    split_piece(s, count * k / s->pieces, count * (k + 1) / s->pieces);
}

static whittle_status name_bad(const whittle_polygons *from, whittle_error *error) {
  polygon p = polygon_at(from, 0);
  while (is_good(from, &p))
    p = polygon_at(from, p.triangle + p.triangles);
  const size_t t = p.triangle, end = p.corner + p.triangles + 2;
  if (t > 0 && from->faces[t - 1] >= from->faces[t])
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "faces",
                        "Triangle %zu is of polygon %u, but the one before it of %u: these numbers "
                        "must not fall.",
                        t, from->faces[t], from->faces[t - 1]);
  if (end > from->corner_count)
    return whittle_fail(
        error, WHITTLE_INVALID_ARGUMENT, "faces",
        "Polygon %u ends at corner %zu by its triangles, but there are %zu corners.",
        from->faces[t], end, from->corner_count);
  size_t i = p.corner;
  while (from->corners[i] < from->vertex_count)
    i++;
  return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "corners",
                      "Corner %zu names vertex %u, but the mesh has %zu vertices, counted from 0.",
                      i, from->corners[i], from->vertex_count);
}

static whittle_status check(const whittle_polygons *from, const uint32_t *triangles,
                            whittle_error *error) {
  if (!from || (from->triangle_count && !(from->faces && from->corners && from->positions)))
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "polygons", "The polygons are missing.");
  if (from->triangle_count > MOST_TRIANGLES)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "faces",
                        "%zu triangles: a mesh holds at most 2147483647.", from->triangle_count);
  if (from->corner_count > UINT32_MAX)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "corners",
                        "%zu corners: a mesh holds at most 4294967295.", from->corner_count);
  if (from->triangle_count && !triangles)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "triangles",
                        "Where to put the triangles is missing.");
  return WHITTLE_OK;
}

whittle_status whittle_triangulate(const whittle_polygons *polygons, int by_corner,
                                   uint32_t *triangles, size_t *open, whittle_error *error) {
  whittle_status status = check(polygons, triangles, error);
  if (status != WHITTLE_OK)
    return status;
  const bool large = polygons->triangle_count >= LARGE;
  splitting s = {
      .from = polygons, .to = triangles, .by_corner = by_corner != 0, .pieces = large ? PIECES : 1};
  const uint32_t threads = large ? whittle_default_threads() : 1;
  if (threads > 1) {
    whittle_run_state state = {0};
    status = whittle_run(threads < MOST_SPLITTERS ? threads : MOST_SPLITTERS, split_pieces, &s,
                         &state, NULL, error);
    if (status != WHITTLE_OK)
      return status;
  } else
    split_pieces(&s, 0, NULL);
  if (atomic_load(&s.bad))
    return name_bad(polygons, error);
  if (open)
    *open = atomic_load(&s.open);
  return WHITTLE_OK;
}
