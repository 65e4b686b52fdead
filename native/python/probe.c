/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Scene.probe: the rays of one pixel as dicts. */

#include "arguments.h"
#include "request.h"
#include "scene_methods.h"
#include "stats.h"

#include <math.h>
#include <string.h>

/* A new array with a copy of `count` elements. */
static PyObject *copied(module_state *state, size_t count, const char *dtype, size_t size,
                        const void *from) {
  array_view view = {0};
  void *data;
  PyObject *array = array_new_of(state, 1, (Py_ssize_t[]){(Py_ssize_t)count}, dtype, &view, &data);
  if (array && count)
    memcpy(data, from, count * size);
  array_release(&view);
  return array;
}

/* In world units, from the origin to the hit. */
static double distance(const whittle_probe_ray *ray) {
  const double *d = ray->direction;
  return isinf(ray->t) ? INFINITY : ray->t * sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

static PyObject *ray_dict(module_state *state, const whittle_probe_ray *ray) {
  PyObject *origin = copied(state, 3, "f8", sizeof(double), ray->origin);
  PyObject *direction = copied(state, 3, "f8", sizeof(double), ray->direction);
  PyObject *nodes = copied(state, ray->node_count, "u4", sizeof(uint32_t), ray->nodes);
  PyObject *triangles = copied(state, ray->triangle_count, "u4", sizeof(uint32_t), ray->triangles);
  PyObject *dict = NULL;
  if (origin && direction && nodes && triangles)
    dict = Py_BuildValue("{sssIsIsLsLsOsOsdsdsdsdsisisisdsdsOsO}", "kind", ray_kinds[ray->kind],
                         "sample", (unsigned)ray->sample, "depth", (unsigned)ray->depth, "parent",
                         (long long)ray->parent, "light", (long long)ray->light, "origin", origin,
                         "direction", direction, "t_min", (double)ray->t_min, "t_max",
                         (double)ray->t_max, "t", (double)ray->t, "distance", distance(ray),
                         "instance", (int)ray->instance, "triangle", (int)ray->triangle, "material",
                         (int)ray->material, "u", (double)ray->u, "v", (double)ray->v, "nodes",
                         nodes, "triangles", triangles);
  Py_XDECREF(origin);
  Py_XDECREF(direction);
  Py_XDECREF(nodes);
  Py_XDECREF(triangles);
  return dict;
}

static PyObject *rays_list(module_state *state, const whittle_probe *probe) {
  PyObject *list = PyList_New(0);
  for (size_t i = 0; list && i < probe->count; i++) {
    PyObject *dict = ray_dict(state, &probe->rays[i]);
    if (!dict || PyList_Append(list, dict) < 0)
      Py_CLEAR(list);
    Py_XDECREF(dict);
  }
  return list;
}

static PyObject *probe_pixel(PyObject *self, const render_request *request, uint32_t x,
                             uint32_t y) {
  module_state *state = state_of(self);
  whittle_scene *scene = scene_handle(self);
  whittle_probe *probe = NULL;
  whittle_error error = {0};
  whittle_status status;
  Py_BEGIN_ALLOW_THREADS status =
      whittle_probe_pixel(scene, &request->camera, &request->settings, x, y, &probe, &error);
  Py_END_ALLOW_THREADS

      PyObject *list = status ? raise_status(state, status, &error) : rays_list(state, probe);
  whittle_probe_release(probe);
  return list;
}

PyObject *scene_probe(PyObject *self, PyObject *args, PyObject *kwargs) {
  static char *names[] = {"camera", "settings", "x", "y", NULL};
  PyObject *camera, *settings, *x, *y;
  if (!PyArg_ParseTupleAndKeywords(args, kwargs, "OOOO:probe", names, &camera, &settings, &x, &y))
    return NULL;
  module_state *state = state_of(self);
  render_request request;
  uint32_t column, row;
  if (!request_read(state, camera, settings, &request) || !argument_uint32(x, "x", 0, &column) ||
      !argument_uint32(y, "y", 0, &row))
    return NULL;
  return probe_pixel(self, &request, column, row);
}
