/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Inverting a 4x4 matrix: Gauss-Jordan elimination after scaling rows and columns. */

#include "base/matrix.h"

#include <float.h>
#include <math.h>

/* Below this share of its scaled row a pivot is what rounding left of 0. */
#define SMALLEST_PIVOT 0x1p-48

typedef struct system {
  double left[4][4], right[4][4];
} system4;

/* The power of two that brings `value` into [1, 2); 0 for 0. */
static int exponent_of(double value) {
  int exponent = 0;
  frexp(value, &exponent);
  return value > 0.0 ? exponent - 1 : 0;
}

/* Scales rows, then columns, by powers of two, so that each has a largest entry in [1, 2): then
 * a pivot's size says how singular the matrix is, whatever its units. */
static void equilibrate(double m[4][4], int rows[4], int columns[4]) {
  for (int i = 0; i < 4; i++) {
    double largest = 0.0;
    for (int j = 0; j < 4; j++)
      largest = fmax(largest, fabs(m[i][j]));
    rows[i] = exponent_of(largest);
    for (int j = 0; j < 4; j++)
      m[i][j] = ldexp(m[i][j], -rows[i]);
  }
  for (int j = 0; j < 4; j++) {
    double largest = 0.0;
    for (int i = 0; i < 4; i++)
      largest = fmax(largest, fabs(m[i][j]));
    columns[j] = exponent_of(largest);
    for (int i = 0; i < 4; i++)
      m[i][j] = ldexp(m[i][j], -columns[j]);
  }
}

static void swap_rows(system4 *s, int a, int b) {
  for (int j = 0; j < 4; j++) {
    const double left = s->left[a][j], right = s->right[a][j];
    s->left[a][j] = s->left[b][j];
    s->right[a][j] = s->right[b][j];
    s->left[b][j] = left;
    s->right[b][j] = right;
  }
}

static bool eliminate(system4 *s, int column) {
  int pivot = column;
  for (int i = column + 1; i < 4; i++)
    if (fabs(s->left[i][column]) > fabs(s->left[pivot][column]))
      pivot = i;
  swap_rows(s, pivot, column);
  const double divisor = s->left[column][column];
  if (!(fabs(divisor) > SMALLEST_PIVOT))
    return false;
  for (int j = 0; j < 4; j++) {
    s->left[column][j] /= divisor;
    s->right[column][j] /= divisor;
  }
  for (int i = 0; i < 4; i++) {
    const double factor = s->left[i][column];
    if (i == column || factor == 0.0)
      continue;
    for (int j = 0; j < 4; j++) {
      s->left[i][j] -= factor * s->left[column][j];
      s->right[i][j] -= factor * s->right[column][j];
    }
  }
  return true;
}

bool whittle_matrix_invert(const double matrix[16], double inverse[16]) {
  system4 s;
  int rows[4], columns[4];
  for (int i = 0; i < 16; i++) {
    if (!(fabs(matrix[i]) <= DBL_MAX))
      return false;
    s.left[i / 4][i % 4] = matrix[i];
    s.right[i / 4][i % 4] = i / 4 == i % 4 ? 1.0 : 0.0;
  }
  equilibrate(s.left, rows, columns);
  for (int column = 0; column < 4; column++)
    if (!eliminate(&s, column))
      return false;
  /* M = R S C with diagonal R and C, so the inverse is C^-1 S^-1 R^-1. */
  for (int i = 0; i < 16; i++) {
    inverse[i] = ldexp(s.right[i / 4][i % 4], -columns[i / 4] - rows[i % 4]);
    if (!(fabs(inverse[i]) <= DBL_MAX))
      return false;
  }
  return true;
}
