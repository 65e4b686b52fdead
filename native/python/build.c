/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Scene.build, and copies of the tree that it made. */

#include "arguments.h"
#include "arrays.h"
#include "scene_methods.h"
#include "stats.h"

#include <string.h>

static bool read_options(PyObject *threads, PyObject *bins, PyObject *max_leaf,
                         PyObject *traversal_cost, PyObject *by_instance, PyObject *lean,
                         whittle_build_options *options) {
  return (!threads || argument_uint32(threads, "threads", 0, &options->threads)) &&
         (!bins || argument_uint32(bins, "bins", 0, &options->bins)) &&
         (!max_leaf || argument_uint32(max_leaf, "max_leaf", 0, &options->max_leaf)) &&
         (!traversal_cost ||
          argument_float(traversal_cost, "traversal_cost", &options->traversal_cost)) &&
         (!by_instance || argument_flag(by_instance, "by_instance", &options->by_instance)) &&
         (!lean || argument_flag(lean, "lean", &options->lean));
}

PyObject *scene_build(PyObject *self, PyObject *args, PyObject *kwargs) {
  static char *names[] = {"threads",        "bins",        "on_progress", "max_leaf",
                          "traversal_cost", "by_instance", "lean",        NULL};
  PyObject *threads = NULL, *bins = NULL, *on_progress = NULL;
  PyObject *max_leaf = NULL, *traversal_cost = NULL, *by_instance = NULL, *lean = NULL;
  if (!PyArg_ParseTupleAndKeywords(args, kwargs, "|OOO$OOOO:build", names, &threads, &bins,
                                   &on_progress, &max_leaf, &traversal_cost, &by_instance, &lean))
    return NULL;
  whittle_build_options options = {0};
  progress_call call;
  if (!read_options(threads, bins, max_leaf, traversal_cost, by_instance, lean, &options) ||
      !progress_init(&call, on_progress))
    return NULL;
  whittle_build_stats stats;
  whittle_error error = {0};
  options.progress = progress_begin(&call);
  const whittle_status status = whittle_scene_build(scene_handle(self), &options, &stats, &error);
  if (!progress_end(&call))
    return NULL;
  return status ? raise_status(state_of(self), status, &error)
                : stats_of_build(scene_handle(self), &stats);
}

/* ---- Copies ----
 *
 * Changes start with the GIL held, so between two calls made without giving it up the tree is the
 * same, unless someone is at work on the scene: then the core says that it is busy. */

static bool tree_of(PyObject *self, whittle_tree *tree) {
  whittle_error error = {0};
  const whittle_status status = whittle_scene_tree(scene_handle(self), tree, &error);
  return !status || raise_status(state_of(self), status, &error);
}

static bool unchanged(PyObject *self, const whittle_tree *before) {
  whittle_tree now;
  if (!tree_of(self, &now))
    return false;
  if (now.node_count == before->node_count && now.triangle_count == before->triangle_count)
    return true;
  PyErr_SetString(PyExc_RuntimeError, "the scene was changed meanwhile");
  return false;
}

/* The layout of whittle_node. */
static PyObject *node_dtype(module_state *state) {
  PyObject *numpy = state_numpy(state);
  PyObject *fields = Py_BuildValue("[(ss(i))(ss)(ss(i))(ss)]", "bounds_min", "f4", 3, "left_first",
                                   "u4", "bounds_max", "f4", 3, "count", "u4");
  PyObject *dtype = numpy && fields ? PyObject_CallMethod(numpy, "dtype", "(O)", fields) : NULL;
  Py_XDECREF(fields);
  return dtype;
}

PyObject *scene_nodes(PyObject *self, PyObject *unused) {
  (void)unused;
  module_state *state = state_of(self);
  whittle_tree tree;
  PyObject *dtype = tree_of(self, &tree) ? node_dtype(state) : NULL;
  if (!dtype)
    return NULL;
  array_view view = {0};
  void *data;
  PyObject *array =
      array_new(state, 1, (Py_ssize_t[]){(Py_ssize_t)tree.node_count}, dtype, &view, &data);
  Py_DECREF(dtype);
  whittle_tree now;
  if (array && (!unchanged(self, &tree) || !tree_of(self, &now)))
    Py_CLEAR(array);
  if (array && tree.node_count)
    memcpy(data, now.nodes, tree.node_count * sizeof(whittle_node));
  array_release(&view);
  return array;
}

PyObject *scene_triangles(PyObject *self, PyObject *unused) {
  (void)unused;
  module_state *state = state_of(self);
  whittle_tree tree;
  if (!tree_of(self, &tree))
    return NULL;
  const Py_ssize_t shape[] = {(Py_ssize_t)tree.triangle_count, 3, 3};
  array_view views[3] = {0};
  void *data[3];
  PyObject *vertices = array_new_of(state, 3, shape, "f4", &views[0], &data[0]);
  PyObject *instances = array_new_of(state, 1, shape, "u4", &views[1], &data[1]);
  PyObject *triangles = array_new_of(state, 1, shape, "u4", &views[2], &data[2]);
  PyObject *result = NULL;
  if (vertices && instances && triangles && unchanged(self, &tree)) {
    whittle_error error = {0};
    const whittle_status status =
        whittle_scene_triangles(scene_handle(self), data[0], data[1], data[2], &error);
    result = status ? raise_status(state, status, &error)
                    : Py_BuildValue("{sOsOsO}", "vertices", vertices, "instance", instances,
                                    "triangle", triangles);
  }
  for (int i = 0; i < 3; i++)
    array_release(&views[i]);
  Py_XDECREF(vertices);
  Py_XDECREF(instances);
  Py_XDECREF(triangles);
  return result;
}
