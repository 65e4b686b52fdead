/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What Scene.render and Scene.start are asked for, and the images that will hold it. */

#pragma once

#include "cost.h"

typedef struct render_request {
  whittle_camera camera;
  whittle_settings settings;
  whittle_pass passes[WHITTLE_PASS_COUNT]; /* in the order of the result */
  int pass_count;
  int cost; /* whether the cost is wanted */
} render_request;

/* Reads camera and settings (NULL or None: all defaults); false and ValueError naming the key. */
bool request_read(module_state *state, PyObject *camera, PyObject *settings,
                  render_request *request);

typedef struct render_images {
  whittle_image image;
  array_view views[WHITTLE_PASS_COUNT];
  cost_tables tables;
  PyObject *dict; /* name -> array */
} render_images;

/* New arrays for the passes of a request, and for the cost if that is wanted of `scene`; held until
 * images_release, which may follow a failure. They stay where they are: the image points to them.
 */
bool images_new(module_state *state, const whittle_scene *scene, const render_request *request,
                render_images *images);
void images_release(render_images *images);

/* Lets go of the arrays, which the dict keeps. */
void images_unhold(render_images *images);
