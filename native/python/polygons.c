/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The function triangulate. */

#include "arguments.h"
#include "arrays.h"

typedef struct polygon_arrays {
  array_view positions, corners, faces;
  void *owned[3];
  whittle_polygons polygons;
} polygon_arrays;

static void release_arrays(polygon_arrays *arrays) {
  array_release(&arrays->positions);
  array_release(&arrays->corners);
  array_release(&arrays->faces);
  for (int i = 0; i < 3; i++)
    PyMem_Free(arrays->owned[i]);
}

static bool read_arrays(module_state *state, PyObject *positions, PyObject *corners,
                        PyObject *faces, polygon_arrays *arrays) {
  const Py_ssize_t any[] = {-1}, points[] = {-1, 3};
  if (!array_read(state, positions, "positions", ARRAY_REAL, &arrays->positions) ||
      !array_check_shape(&arrays->positions, "positions", "(n, 3)", 2, points) ||
      !array_read(state, corners, "corners", ARRAY_WHOLE, &arrays->corners) ||
      !array_check_shape(&arrays->corners, "corners", "(k,)", 1, any) ||
      !array_read(state, faces, "faces", ARRAY_WHOLE, &arrays->faces) ||
      !array_check_shape(&arrays->faces, "faces", "(m,)", 1, any))
    return false;
  whittle_polygons *polygons = &arrays->polygons;
  polygons->vertex_count = (size_t)arrays->positions.buffer.shape[0];
  polygons->corner_count = (size_t)arrays->corners.buffer.shape[0];
  polygons->triangle_count = (size_t)arrays->faces.buffer.shape[0];
  return (polygons->positions = array_floats(&arrays->positions, &arrays->owned[0])) &&
         (polygons->corners = array_uints(&arrays->corners, "corners", &arrays->owned[1])) &&
         (polygons->faces = array_uints(&arrays->faces, "faces", &arrays->owned[2]));
}

static PyObject *triangles_of(module_state *state, const whittle_polygons *polygons,
                              int by_corner) {
  const Py_ssize_t shape[] = {(Py_ssize_t)polygons->triangle_count, 3};
  array_view view = {0};
  void *data = NULL;
  PyObject *triangles = array_new_of(state, 2, shape, "u4", &view, &data);
  if (!triangles)
    return NULL;
  size_t open = 0;
  whittle_error error = {0};
  whittle_status status;
  Py_BEGIN_ALLOW_THREADS status = whittle_triangulate(polygons, by_corner, data, &open, &error);
  Py_END_ALLOW_THREADS array_release(&view);
  if (status == WHITTLE_OK)
    return Py_BuildValue("Nn", triangles, (Py_ssize_t)open);
  Py_DECREF(triangles);
  return raise_status(state, status, &error);
}

PyObject *module_triangulate(PyObject *module, PyObject *args, PyObject *kwargs) {
  static char *names[] = {"positions", "corners", "faces", "by_corner", NULL};
  PyObject *positions, *corners, *faces, *by_corner = NULL;
  int corner = 0;
  if (!PyArg_ParseTupleAndKeywords(args, kwargs, "OOO|$O:triangulate", names, &positions, &corners,
                                   &faces, &by_corner) ||
      (by_corner && !argument_flag(by_corner, "by_corner", &corner)))
    return NULL;
  module_state *state = PyModule_GetState(module);
  polygon_arrays arrays = {0};
  PyObject *result = NULL;
  if (read_arrays(state, positions, corners, faces, &arrays))
    result = triangles_of(state, &arrays.polygons, corner);
  release_arrays(&arrays);
  return result;
}
