/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Changing a scene: an instance moved or removed, a mesh replaced. */

#include "scene/instance.h"
#include "scene/mesh.h"

static whittle_status check_instance(const whittle_scene *scene, uint32_t number,
                                     whittle_error *error) {
  if (number >= scene->instance_count)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "instance",
                        "Instance %u is asked for, but the scene has %zu, counted from 0.", number,
                        scene->instance_count);
  if (scene->instances[number].removed)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "instance",
                        "Instance %u was removed; add a new one and use its number.", number);
  return WHITTLE_OK;
}

static whittle_status set_transform(whittle_scene *scene, uint32_t number,
                                    const double transform[16], whittle_error *error) {
  whittle_status status = check_instance(scene, number, error);
  if (status == WHITTLE_OK)
    status = whittle_instance_place(&scene->instances[number], transform, error);
  if (status == WHITTLE_OK)
    scene->built = false;
  return status;
}

whittle_status whittle_scene_set_transform(whittle_scene *scene, uint32_t instance,
                                           const double transform[16], whittle_error *error) {
  whittle_status status = whittle_scene_write_begin(scene, error);
  if (status != WHITTLE_OK)
    return status;
  status = set_transform(scene, instance, transform, error);
  whittle_scene_write_end(scene);
  return status;
}

static whittle_status replace_mesh(whittle_scene *scene, uint32_t number,
                                   const whittle_mesh *source, whittle_error *error) {
  if (number >= scene->mesh_count)
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "mesh",
                        "Mesh %u is asked for, but the scene has %zu, counted from 0.", number,
                        scene->mesh_count);
  mesh made;
  const whittle_status status = whittle_mesh_take(&made, source, error);
  if (status != WHITTLE_OK)
    return status;
  mesh *old = &scene->meshes[number];
  made.version = whittle_mesh_same_surface(old, &made) ? old->version : ++scene->mesh_version;
  whittle_mesh_free(old);
  *old = made;
  scene->built = false;
  return WHITTLE_OK;
}

whittle_status whittle_scene_replace_mesh(whittle_scene *scene, uint32_t mesh,
                                          const whittle_mesh *source, whittle_error *error) {
  whittle_status status = whittle_scene_write_begin(scene, error);
  if (status != WHITTLE_OK)
    return status;
  status = replace_mesh(scene, mesh, source, error);
  whittle_scene_write_end(scene);
  return status;
}

static whittle_status remove_instance(whittle_scene *scene, uint32_t number, whittle_error *error) {
  const whittle_status status = check_instance(scene, number, error);
  if (status != WHITTLE_OK)
    return status;
  instance *gone = &scene->instances[number];
  gone->removed = true;
  gone->visibility = WHITTLE_ALL; /* or the others' rays would have to read theirs */
  scene->built = false;
  return WHITTLE_OK;
}

whittle_status whittle_scene_remove_instance(whittle_scene *scene, uint32_t instance,
                                             whittle_error *error) {
  whittle_status status = whittle_scene_write_begin(scene, error);
  if (status != WHITTLE_OK)
    return status;
  status = remove_instance(scene, instance, error);
  whittle_scene_write_end(scene);
  return status;
}
