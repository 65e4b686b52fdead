/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Scene.render and Scene.start. */

#include "request.h"
#include "scene_methods.h"
#include "stats.h"

/* The dict that render gives: the images and `stats`; new reference. */
static PyObject *rendered(render_images *images, const whittle_render_stats *stats) {
  PyObject *measured = stats_of_render(stats);
  PyObject *result = NULL;
  if (measured && PyDict_SetItemString(images->dict, "stats", measured) == 0)
    result = Py_NewRef(images->dict);
  Py_XDECREF(measured);
  return result;
}

static PyObject *run(PyObject *self, render_request *request, progress_call *call,
                     render_images *images) {
  whittle_render_stats stats;
  whittle_error error = {0};
  request->settings.progress = progress_begin(call);
  const whittle_status status = whittle_render(scene_handle(self), &request->camera,
                                               &request->settings, &images->image, &stats, &error);
  if (!progress_end(call))
    return NULL;
  return status ? raise_status(state_of(self), status, &error) : rendered(images, &stats);
}

PyObject *scene_render(PyObject *self, PyObject *args, PyObject *kwargs) {
  static char *names[] = {"camera", "settings", "on_progress", NULL};
  PyObject *camera, *settings = NULL, *on_progress = NULL;
  if (!PyArg_ParseTupleAndKeywords(args, kwargs, "O|OO:render", names, &camera, &settings,
                                   &on_progress))
    return NULL;
  module_state *state = state_of(self);
  render_request request;
  progress_call call;
  if (!request_read(state, camera, settings, &request) || !progress_init(&call, on_progress))
    return NULL;
  render_images images;
  PyObject *result = images_new(state, scene_handle(self), &request, &images)
                         ? run(self, &request, &call, &images)
                         : NULL;
  images_release(&images);
  return result;
}

PyObject *scene_start(PyObject *self, PyObject *args, PyObject *kwargs) {
  static char *names[] = {"camera", "settings", NULL};
  PyObject *camera, *settings = NULL;
  if (!PyArg_ParseTupleAndKeywords(args, kwargs, "O|O:start", names, &camera, &settings))
    return NULL;
  return job_start(self, camera, settings);
}
