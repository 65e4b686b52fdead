/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Memory of the triangles. */

#include "scene/triangles.h"

#include "base/memory.h"

#include <string.h>

bool whittle_triangles_reserve(triangle_store *store, size_t count) {
  store->rows = whittle_allocate(9 * count + WHITTLE_ROW_PAD, sizeof *store->rows);
  store->ids = whittle_allocate(count, sizeof *store->ids);
  store->places = whittle_allocate(count, sizeof *store->places);
  if (!store->rows || !store->ids || !store->places) {
    whittle_triangles_release(store);
    return false;
  }
  memset(store->rows + 9 * count, 0, WHITTLE_ROW_PAD * sizeof *store->rows);
  return true;
}

void whittle_triangles_release(triangle_store *store) {
  whittle_release(store->rows);
  whittle_release(store->ids);
  whittle_release(store->places);
  *store = (triangle_store){0};
}

void whittle_triangles_move(const triangle_store *to, const triangle_store *from, size_t first,
                            size_t count) {
  memmove(to->rows + 9 * first, from->rows + 9 * first, 9 * count * sizeof *to->rows);
  memmove(to->ids + first, from->ids + first, count * sizeof *to->ids);
  memmove(to->places + first, from->places + first, count * sizeof *to->places);
}

void whittle_triangles_place_leaf(triangle_store *store, uint32_t first, uint32_t count) {
  for (uint32_t i = 0; i < count; i++) {
    const uint32_t index = i % WHITTLE_BLOCK, left = count - (i - index);
    store->places[first + i] =
        (uint8_t)(index << 4 | (left < WHITTLE_BLOCK ? left : WHITTLE_BLOCK));
  }
}

void whittle_triangles_place(triangle_store *store, const wide_node *nodes, uint32_t node_count) {
  for (uint32_t i = 0; i < node_count; i++)
    for (uint32_t k = 0; k < WHITTLE_WIDTH; k++)
      if (nodes[i].low[0][k] <= nodes[i].high[0][k] && wide_is_leaf(nodes[i].child[k]))
        whittle_triangles_place_leaf(store, nodes[i].child[k].first, nodes[i].child[k].count);
}

size_t whittle_triangles_bytes(size_t count) {
  return count * (9 * sizeof(float) + sizeof(triangle_id) + sizeof(uint8_t));
}
