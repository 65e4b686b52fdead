/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Instances: where a mesh stands, and what follows from its transform. */

#include "scene/instance.h"
#include "base/matrix.h"

#include <float.h>
#include <math.h>
#include <string.h>

static bool finite_matrix(const double m[16]) {
  for (int i = 0; i < 16; i++)
    if (!(fabs(m[i]) <= DBL_MAX))
      return false;
  return true;
}

static double largest_entry(const double m[16]) {
  double largest = 0.0;
  for (int i = 0; i < 12; i++)
    if (i % 4 != 3)
      largest = fmax(largest, fabs(m[i]));
  return largest;
}

/* Sign of the determinant of the upper 3x3, whose entries are scaled so that it cannot overflow. */
static float side_of(const double m[16]) {
  int exponent;
  frexp(largest_entry(m), &exponent);
  double a[3][3];
  for (int i = 0; i < 9; i++)
    a[i / 3][i % 3] = ldexp(m[4 * (i / 3) + i % 3], -exponent);
  const double determinant = a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) +
                             a[0][1] * (a[1][2] * a[2][0] - a[1][0] * a[2][2]) +
                             a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
  return determinant < 0.0 ? -1.0f : 1.0f;
}

whittle_status whittle_instance_place(instance *place, const double transform[16],
                                      whittle_error *error) {
  double inverse[16];
  if (!transform)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "transform", "The matrix is missing.");
  if (!finite_matrix(transform))
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "transform",
                        "The matrix holds a number that is not finite.");
  if (transform[12] != 0.0 || transform[13] != 0.0 || transform[14] != 0.0 || transform[15] != 1.0)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "transform",
                        "The last row must be 0 0 0 1; a transposed matrix has its translation "
                        "there.");
  if (!whittle_matrix_invert(transform, inverse))
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "transform",
                        "The matrix is singular: it flattens the mesh. Leave the instance out, or "
                        "scale it by more than 0.");
  memcpy(place->transform, transform, sizeof place->transform);
  const double largest = largest_entry(inverse);
  for (int row = 0; row < 3; row++)
    for (int column = 0; column < 3; column++)
      place->normal_matrix[3 * row + column] = (float)(inverse[4 * column + row] / largest);
  place->side = side_of(transform);
  return WHITTLE_OK;
}
