/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Memory of rays and surfaces: one block each, cut into arrays. */

#include "kernel/batch.h"
#include "kernel/tile.h"

#include "base/memory.h"

#include <string.h>

/* Ray trees grow by doubling; past this a tile holds more rays than any sane picture needs. */
#define MOST_RAYS (1u << 24)

/* A block of equal arrays, cut at the addresses where the pointers to them stand. */
typedef struct block {
  void **arrays[48];
  uint32_t count;
} block;

static void add_array(block *b, void *pointer) {
  b->arrays[b->count++] = pointer;
}

static void add_arrays(block *b, float **pointers, uint32_t count) {
  for (uint32_t i = 0; i < count; i++)
    add_array(b, &pointers[i]);
}

static size_t padded(uint32_t capacity) {
  return (size_t)capacity + WHITTLE_LANE_PAD;
}

static size_t block_bytes(const block *b, uint32_t capacity) {
  return capacity ? padded(capacity) * b->count * sizeof(float) : 0;
}

/* A larger block with the first `keep` entries of each array; false leaves all as it was. */
static bool block_grow(const block *b, void **memory, uint32_t *capacity, uint32_t count,
                       uint32_t keep) {
  if (count > MOST_RAYS)
    return false;
  uint32_t wanted = *capacity ? *capacity : 256;
  while (wanted < count)
    wanted *= 2;
  char *larger = whittle_allocate(padded(wanted) * b->count, sizeof(float));
  if (larger == NULL)
    return false;
  memset(larger, 0, block_bytes(b, wanted));
  for (uint32_t i = 0; i < b->count; i++) {
    void *to = larger + i * padded(wanted) * sizeof(float);
    if (keep > 0)
      memcpy(to, *b->arrays[i], keep * sizeof(float));
    *b->arrays[i] = to;
  }
  whittle_release(*memory);
  *memory = larger;
  *capacity = wanted;
  return true;
}

static block rays_block(ray_batch *batch) {
  block b = {.count = 0};
  ray_stream *rays = &batch->rays;
  add_arrays(&b, rays->origin, 3);
  add_arrays(&b, rays->direction, 3);
  add_arrays(&b, batch->weight, 3);
  void *others[] = {&rays->t_min, &rays->t,     &rays->u,         &rays->v,    &rays->record,
                    &rays->skip,  &rays->nodes, &rays->triangles, &batch->slot};
  for (uint32_t i = 0; i < sizeof others / sizeof *others; i++)
    add_array(&b, others[i]);
  if (batch->logged)
    add_array(&b, &batch->parent);
  return b;
}

bool ray_batch_reserve(ray_batch *batch, uint32_t count) {
  if (count <= batch->capacity)
    return true;
  const block b = rays_block(batch);
  return block_grow(&b, &batch->memory, &batch->capacity, count, batch->rays.count);
}

void ray_batch_release(ray_batch *batch) {
  whittle_release(batch->memory);
  *batch = (ray_batch){0};
}

size_t ray_batch_bytes(const ray_batch *batch) {
  ray_batch copy = *batch;
  const block b = rays_block(&copy);
  return block_bytes(&b, batch->capacity);
}

static block surfaces_block(surface_batch *s) {
  block b = {.count = 0};
  float **vectors[] = {s->point,  s->geometric, s->normal,    s->view,
                       s->weight, s->diffuse,   s->highlight, s->origin};
  for (uint32_t i = 0; i < sizeof vectors / sizeof *vectors; i++)
    add_arrays(&b, vectors[i], 3);
  void *others[] = {&s->error, &s->alpha, &s->u, &s->v, &s->record, &s->slot, &s->ray, &s->lit};
  for (uint32_t i = 0; i < sizeof others / sizeof *others; i++)
    add_array(&b, others[i]);
  return b;
}

bool surface_batch_reserve(surface_batch *batch, uint32_t count) {
  batch->count = batch->lit_groups = 0;
  if (count <= batch->capacity)
    return true;
  const block b = surfaces_block(batch);
  return block_grow(&b, &batch->memory, &batch->capacity, count, 0);
}

void surface_batch_release(surface_batch *batch) {
  whittle_release(batch->memory);
  *batch = (surface_batch){0};
}

size_t surface_batch_bytes(const surface_batch *batch) {
  surface_batch copy = *batch;
  const block b = surfaces_block(&copy);
  return block_bytes(&b, batch->capacity);
}
