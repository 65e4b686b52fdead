/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Every ray of a render written down, with the nodes and triangles that it visited. */

#include "kernel/ray_log.h"

#include "base/memory.h"

#include <string.h>

/* Makes room for `more` entries of `size` bytes behind the first `count`; false leaves all as is.
 */
static bool grow(void **memory, size_t *capacity, size_t count, size_t more, size_t size) {
  if (*capacity - count >= more)
    return true;
  size_t wanted = *capacity ? *capacity : 1024;
  while (wanted - count < more)
    wanted *= 2;
  void *larger = whittle_allocate(wanted, size);
  if (larger == NULL)
    return false;
  if (count > 0)
    memcpy(larger, *memory, count * size);
  whittle_release(*memory);
  *memory = larger, *capacity = wanted;
  return true;
}

logged_ray *ray_log_add(ray_log *log, uint32_t count) {
  void *rays = log->rays;
  if (log->count + count > UINT32_MAX ||
      !grow(&rays, &log->capacity, log->count, count, sizeof *log->rays))
    return NULL;
  log->rays = rays;
  logged_ray *added = log->rays + log->count;
  log->count += count;
  return added;
}

static bool list_add(number_list *list, uint32_t first, uint32_t count) {
  void *numbers = list->numbers;
  if (!grow(&numbers, &list->capacity, list->count, count, sizeof *list->numbers))
    return false;
  list->numbers = numbers;
  for (uint32_t i = 0; i < count; i++)
    list->numbers[list->count++] = first + i;
  return true;
}

void ray_log_visit(ray_log *log, uint32_t node, uint32_t first, uint32_t tested) {
  if (log->full)
    return;
  log->full = !list_add(&log->nodes, node, 1) || !list_add(&log->triangles, first, tested);
}

void ray_log_release(ray_log *log) {
  whittle_release(log->rays);
  whittle_release(log->nodes.numbers);
  whittle_release(log->triangles.numbers);
  *log = (ray_log){0};
}
