/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Matrices and vectors in plain double, so that no library's kernels decide our bits. */

#pragma once

#include <stdbool.h>

/* Row-major 4x4. False if not finite or singular. */
bool whittle_matrix_invert(const double matrix[16], double inverse[16]);

/* out = M (p, 1), first three components, for a matrix with last row 0 0 0 1. */
static inline void whittle_matrix_point(const double m[16], const double p[3], double out[3]) {
  for (int row = 0; row < 3; row++)
    out[row] =
        ((m[4 * row] * p[0] + m[4 * row + 1] * p[1]) + m[4 * row + 2] * p[2]) + m[4 * row + 3];
}
