/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Halving a span by the median of its centroids: what remains where the heuristic sees nothing to
 * divide, or where the depth left is just enough. */

#pragma once

#include "bvh/span.h"

/* Moves the lower half (count / 2 fragments) to `left`, the others to `right`, keeping their order;
 * fills the bounds and middles of the two spans. Gives up early once the run is cancelled. */
void whittle_median(const span *s, const whittle_fragment *fragments, whittle_fragment *left,
                    whittle_fragment *right, span children[2], whittle_run_state *state);
