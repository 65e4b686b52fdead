/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The triangles that rays meet, in leaf order, and how one is taken out. */

#pragma once

#include "bvh/wide.h"
#include "scene/scene.h"

/* A triangle by itself, in scene space. */
typedef struct triangle_record {
  float v0[3], v1[3], v2[3];
} triangle_record;

/* Vectors may read this many floats past the last row. */
enum { WHITTLE_BLOCK = 8, WHITTLE_ROW_PAD = 16 };

/* A triangle among those of its block: coordinate c of its nine is first[c * size]. */
typedef struct triangle_place {
  const float *first;
  uint32_t size;
} triangle_place;

/* Where the rows of a block begin whose first triangle is `record`. */
static inline const float *whittle_rows(const triangle_store *store, uint32_t record) {
  return store->rows + 9 * (size_t)record;
}

static inline triangle_place whittle_find_triangle(const triangle_store *store, uint32_t record) {
  const uint32_t index = store->places[record] >> 4, size = store->places[record] & 15;
  return (triangle_place){whittle_rows(store, record - index) + index, size};
}

/* Of a block that is at hand: where it stands need not be looked up. */
static inline triangle_record whittle_block_triangle(const float *rows, uint32_t size,
                                                     uint32_t index) {
  triangle_record r;
  for (uint32_t k = 0; k < 3; k++) {
    r.v0[k] = rows[k * size + index];
    r.v1[k] = rows[(3 + k) * size + index];
    r.v2[k] = rows[(6 + k) * size + index];
  }
  return r;
}

static inline triangle_record whittle_take_triangle(const triangle_store *store, uint32_t record) {
  const triangle_place at = whittle_find_triangle(store, record);
  return whittle_block_triangle(at.first, at.size, 0);
}

/* Whether the triangle wins over another at equal t: the order of (instance, triangle). */
static inline bool whittle_comes_first(const triangle_store *store, uint32_t record,
                                       uint32_t other) {
  const triangle_id a = store->ids[record], b = store->ids[other];
  return a.instance != b.instance ? a.instance < b.instance : a.triangle < b.triangle;
}

/* Room for `count` triangles; false if there is no memory. */
bool whittle_triangles_reserve(triangle_store *store, size_t count);
void whittle_triangles_release(triangle_store *store);

/* Cuts a leaf into blocks, and all leaves of a tree. */
void whittle_triangles_place_leaf(triangle_store *store, uint32_t first, uint32_t count);
void whittle_triangles_place(triangle_store *store, const wide_node *nodes, uint32_t node_count);
size_t whittle_triangles_bytes(size_t count);

/* The store from triangle `first` on, which begins a block. */
static inline triangle_store whittle_triangles_from(const triangle_store *store, size_t first) {
  return (triangle_store){store->rows + 9 * first, store->ids + first, store->places + first};
}

/* Copies entries as they are, blocks or parts of them; the two may overlap. */
void whittle_triangles_move(const triangle_store *to, const triangle_store *from, size_t first,
                            size_t count);
