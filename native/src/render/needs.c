/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What a scene needs, as one mask; what it does not is left out. */

#include "render/render.h"

bool whittle_wants_counters(const whittle_image *image) {
  if (image->cost != NULL)
    return true;
  for (int pass = WHITTLE_PASS_NODES; pass <= WHITTLE_PASS_LEAF_DEPTH; pass++)
    if (image->pass[pass] != NULL)
      return true;
  return false;
}

static bool positive(const float color[3]) {
  return color[0] > 0.0f || color[1] > 0.0f || color[2] > 0.0f;
}

static uint32_t material_needs(const whittle_material *m) {
  const bool reflects = positive(m->mirror) || m->metal_weight > 0.0f || positive(m->specular);
  uint32_t needs = 0;
  if (reflects)
    needs |= m->roughness > 0.0f ? WHITTLE_NEED_HIGHLIGHT : WHITTLE_NEED_MIRROR;
  if (positive(m->transmission))
    needs |= WHITTLE_NEED_GLASS;
  return needs;
}

uint32_t whittle_needs(const whittle_scene *scene, const whittle_settings *settings,
                       const whittle_image *image) {
  uint32_t needs = 0;
  for (size_t i = 0; i < scene->material_count; i++)
    needs |= material_needs(&scene->materials[i]);
  for (size_t i = 0; i < scene->instance_count; i++) {
    const instance *placed = &scene->instances[i];
    if (placed->removed)
      continue;
    if (scene->meshes[placed->mesh].normals != NULL)
      needs |= WHITTLE_NEED_SMOOTH;
    if (placed->visibility != WHITTLE_ALL)
      needs |= WHITTLE_NEED_VISIBILITY;
  }
  if (scene->light_count > 1)
    needs |= WHITTLE_NEED_LIGHTS;
  if (whittle_wants_counters(image))
    needs |= WHITTLE_NEED_COUNTERS;
  if (settings->samples > 1)
    needs |= WHITTLE_NEED_SAMPLES;
  return needs;
}

static const struct {
  uint32_t need;
  const char *name, *reason;
} table[] = {
    {WHITTLE_NEED_MIRROR, "mirror", "no material reflects sharply"},
    {WHITTLE_NEED_GLASS, "glass", "no material transmits"},
    {WHITTLE_NEED_SMOOTH, "smooth normals", "every mesh is flat shaded"},
    {WHITTLE_NEED_LIGHTS, "several lights", "at most one light shines"},
    {WHITTLE_NEED_HIGHLIGHT, "highlights", "no reflecting material is rough"},
    {WHITTLE_NEED_COUNTERS, "counters", "neither heatmap nor cost is wanted"},
    {WHITTLE_NEED_SAMPLES, "samples", "one sample a pixel"},
    {WHITTLE_NEED_VISIBILITY, "ray visibility", "every object is seen by all rays"},
};

const char *whittle_need_name(uint32_t need) {
  for (size_t i = 0; i < sizeof table / sizeof *table; i++)
    if (table[i].need == need)
      return table[i].name;
  return NULL;
}

const char *whittle_need_reason(uint32_t need) {
  for (size_t i = 0; i < sizeof table / sizeof *table; i++)
    if (table[i].need == need)
      return table[i].reason;
  return NULL;
}
