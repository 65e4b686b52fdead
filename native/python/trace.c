/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Scene.intersect, Scene.occluded and Scene.reference_intersect. */

#include "arguments.h"
#include "arrays.h"
#include "scene_methods.h"

#include <stddef.h>

/* ---- Rays in ---- */

typedef struct ray_arrays {
  array_view origins, directions, t_min, t_max;
  whittle_rays rays;
  whittle_trace_options options;
} ray_arrays;

/* The arguments as they came; NULL where one was left out. */
typedef struct ray_arguments {
  PyObject *origins, *directions, *t_min, *t_max, *threads, *packet, *visibility, *counters;
} ray_arguments;

static void release_rays(ray_arrays *arrays) {
  array_release(&arrays->origins);
  array_release(&arrays->directions);
  array_release(&arrays->t_min);
  array_release(&arrays->t_max);
}

static bool read_vectors(module_state *state, PyObject *object, const char *name, Py_ssize_t count,
                         array_view *view, whittle_array *array) {
  char text[32] = "(k, 3)";
  if (count >= 0)
    PyOS_snprintf(text, sizeof text, "(%lld, 3)", (long long)count);
  const bool good = array_read(state, object, name, ARRAY_REAL, view) &&
                    array_check_shape(view, name, text, 2, (Py_ssize_t[]){count, 3});
  if (good)
    *array = array_strided(view);
  return good;
}

static bool read_limit(module_state *state, PyObject *object, const char *name, Py_ssize_t count,
                       array_view *view, whittle_array *array) {
  if (!object)
    return true;
  char text[48];
  PyOS_snprintf(text, sizeof text, "() or (%lld,)", (long long)count);
  if (!array_read(state, object, name, ARRAY_REAL, view) ||
      !(array_has_shape(view, 0, NULL) ||
        array_check_shape(view, name, text, 1, (Py_ssize_t[]){count})))
    return false;
  *array = array_strided(view);
  return true;
}

static bool read_rays(module_state *state, const ray_arguments *from, ray_arrays *to) {
  whittle_rays *rays = &to->rays;
  if (!read_vectors(state, from->origins, "origins", -1, &to->origins, &rays->origins))
    return false;
  const Py_ssize_t count = to->origins.buffer.shape[0];
  rays->count = (size_t)count;
  whittle_trace_options *options = &to->options;
  return read_vectors(state, from->directions, "directions", count, &to->directions,
                      &rays->directions) &&
         read_limit(state, from->t_min, "t_min", count, &to->t_min, &rays->t_min) &&
         read_limit(state, from->t_max, "t_max", count, &to->t_max, &rays->t_max) &&
         (!from->threads || argument_uint32(from->threads, "threads", 0, &options->threads)) &&
         (!from->packet || argument_uint32(from->packet, "packet", 0, &options->packet)) &&
         (!from->visibility ||
          argument_uint32(from->visibility, "visibility", 1, &rays->visibility));
}

/* ---- Hits out ---- */

static const struct column {
  const char *name, *dtype;
  size_t offset;
} columns[] = {
    {"t", "f4", offsetof(whittle_hits, t)},
    {"instance", "i4", offsetof(whittle_hits, instance)},
    {"triangle", "i4", offsetof(whittle_hits, triangle)},
    {"u", "f4", offsetof(whittle_hits, u)},
    {"v", "f4", offsetof(whittle_hits, v)},
    {"nodes", "u4", offsetof(whittle_hits, nodes)},
    {"triangles", "u4", offsetof(whittle_hits, triangles)},
};
enum { ALL_COLUMNS = sizeof columns / sizeof columns[0], HIT_COLUMNS = 5 };

/* A dict of new arrays, whose memory `hits` then points to while the views are held. */
static PyObject *new_hits(module_state *state, Py_ssize_t count, int width, whittle_hits *hits,
                          array_view *views) {
  PyObject *dict = PyDict_New();
  for (int i = 0; dict && i < width; i++) {
    void **to = (void **)((char *)hits + columns[i].offset);
    PyObject *array = array_new_of(state, 1, &count, columns[i].dtype, &views[i], to);
    if (!array || PyDict_SetItemString(dict, columns[i].name, array) < 0)
      Py_CLEAR(dict);
    Py_XDECREF(array);
  }
  return dict;
}

/* whittle_intersect or whittle_reference_intersect. */
typedef whittle_status nearest(const whittle_scene *scene, const whittle_rays *rays,
                               const whittle_hits *hits, const whittle_trace_options *options,
                               whittle_error *error);

static PyObject *trace_nearest(PyObject *self, const ray_arguments *arguments, nearest *trace) {
  module_state *state = state_of(self);
  ray_arrays arrays = {0};
  array_view views[ALL_COLUMNS] = {0};
  int counters = 0;
  PyObject *dict = NULL;
  if (read_rays(state, arguments, &arrays) &&
      (!arguments->counters || argument_flag(arguments->counters, "counters", &counters))) {
    whittle_hits hits = {0};
    dict = new_hits(state, (Py_ssize_t)arrays.rays.count, counters ? ALL_COLUMNS : HIT_COLUMNS,
                    &hits, views);
    whittle_status status = WHITTLE_OK;
    whittle_error error = {0};
    if (dict) {
      Py_BEGIN_ALLOW_THREADS status =
          trace(scene_handle(self), &arrays.rays, &hits, &arrays.options, &error);
      Py_END_ALLOW_THREADS
    }
    if (status) {
      Py_CLEAR(dict);
      raise_status(state, status, &error);
    }
  }
  for (int i = 0; i < ALL_COLUMNS; i++)
    array_release(&views[i]);
  release_rays(&arrays);
  return dict;
}

PyObject *scene_intersect(PyObject *self, PyObject *args, PyObject *kwargs) {
  static char *names[] = {"origins", "directions", "t_min",    "t_max", "threads",
                          "packet",  "visibility", "counters", NULL};
  ray_arguments from = {0};
  if (!PyArg_ParseTupleAndKeywords(args, kwargs, "OO|OOO$OOO:intersect", names, &from.origins,
                                   &from.directions, &from.t_min, &from.t_max, &from.threads,
                                   &from.packet, &from.visibility, &from.counters))
    return NULL;
  return trace_nearest(self, &from, whittle_intersect);
}

PyObject *scene_reference_intersect(PyObject *self, PyObject *args, PyObject *kwargs) {
  static char *names[] = {"origins", "directions", "t_min", "t_max", "threads", "visibility", NULL};
  ray_arguments from = {0};
  if (!PyArg_ParseTupleAndKeywords(args, kwargs, "OO|OOO$O:reference_intersect", names,
                                   &from.origins, &from.directions, &from.t_min, &from.t_max,
                                   &from.threads, &from.visibility))
    return NULL;
  return trace_nearest(self, &from, whittle_reference_intersect);
}

static PyObject *trace_any(PyObject *self, const ray_arguments *from) {
  module_state *state = state_of(self);
  ray_arrays arrays = {0};
  array_view view = {0};
  PyObject *blocked = NULL;
  if (read_rays(state, from, &arrays)) {
    void *data;
    const Py_ssize_t count = (Py_ssize_t)arrays.rays.count;
    blocked = array_new_of(state, 1, &count, "?", &view, &data);
    whittle_status status = WHITTLE_OK;
    whittle_error error = {0};
    if (blocked) {
      Py_BEGIN_ALLOW_THREADS status =
          whittle_occluded(scene_handle(self), &arrays.rays, data, &arrays.options, &error);
      Py_END_ALLOW_THREADS
    }
    if (status) {
      Py_CLEAR(blocked);
      raise_status(state, status, &error);
    }
  }
  array_release(&view);
  release_rays(&arrays);
  return blocked;
}

PyObject *scene_occluded(PyObject *self, PyObject *args, PyObject *kwargs) {
  static char *names[] = {"origins", "directions", "t_min",      "t_max",
                          "threads", "packet",     "visibility", NULL};
  ray_arguments from = {0};
  if (!PyArg_ParseTupleAndKeywords(args, kwargs, "OO|OOO$OO:occluded", names, &from.origins,
                                   &from.directions, &from.t_min, &from.t_max, &from.threads,
                                   &from.packet, &from.visibility))
    return NULL;
  return trace_any(self, &from);
}
