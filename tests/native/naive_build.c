/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* A first builder as in many a tutorial, counting what goes wrong in it instead of crashing. */

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { BINS = 16, DEEPEST = 2000 };

/* What naive_build fills; must match the array in naive.py. */
typedef struct outcome {
  int64_t largest_leaf, depth, nodes;
  int64_t bad_bins;  /* centroids that fall into no bin: an index out of range */
  int64_t bad_costs; /* areas, costs or centroids that are not finite */
} outcome;

typedef struct builder {
  const float *v;
  int32_t *order, *spare;
  int midpoint; /* split boxes in halves instead of by binned surface areas */
  outcome *out;
} builder;

static float centroid(const builder *b, int32_t id, int axis) {
  const float *v = b->v + 9 * (int64_t)id + axis;
  const float low = fminf(fminf(v[0], v[3]), v[6]), high = fmaxf(fmaxf(v[0], v[3]), v[6]);
  return 0.5f * (low + high);
}

static float half_area(const float *low, const float *high) {
  const float x = high[0] - low[0], y = high[1] - low[1], z = high[2] - low[2];
  return x * y + y * z + z * x;
}

static void grow(const builder *b, int32_t id, float *low, float *high) {
  const float *v = b->v + 9 * (int64_t)id;
  for (int i = 0; i < 9; i++) {
    low[i % 3] = fminf(low[i % 3], v[i]);
    high[i % 3] = fmaxf(high[i % 3], v[i]);
  }
}

static int bin_of(builder *b, int32_t id, int axis, float from, float scale) {
  const float at = (centroid(b, id, axis) - from) * scale;
  if (at >= 0 && at < BINS)
    return (int)at;
  b->out->bad_bins++;
  return at >= BINS ? BINS - 1 : 0;
}

/* Cost of the best split along one axis by the areas of bins; its first bin on the right. */
static float best_split(builder *b, int64_t first, int64_t count, int axis, float from, float scale,
                        int *split) {
  float low[BINS][3], high[BINS][3];
  int64_t filled[BINS] = {0};
  for (int i = 0; i < BINS; i++)
    for (int k = 0; k < 3; k++) {
      low[i][k] = INFINITY;
      high[i][k] = -INFINITY;
    }
  for (int64_t i = first; i < first + count; i++) {
    const int bin = bin_of(b, b->order[i], axis, from, scale);
    filled[bin]++;
    grow(b, b->order[i], low[bin], high[bin]);
  }
  float best = INFINITY;
  for (int cut = 1; cut < BINS; cut++) {
    float cost = 0;
    for (int side = 0; side < 2; side++) {
      float l[3] = {INFINITY, INFINITY, INFINITY}, h[3] = {-INFINITY, -INFINITY, -INFINITY};
      int64_t members = 0;
      for (int i = side ? cut : 0; i < (side ? BINS : cut); i++) {
        members += filled[i];
        for (int k = 0; k < 3; k++) {
          l[k] = fminf(l[k], low[i][k]);
          h[k] = fmaxf(h[k], high[i][k]);
        }
      }
      cost = members ? cost + (float)members * half_area(l, h) : INFINITY;
      b->out->bad_costs += members && !isfinite(cost);
      if (!members)
        break;
    }
    if (cost < best) {
      best = cost;
      *split = cut;
    }
  }
  return best;
}

static void subdivide(builder *b, int64_t first, int64_t count, int64_t depth) {
  float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  float c_low[3] = {INFINITY, INFINITY, INFINITY}, c_high[3] = {-INFINITY, -INFINITY, -INFINITY};
  outcome *out = b->out;
  out->nodes++;
  out->depth = depth > out->depth ? depth : out->depth;
  for (int64_t i = first; i < first + count; i++) {
    grow(b, b->order[i], low, high);
    for (int k = 0; k < 3; k++) {
      const float c = centroid(b, b->order[i], k);
      out->bad_costs += !isfinite(c);
      c_low[k] = fminf(c_low[k], c);
      c_high[k] = fmaxf(c_high[k], c);
    }
  }
  int axis = -1, split = 0;
  float best = b->midpoint ? INFINITY : (float)count * half_area(low, high);
  float from = 0, scale = 0;
  for (int k = 0; k < 3 && count > 1 && depth < DEEPEST; k++) {
    const float start = c_low[k], step = 0.99999f * BINS / (c_high[k] - c_low[k]);
    int cut = 0;
    float cost = INFINITY;
    if (b->midpoint)
      cost = c_high[k] > c_low[k] ? -(high[k] - low[k]) : INFINITY;
    else if (c_high[k] != c_low[k])
      cost = best_split(b, first, count, k, start, step, &cut);
    if (cost < best) {
      best = cost;
      axis = k;
      split = cut;
      from = start;
      scale = step;
    }
  }
  int64_t left = first, right = first + count;
  for (int64_t i = first; axis >= 0 && i < first + count; i++) {
    const int32_t id = b->order[i];
    const int before = b->midpoint ? centroid(b, id, axis) < 0.5f * (low[axis] + high[axis])
                                   : bin_of(b, id, axis, from, scale) < split;
    b->spare[before ? left++ : --right] = id;
  }
  if (axis < 0 || left == first || right == first + count) {
    out->largest_leaf = count > out->largest_leaf ? count : out->largest_leaf;
    return;
  }
  memcpy(b->order + first, b->spare + first, (size_t)count * sizeof *b->order);
  subdivide(b, first, left - first, depth + 1);
  subdivide(b, left, first + count - left, depth + 1);
}

/* 0, or 1 if memory is short. */
int naive_build(const float *v, int64_t n, int midpoint, outcome *out) {
  builder b = {v, malloc((size_t)(n + 1) * sizeof(int32_t)),
               malloc((size_t)(n + 1) * sizeof(int32_t)), midpoint, out};
  memset(out, 0, sizeof *out);
  const int fine = b.order && b.spare;
  for (int64_t i = 0; fine && i < n; i++)
    b.order[i] = (int32_t)i;
  if (fine && n)
    subdivide(&b, 0, n, 0);
  free(b.order);
  free(b.spare);
  return !fine;
}
