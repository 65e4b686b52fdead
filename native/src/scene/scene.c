/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The scene's life: created, filled, destroyed. */

#include "scene/scene.h"
#include "base/memory.h"
#include "scene/instance.h"
#include "scene/mesh.h"
#include "scene/subtrees.h"
#include "scene/triangles.h"

#include <string.h>

whittle_status whittle_scene_create(whittle_scene **scene, whittle_error *error) {
  if (!scene)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "scene",
                        "Where to put the scene is "
                        "missing.");
  *scene = NULL;
  whittle_scene *made = whittle_allocate(1, sizeof *made);
  if (!made)
    return whittle_out_of_memory(error, "a scene");
  memset(made, 0, sizeof *made);
  atomic_init(&made->users, 0);
  const whittle_status status = whittle_scene_set_materials(made, NULL, 0, error);
  if (status != WHITTLE_OK) {
    whittle_release(made);
    return status;
  }
  *scene = made;
  return WHITTLE_OK;
}

void whittle_scene_destroy(whittle_scene *scene) {
  if (!scene)
    return;
  for (size_t i = 0; i < scene->mesh_count; i++)
    whittle_mesh_free(&scene->meshes[i]);
  whittle_release(scene->meshes);
  whittle_release(scene->instances);
  whittle_release(scene->materials);
  whittle_release(scene->lights);
  whittle_release(scene->node_block);
  whittle_release(scene->wide);
  whittle_triangles_release(&scene->triangles);
  whittle_subtrees_free(scene->subtrees);
  whittle_release(scene);
}

/* Room for one more element of `size` bytes. */
static bool grow(void **list, size_t count, size_t *capacity, size_t size) {
  if (count < *capacity)
    return true;
  const size_t wider = *capacity ? 2 * *capacity : 8;
  void *memory = whittle_allocate(wider, size);
  if (!memory)
    return false;
  if (count)
    memcpy(memory, *list, count * size);
  whittle_release(*list);
  *list = memory;
  *capacity = wider;
  return true;
}

static whittle_status add_mesh(whittle_scene *scene, const whittle_mesh *source, uint32_t *index,
                               whittle_error *error) {
  if (!grow((void **)&scene->meshes, scene->mesh_count, &scene->mesh_capacity, sizeof(mesh)))
    return whittle_out_of_memory(error, "the list of meshes");
  const whittle_status status = whittle_mesh_take(&scene->meshes[scene->mesh_count], source, error);
  if (status != WHITTLE_OK)
    return status;
  if (index)
    *index = (uint32_t)scene->mesh_count;
  scene->meshes[scene->mesh_count++].version = ++scene->mesh_version;
  scene->built = false;
  return WHITTLE_OK;
}

whittle_status whittle_scene_add_mesh(whittle_scene *scene, const whittle_mesh *source,
                                      uint32_t *index, whittle_error *error) {
  whittle_status status = whittle_scene_write_begin(scene, error);
  if (status != WHITTLE_OK)
    return status;
  status = add_mesh(scene, source, index, error);
  whittle_scene_write_end(scene);
  return status;
}

static whittle_status add_instance(whittle_scene *scene, const instance *wanted,
                                   const double transform[16], uint32_t *index,
                                   whittle_error *error) {
  if (wanted->mesh >= scene->mesh_count)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "mesh",
                        "Mesh %u is asked for, but the scene has %zu, counted from 0.",
                        wanted->mesh, scene->mesh_count);
  if (wanted->visibility & ~(uint32_t)WHITTLE_ALL)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "visibility",
                        "Visibility is %u, but must be a sum of CAMERA, SHADOW, REFLECTION and "
                        "REFRACTION (1, 2, 4, 8).",
                        wanted->visibility);
  instance placed = *wanted;
  const whittle_status status = whittle_instance_place(&placed, transform, error);
  if (status != WHITTLE_OK)
    return status;
  if (scene->instance_count >= INT32_MAX || !grow((void **)&scene->instances, scene->instance_count,
                                                  &scene->instance_capacity, sizeof(instance)))
    return whittle_out_of_memory(error, "the list of instances");
  if (index)
    *index = (uint32_t)scene->instance_count;
  scene->instances[scene->instance_count++] = placed;
  scene->built = false;
  return WHITTLE_OK;
}

whittle_status whittle_scene_add_instance(whittle_scene *scene, uint32_t mesh,
                                          const double transform[16], int32_t object_id,
                                          uint32_t visibility, uint32_t *index,
                                          whittle_error *error) {
  whittle_status status = whittle_scene_write_begin(scene, error);
  if (status != WHITTLE_OK)
    return status;
  const instance wanted = {.mesh = mesh, .object_id = object_id, .visibility = visibility};
  status = add_instance(scene, &wanted, transform, index, error);
  whittle_scene_write_end(scene);
  return status;
}
