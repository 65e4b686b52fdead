/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Rays of one kind on their way through a tile, with what each carries. */

#pragma once

#include "kernel/kernel.h"

typedef struct ray_batch {
  ray_stream rays;
  float *weight[3]; /* what the ray's light counts at the pixel */
  uint32_t *slot;   /* of the tile's pixel */
  uint32_t *parent; /* only if logged: the number in the log of the ray that sent it */
  bool logged;
  uint32_t capacity;
  void *memory;
} ray_batch;

/* Makes room for `count` rays, keeping those it holds; false if there is no memory. */
bool ray_batch_reserve(ray_batch *batch, uint32_t count);
void ray_batch_release(ray_batch *batch);
size_t ray_batch_bytes(const ray_batch *batch);
