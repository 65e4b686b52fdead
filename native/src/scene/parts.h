/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The built scene as its judges read it, and the triangles of one label at a time. */

#pragma once

#include "bvh/quality.h"
#include "scene/scene.h"

/* A copy of what the judges need, laid out for them alone. */
typedef struct judged_scene {
  const whittle_scene *scene;
  whittle_judged tree;
  float *vertices;
  uint32_t *instances, *materials; /* labels of each triangle */
  uint32_t *owners;                /* by node: the one instance of its triangles */
} judged_scene;

whittle_status whittle_judged_begin(const whittle_scene *scene, judged_scene *judged,
                                    whittle_error *error);
void whittle_judged_free(judged_scene *judged);

/* Everything about parts that takes no trees of their own. */
whittle_status whittle_judge_parts(const judged_scene *judged, whittle_quality *quality,
                                   whittle_error *error);
