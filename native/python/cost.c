/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Scene.owners, and the tables of a render's cost. */

#include "cost.h"

#include "scene_methods.h"

/* {"nodes": array, "triangles": array}, each with a row for each kind of ray. */
static PyObject *pair_of_tables(module_state *state, size_t columns, array_view views[2],
                                uint64_t **nodes, uint64_t **triangles) {
  const Py_ssize_t shape[] = {WHITTLE_RAY_KINDS, (Py_ssize_t)columns + 1};
  void *data[2] = {NULL, NULL};
  PyObject *first = array_new_of(state, 2, shape, "u8", &views[0], &data[0]);
  PyObject *second = first ? array_new_of(state, 2, shape, "u8", &views[1], &data[1]) : NULL;
  *nodes = data[0], *triangles = data[1];
  PyObject *pair = second ? Py_BuildValue("{sOsO}", "nodes", first, "triangles", second) : NULL;
  Py_XDECREF(first);
  Py_XDECREF(second);
  return pair;
}

PyObject *cost_tables_new(module_state *state, const whittle_scene *scene, cost_tables *tables) {
  whittle_cost *cost = &tables->cost;
  whittle_error error = {0};
  const whittle_status status =
      whittle_scene_columns(scene, &cost->instances, &cost->materials, &error);
  if (status)
    return raise_status(state, status, &error);
  PyObject *instance = pair_of_tables(state, cost->instances, tables->views, &cost->instance_nodes,
                                      &cost->instance_triangles);
  PyObject *material = pair_of_tables(state, cost->materials, tables->views + 2,
                                      &cost->material_nodes, &cost->material_triangles);
  PyObject *dict = instance && material
                       ? Py_BuildValue("{sOsO}", "instance", instance, "material", material)
                       : NULL;
  Py_XDECREF(instance);
  Py_XDECREF(material);
  return dict;
}

void cost_tables_release(cost_tables *tables) {
  for (int i = 0; i < 4; i++)
    array_release(&tables->views[i]);
}

/* Columns are counted with the GIL held, as in build.c, so that the tree stays the same. */
PyObject *scene_owners(PyObject *self, PyObject *unused) {
  (void)unused;
  module_state *state = state_of(self);
  const whittle_scene *scene = scene_handle(self);
  whittle_tree tree, now;
  whittle_error error = {0};
  whittle_status status = whittle_scene_tree(scene, &tree, &error);
  if (status)
    return raise_status(state, status, &error);
  const Py_ssize_t count = (Py_ssize_t)tree.node_count;
  array_view views[2] = {0};
  void *data[2];
  PyObject *instance = array_new_of(state, 1, &count, "i4", &views[0], &data[0]);
  PyObject *material = instance ? array_new_of(state, 1, &count, "i4", &views[1], &data[1]) : NULL;
  PyObject *dict = NULL;
  if (material) {
    status = whittle_scene_tree(scene, &now, &error);
    if (!status && now.node_count != tree.node_count)
      PyErr_SetString(PyExc_RuntimeError, "the scene was changed meanwhile");
    else if (!status)
      status = whittle_scene_owners(scene, data[0], data[1], &error);
    if (status)
      raise_status(state, status, &error);
    else if (!PyErr_Occurred())
      dict = Py_BuildValue("{sOsO}", "instance", instance, "material", material);
  }
  for (int i = 0; i < 2; i++)
    array_release(&views[i]);
  Py_XDECREF(instance);
  Py_XDECREF(material);
  return dict;
}
