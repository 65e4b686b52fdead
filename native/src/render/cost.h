/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Who pays for rays: the owners of nodes and triangles, and the tables of what they were charged.
 */

#pragma once

#include "kernel/tile.h"

/* Finds the owners in a scene that is built and whose materials exist. */
whittle_status whittle_cost_begin(const whittle_scene *scene, cost_owners *owners,
                                  whittle_error *error);
void whittle_cost_end(cost_owners *owners);
size_t whittle_cost_owner_bytes(const cost_owners *owners, const whittle_scene *scene);

/* Whether a caller's tables have as many columns as the scene needs. */
whittle_status whittle_cost_check(const whittle_scene *scene, const whittle_cost *cost,
                                  whittle_error *error);

/* One worker's tables, all 0; false if there is no memory. */
bool whittle_cost_worker_begin(const cost_owners *owners, tile_worker *worker);
void whittle_cost_worker_end(tile_worker *worker);
size_t whittle_cost_worker_bytes(const cost_owners *owners);

/* The sums over workers into the caller's tables. */
void whittle_cost_sum(const cost_owners *owners, const tile_worker *workers, uint32_t count,
                      const whittle_cost *cost);
