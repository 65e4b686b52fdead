/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The tables of a render's cost as numpy arrays. */

#pragma once

#include "arrays.h"

typedef struct cost_tables {
  whittle_cost cost;
  array_view views[4];
} cost_tables;

/* A new dict of new tables, instance and material -> nodes and triangles, held until
 * cost_tables_release, which may follow a failure. */
PyObject *cost_tables_new(module_state *state, const whittle_scene *scene, cost_tables *tables);
void cost_tables_release(cost_tables *tables);
