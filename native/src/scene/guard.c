/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Who may use a scene now: one that changes it, or any number that trace it. */

#include "scene/scene.h"

whittle_status whittle_scene_read_begin(const whittle_scene *scene, whittle_error *error) {
  /* Readers count themselves: the one thing that tracing changes in a scene. */
  atomic_int *users = &((whittle_scene *)scene)->users;
  int before = atomic_load(users);
  do {
    if (before < 0)
      return whittle_fail(error, WHITTLE_BUSY, "scene",
                          "The scene is being changed or built; trace it when that has ended.");
  } while (!atomic_compare_exchange_weak(users, &before, before + 1));
  if (scene->built)
    return WHITTLE_OK;
  whittle_scene_read_end(scene);
  return whittle_fail(error, WHITTLE_NOT_BUILT, "scene",
                      "The scene has changed since it was last built; build it first.");
}

whittle_status whittle_scene_has_binary(const whittle_scene *scene, const char *what,
                                        whittle_error *error) {
  if (!scene->options.lean)
    return WHITTLE_OK;
  return whittle_fail(error, WHITTLE_NOT_BUILT, "lean",
                      "%s not to be had after a lean build, which leaves out the binary tree: "
                      "build the scene without lean.",
                      what);
}

void whittle_scene_read_end(const whittle_scene *scene) {
  atomic_fetch_sub(&((whittle_scene *)scene)->users, 1);
}

whittle_status whittle_scene_write_begin(whittle_scene *scene, whittle_error *error) {
  int idle = 0;
  if (atomic_compare_exchange_strong(&scene->users, &idle, -1))
    return WHITTLE_OK;
  return whittle_fail(error, WHITTLE_BUSY, "scene",
                      "The scene is being traced, rendered or built; change it when that has "
                      "ended.");
}

void whittle_scene_write_end(whittle_scene *scene) {
  atomic_store(&scene->users, 0);
}
