/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Every ray of a render written down, with the nodes and triangles that it visited. */

#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* In scene space. What each visited lies in the log's lists behind that of the ray before. */
typedef struct logged_ray {
  uint32_t kind, sample, depth;
  uint32_t parent; /* the number of the ray that sent it, or WHITTLE_NONE */
  uint32_t light;  /* of shadow rays, else WHITTLE_NONE */
  float origin[3], direction[3];
  float t_min, t_max, t;
  float u, v;
  uint32_t record; /* index into scene->triangles, or WHITTLE_NONE */
  uint32_t nodes, triangles;
} logged_ray;

/* Whole numbers in an array that grows. */
typedef struct number_list {
  uint32_t *numbers;
  size_t count, capacity;
} number_list;

/* Of one thread. */
typedef struct ray_log {
  logged_ray *rays;
  size_t count, capacity;
  number_list nodes, triangles;
  bool full; /* memory ran out: what came then is missing */
} ray_log;

/* Adds room for `count` rays, which the caller fills; NULL if there is no memory. */
logged_ray *ray_log_add(ray_log *log, uint32_t count);

/* The ray at hand visited a node, and in it tested the triangles first .. first + tested - 1. */
void ray_log_visit(ray_log *log, uint32_t node, uint32_t first, uint32_t tested);

void ray_log_release(ray_log *log);
