/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What a caller may see of the last build. */

#include "scene/triangles.h"

#include <string.h>

whittle_status whittle_scene_dropped(const whittle_scene *scene, uint32_t mesh,
                                     uint64_t *non_finite, uint64_t *zero_area,
                                     whittle_error *error) {
  const whittle_status status = whittle_scene_read_begin(scene, error);
  if (status != WHITTLE_OK)
    return status;
  const bool known = mesh < scene->mesh_count;
  if (known && non_finite)
    *non_finite = scene->meshes[mesh].dropped_non_finite;
  if (known && zero_area)
    *zero_area = scene->meshes[mesh].dropped_zero_area;
  const size_t count = scene->mesh_count;
  whittle_scene_read_end(scene);
  if (known)
    return WHITTLE_OK;
  return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "mesh",
                      "Mesh %u is asked for, but the scene has %zu, counted from 0.", mesh, count);
}

whittle_status whittle_scene_tree(const whittle_scene *scene, whittle_tree *tree,
                                  whittle_error *error) {
  whittle_status status = whittle_scene_read_begin(scene, error);
  if (status != WHITTLE_OK)
    return status;
  status = whittle_scene_has_binary(scene, "Its nodes are", error);
  tree->nodes = scene->nodes;
  tree->node_count = scene->node_count;
  tree->triangle_count = scene->triangle_count;
  whittle_scene_read_end(scene);
  return status;
}

whittle_status whittle_scene_triangles(const whittle_scene *scene, float *vertices,
                                       uint32_t *instances, uint32_t *triangles,
                                       whittle_error *error) {
  const whittle_status status = whittle_scene_read_begin(scene, error);
  if (status != WHITTLE_OK)
    return status;
  for (size_t i = 0; i < scene->triangle_count; i++) {
    if (vertices) {
      const triangle_record triangle = whittle_take_triangle(&scene->triangles, (uint32_t)i);
      memcpy(vertices + 9 * i, triangle.v0, sizeof triangle.v0);
      memcpy(vertices + 9 * i + 3, triangle.v1, sizeof triangle.v1);
      memcpy(vertices + 9 * i + 6, triangle.v2, sizeof triangle.v2);
    }
    if (instances)
      instances[i] = scene->triangles.ids[i].instance;
    if (triangles)
      triangles[i] = scene->triangles.ids[i].triangle;
  }
  whittle_scene_read_end(scene);
  return WHITTLE_OK;
}
