/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Materials: checked, completed and copied. */

#include "base/memory.h"
#include "scene/scene.h"

#include <float.h>
#include <string.h>

static whittle_status check_number(size_t index, const char *name, float value, float most,
                                   whittle_error *error) {
  if (value >= 0.0f && value <= most)
    return WHITTLE_OK;
  if (most == FLT_MAX)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "materials",
                        "Material %zu: %s is %g, but must be finite and not negative.", index, name,
                        (double)value);
  return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "materials",
                      "Material %zu: %s is %g, but must be between 0 and %g.", index, name,
                      (double)value, (double)most);
}

static whittle_status check_color(size_t index, const char *name, const float color[3],
                                  whittle_error *error) {
  whittle_status status = WHITTLE_OK;
  for (int i = 0; i < 3 && status == WHITTLE_OK; i++)
    status = check_number(index, name, color[i], FLT_MAX, error);
  return status;
}

static whittle_status check_material(size_t index, const whittle_material *m,
                                     whittle_error *error) {
  const struct {
    const char *name;
    const float *color;
  } colors[] = {{"diffuse", m->diffuse},   {"mirror", m->mirror},
                {"metal", m->metal},       {"specular", m->specular},
                {"emission", m->emission}, {"transmission", m->transmission}};
  whittle_status status = WHITTLE_OK;
  for (size_t i = 0; i < sizeof colors / sizeof *colors && status == WHITTLE_OK; i++)
    status = check_color(index, colors[i].name, colors[i].color, error);
  if (status == WHITTLE_OK)
    status = check_number(index, "metal_weight", m->metal_weight, 1.0f, error);
  if (status == WHITTLE_OK)
    status = check_number(index, "ior", m->ior, FLT_MAX, error);
  if (status == WHITTLE_OK)
    status = check_number(index, "roughness", m->roughness, 1.0f, error);
  return status;
}

static void complete(whittle_material *m) {
  if (m->ior == 0.0f)
    m->ior = 1.5f;
}

whittle_status whittle_scene_set_materials(whittle_scene *scene, const whittle_material *materials,
                                           size_t count, whittle_error *error) {
  const whittle_material plain = {.diffuse = {0.8f, 0.8f, 0.8f}};
  if (count && !materials)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "materials",
                        "%zu materials, but the list is missing.", count);
  for (size_t i = 0; i < count; i++) {
    const whittle_status status = check_material(i, &materials[i], error);
    if (status != WHITTLE_OK)
      return status;
  }
  if (count == 0) {
    materials = &plain;
    count = 1;
  }
  whittle_status status = whittle_scene_write_begin(scene, error);
  if (status != WHITTLE_OK)
    return status;
  whittle_material *copy = whittle_allocate(count, sizeof *copy);
  if (copy) {
    memcpy(copy, materials, count * sizeof *copy);
    for (size_t i = 0; i < count; i++)
      complete(&copy[i]);
    whittle_release(scene->materials);
    scene->materials = copy;
    scene->material_count = count;
  } else {
    status = whittle_out_of_memory(error, "materials");
  }
  whittle_scene_write_end(scene);
  return status;
}
