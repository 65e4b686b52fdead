/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Scene.set_transform and Scene.remove_instance. */

#include "arguments.h"
#include "arrays.h"
#include "scene_methods.h"

static PyObject *none_or_raise(PyObject *self, whittle_status status, const whittle_error *error) {
  return status ? raise_status(state_of(self), status, error) : Py_BuildValue("");
}

PyObject *scene_set_transform(PyObject *self, PyObject *args, PyObject *kwargs) {
  static char *names[] = {"instance", "transform", NULL};
  PyObject *number, *matrix;
  uint32_t instance;
  double transform[16];
  if (!PyArg_ParseTupleAndKeywords(args, kwargs, "OO:set_transform", names, &number, &matrix) ||
      !argument_uint32(number, "instance", 0, &instance) ||
      !array_matrix(state_of(self), matrix, "transform", transform))
    return NULL;
  whittle_error error = {0};
  return none_or_raise(
      self, whittle_scene_set_transform(scene_handle(self), instance, transform, &error), &error);
}

PyObject *scene_remove_instance(PyObject *self, PyObject *args, PyObject *kwargs) {
  static char *names[] = {"instance", NULL};
  PyObject *number;
  uint32_t instance;
  if (!PyArg_ParseTupleAndKeywords(args, kwargs, "O:remove_instance", names, &number) ||
      !argument_uint32(number, "instance", 0, &instance))
    return NULL;
  whittle_error error = {0};
  return none_or_raise(self, whittle_scene_remove_instance(scene_handle(self), instance, &error),
                       &error);
}
