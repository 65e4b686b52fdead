/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Scene.quality: the numbers of whittle_quality as a dict, an array for each number of the parts.
 */

#include "arguments.h"
#include "arrays.h"
#include "scene_methods.h"

#include <stddef.h>
#include <string.h>

/* A number of every part: eight bytes, or three times that. */
typedef struct part_field {
  const char *name;
  size_t offset;
  const char *dtype;
  int width;
  char when; /* always; o: with overlap; i: by_instance */
} part_field;

static const part_field part_fields[] = {
#define F(name, dtype, width, when)                                                                \
  {#name, offsetof(whittle_part_quality, name), dtype, width, when}
    F(triangles, "u8", 1, 0),
    F(slivers, "u8", 1, 0),
    F(nodes, "u8", 1, 0),
    F(bytes, "u8", 1, 0),
    F(area, "f8", 1, 0),
    F(box_fill, "f8", 1, 0),
    F(largest_triangle_share, "f8", 1, 0),
    F(box_min, "f8", 3, 0),
    F(box_max, "f8", 3, 0),
    F(stretch, "f8", 1, 0),
    F(overlap_part, "f8", 1, 'o'),
    F(sah_cost, "f8", 1, 'i'),
    F(overlap, "f8", 1, 'i'),
    F(stray_share, "f8", 1, 'i'),
    F(stray_triangles, "u8", 1, 'i'),
    {0},
#undef F
};

static PyObject *column(module_state *state, const whittle_part_quality *parts, size_t count,
                        const part_field *field) {
  const Py_ssize_t shape[] = {(Py_ssize_t)count, 3};
  const size_t bytes = 8 * (size_t)field->width;
  array_view view = {0};
  void *data;
  PyObject *array =
      array_new_of(state, field->width == 1 ? 1 : 2, shape, field->dtype, &view, &data);
  for (size_t i = 0; array && i < count; i++)
    memcpy((char *)data + i * bytes, (const char *)&parts[i] + field->offset, bytes);
  array_release(&view);
  return array;
}

static bool put(PyObject *dict, const char *key, PyObject *value) {
  const bool good = value && PyDict_SetItemString(dict, key, value) == 0;
  Py_XDECREF(value);
  return good;
}

/* A dict with an array for each field whose time `when` names. */
static PyObject *parts_dict(module_state *state, const whittle_part_quality *parts, size_t count,
                            const char *when) {
  PyObject *dict = PyDict_New();
  bool good = dict != NULL;
  for (const part_field *f = part_fields; good && f->name; f++)
    if (!f->when || strchr(when, f->when))
      good = put(dict, f->name, column(state, parts, count, f));
  if (!good)
    Py_CLEAR(dict);
  return dict;
}

static PyObject *histogram(module_state *state, const uint64_t *counts, size_t highest) {
  const Py_ssize_t shape[] = {(Py_ssize_t)highest + 1};
  array_view view = {0};
  void *data;
  PyObject *array = array_new_of(state, 1, shape, "u8", &view, &data);
  if (array)
    memcpy(data, counts, (highest + 1) * sizeof *counts);
  array_release(&view);
  return array;
}

static PyObject *summary(const whittle_quality *q) {
  return Py_BuildValue("{sKsKsKsKsKsIsIsdsdsd}", "triangles", (unsigned long long)q->triangles,
                       "slivers", (unsigned long long)q->slivers, "nodes",
                       (unsigned long long)q->nodes, "leaves", (unsigned long long)q->leaves,
                       "bytes", (unsigned long long)q->bytes, "depth", q->depth, "largest_leaf",
                       q->largest_leaf, "sah_cost", q->sah_cost, "box_fill", q->box_fill, "seconds",
                       q->seconds);
}

static PyObject *quality_dict(module_state *state, const whittle_quality *q,
                              const whittle_quality_options *options) {
  const char *of_instances =
      options->by_instance ? (options->overlap ? "io" : "i") : (options->overlap ? "o" : "");
  const char *of_materials = options->overlap ? "o" : "";
  PyObject *dict = summary(q);
  if (dict && put(dict, "depth_histogram", histogram(state, q->depth_histogram, q->depth)) &&
      put(dict, "leaf_size_histogram", histogram(state, q->leaf_size_histogram, q->largest_leaf)) &&
      put(dict, "instance", parts_dict(state, q->instances, q->instance_count, of_instances)) &&
      put(dict, "material", parts_dict(state, q->materials, q->material_count, of_materials)) &&
      (!options->overlap ||
       (put(dict, "overlap", PyFloat_FromDouble(q->overlap)) &&
        put(dict, "overlap_samples", PyLong_FromUnsignedLongLong(q->overlap_samples)))))
    return dict;
  Py_XDECREF(dict);
  return NULL;
}

static bool read_options(PyObject *overlap, PyObject *by_instance, PyObject *threads,
                         PyObject *samples, whittle_quality_options *options) {
  uint32_t count = 0;
  if ((overlap && !argument_flag(overlap, "overlap", &options->overlap)) ||
      (by_instance && !argument_flag(by_instance, "by_instance", &options->by_instance)) ||
      (threads && !argument_uint32(threads, "threads", 0, &options->threads)) ||
      (samples && !argument_uint32(samples, "overlap_samples", 0, &count)))
    return false;
  options->overlap_samples = count;
  return true;
}

PyObject *scene_quality(PyObject *self, PyObject *args, PyObject *kwargs) {
  static char *names[] = {"overlap", "by_instance",     "on_progress",
                          "threads", "overlap_samples", NULL};
  PyObject *overlap = NULL, *by_instance = NULL, *on_progress = NULL;
  PyObject *threads = NULL, *samples = NULL;
  if (!PyArg_ParseTupleAndKeywords(args, kwargs, "|OOO$OO:quality", names, &overlap, &by_instance,
                                   &on_progress, &threads, &samples))
    return NULL;
  whittle_quality_options options = {0};
  progress_call call;
  if (!read_options(overlap, by_instance, threads, samples, &options) ||
      !progress_init(&call, on_progress))
    return NULL;
  whittle_quality quality = {0};
  whittle_error error = {0};
  options.progress = progress_begin(&call);
  const whittle_status status =
      whittle_scene_quality(scene_handle(self), &options, &quality, &error);
  if (!progress_end(&call)) {
    whittle_quality_free(&quality);
    return NULL;
  }
  if (status)
    return raise_status(state_of(self), status, &error);
  PyObject *dict = quality_dict(state_of(self), &quality, &options);
  whittle_quality_free(&quality);
  return dict;
}
