/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Lights and world: checked and copied. */

#include "base/memory.h"
#include "scene/scene.h"

#include <float.h>
#include <math.h>
#include <string.h>

static bool finite_color(const float c[3]) {
  return fabsf(c[0]) <= FLT_MAX && fabsf(c[1]) <= FLT_MAX && fabsf(c[2]) <= FLT_MAX;
}

static bool finite_vector(const double v[3]) {
  return fabs(v[0]) <= DBL_MAX && fabs(v[1]) <= DBL_MAX && fabs(v[2]) <= DBL_MAX;
}

static whittle_status check_light(size_t index, const whittle_light *l, whittle_error *error) {
  const char *wrong = NULL;
  if (l->kind != WHITTLE_POINT && l->kind != WHITTLE_SUN)
    wrong = "its kind is neither point nor sun";
  else if (!finite_color(l->intensity))
    wrong = "its intensity is not finite";
  else if (l->kind == WHITTLE_POINT && !finite_vector(l->position))
    wrong = "its position is not finite";
  else if (l->kind == WHITTLE_SUN && !finite_vector(l->direction))
    wrong = "its direction is not finite";
  else if (l->kind == WHITTLE_SUN && l->direction[0] == 0.0 && l->direction[1] == 0.0 &&
           l->direction[2] == 0.0)
    wrong = "its direction is 0 0 0; give the way its light travels";
  if (!wrong)
    return WHITTLE_OK;
  return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "lights", "Light %zu: %s.", index, wrong);
}

whittle_status whittle_scene_set_lights(whittle_scene *scene, const whittle_light *lights,
                                        size_t count, whittle_error *error) {
  if (count && !lights)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "lights",
                        "%zu lights, but the list is missing.", count);
  for (size_t i = 0; i < count; i++) {
    const whittle_status status = check_light(i, &lights[i], error);
    if (status != WHITTLE_OK)
      return status;
  }
  whittle_status status = whittle_scene_write_begin(scene, error);
  if (status != WHITTLE_OK)
    return status;
  whittle_light *copy = whittle_allocate(count, sizeof *copy);
  if (copy) {
    if (count)
      memcpy(copy, lights, count * sizeof *copy);
    whittle_release(scene->lights);
    scene->lights = copy;
    scene->light_count = count;
  } else {
    status = whittle_out_of_memory(error, "lights");
  }
  whittle_scene_write_end(scene);
  return status;
}

whittle_status whittle_scene_set_world(whittle_scene *scene, const whittle_world *world,
                                       whittle_error *error) {
  if (!world || !finite_color(world->color) || !finite_color(world->ambient))
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "world",
                        world ? "The world's color and ambient must be finite."
                              : "The world is missing.");
  const whittle_status status = whittle_scene_write_begin(scene, error);
  if (status != WHITTLE_OK)
    return status;
  scene->world = *world;
  whittle_scene_write_end(scene);
  return WHITTLE_OK;
}
