/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The methods of Scene, which its type's table gathers from several files. */

#pragma once

#include "module.h"

typedef PyObject *scene_method(PyObject *self, PyObject *args, PyObject *kwargs);

/* geometry.c */
scene_method scene_add_mesh, scene_replace_mesh, scene_add_instance;
/* edit.c */
scene_method scene_set_transform, scene_remove_instance;
/* appearance.c */
scene_method scene_set_materials, scene_set_lights, scene_set_world;
/* build.c */
scene_method scene_build;
PyObject *scene_nodes(PyObject *self, PyObject *unused);
PyObject *scene_triangles(PyObject *self, PyObject *unused);
/* quality.c */
scene_method scene_quality;
/* cost.c */
PyObject *scene_owners(PyObject *self, PyObject *unused);
/* probe.c */
scene_method scene_probe;
/* trace.c */
scene_method scene_intersect, scene_occluded, scene_reference_intersect;
/* render.c */
scene_method scene_render, scene_start;
