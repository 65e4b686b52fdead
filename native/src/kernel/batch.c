/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Memory of ray batches: one block, cut into arrays. */

#include "kernel/batch.h"

#include "base/memory.h"

#include <string.h>

/* Ray trees grow by doubling; past this a tile holds more rays than any sane picture needs. */
#define MOST_RAYS (1u << 24)

enum { ARRAYS = 19 };

/* The addresses of all arrays, in the order in which the block is cut. */
static void arrays_of(ray_batch *batch, void **array[ARRAYS]) {
  ray_stream *rays = &batch->rays;
  uint32_t n = 0;
  for (int axis = 0; axis < 3; axis++) {
    array[n++] = (void **)&rays->origin[axis];
    array[n++] = (void **)&rays->direction[axis];
    array[n++] = (void **)&batch->weight[axis];
  }
  void **others[] = {(void **)&rays->t_min,     (void **)&rays->t,     (void **)&rays->u,
                     (void **)&rays->v,         (void **)&rays->record, (void **)&rays->skip,
                     (void **)&rays->nodes,     (void **)&rays->triangles, (void **)&batch->slot};
  for (uint32_t i = 0; i < sizeof others / sizeof *others; i++)
    array[n++] = others[i];
  array[n++] = NULL;
}

bool ray_batch_reserve(ray_batch *batch, uint32_t count) {
  if (count <= batch->capacity)
    return true;
  if (count > MOST_RAYS)
    return false;
  uint32_t capacity = batch->capacity ? batch->capacity : 256;
  while (capacity < count)
    capacity *= 2;
  const size_t padded = (size_t)capacity + WHITTLE_LANE_PAD;
  char *memory = whittle_allocate(padded * (ARRAYS - 1), sizeof(float));
  if (memory == NULL)
    return false;
  memset(memory, 0, padded * (ARRAYS - 1) * sizeof(float));
  void **array[ARRAYS];
  arrays_of(batch, array);
  for (uint32_t i = 0; array[i] != NULL; i++) {
    void *to = memory + i * padded * sizeof(float);
    if (batch->memory != NULL)
      memcpy(to, *array[i], batch->rays.count * sizeof(float));
    *array[i] = to;
  }
  whittle_release(batch->memory);
  batch->memory = memory;
  batch->capacity = capacity;
  return true;
}

void ray_batch_release(ray_batch *batch) {
  whittle_release(batch->memory);
  *batch = (ray_batch){0};
}

size_t ray_batch_bytes(const ray_batch *batch) {
  return batch->capacity ? ((size_t)batch->capacity + WHITTLE_LANE_PAD) * (ARRAYS - 1) * sizeof(float)
                         : 0;
}
