/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Each instance alone: what its own tree would cost, and how much of it stands in others' leaves.
 */

#pragma once

#include "base/team.h"
#include "scene/parts.h"

/* The triangles in the order of their instances. */
typedef struct own_order {
  uint32_t *triangles; /* places in leaf order */
  uint64_t *first;     /* by instance, one more at the end */
} own_order;

whittle_status whittle_own_order(const judged_scene *judged, size_t instances, own_order *order,
                                 whittle_error *error);
void whittle_own_order_free(own_order *order);

/* Called by the leader of a team; the first builds tree after tree. */
whittle_status whittle_own_trees(whittle_team *team, const judged_scene *judged,
                                 const own_order *order, whittle_quality *quality,
                                 whittle_error *error);
void whittle_inside_others(whittle_team *team, const judged_scene *judged, const own_order *order,
                           whittle_quality *quality);

/* How many units the two add to the run's `done`. */
uint64_t whittle_own_units(const own_order *order, size_t instances);
