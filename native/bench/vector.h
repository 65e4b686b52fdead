/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Vectors of three floats, for cameras and rays. */

#ifndef BENCH_VECTOR_H
#define BENCH_VECTOR_H

#include <math.h>

typedef struct vector {
  float x, y, z;
} vector;

static inline vector vector_from(const float *p) {
  return (vector){p[0], p[1], p[2]};
}

static inline vector add(vector a, vector b) {
  return (vector){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline vector subtract(vector a, vector b) {
  return (vector){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline vector scale(vector a, float s) {
  return (vector){a.x * s, a.y * s, a.z * s};
}

static inline float dot(vector a, vector b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline vector cross(vector a, vector b) {
  return (vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline float length(vector a) {
  return sqrtf(dot(a, a));
}

/* The zero vector stays what it is. */
static inline vector normalise(vector a) {
  float l = length(a);
  return l > 0 ? scale(a, 1 / l) : a;
}

#endif
