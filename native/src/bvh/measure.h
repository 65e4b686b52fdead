/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Small measures of boxes that several judges of the tree share. */

#pragma once

#include "whittle.h"

/* Half the surface of a box, in double precision. */
static inline double whittle_half_area(const float lo[3], const float hi[3]) {
  const double x = (double)hi[0] - (double)lo[0], y = (double)hi[1] - (double)lo[1];
  const double z = (double)hi[2] - (double)lo[2];
  return x * y + y * z + z * x;
}

static inline double whittle_node_area(const whittle_node *node) {
  return whittle_half_area(node->bounds_min, node->bounds_max);
}
