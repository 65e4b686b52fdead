/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What the core measured, as Python dicts. */

#include "stats.h"

#include <stddef.h>

/* The numbers of a struct by name. */
typedef struct field {
  const char *name;
  size_t offset;
  char type; /* I uint32, i int32, b int32 as bool, Q uint64, d double; k: a dict of uint64 by kind
                of ray */
} field;

static const field build_fields[] = {
#define F(name, type) {#name, offsetof(whittle_build_stats, name), type}
    F(triangles, 'Q'),
    F(dropped_non_finite, 'Q'),
    F(dropped_zero_area, 'Q'),
    F(meshes, 'I'),
    F(instances, 'I'),
    F(nodes, 'I'),
    F(leaves, 'I'),
    F(depth, 'I'),
    F(largest_leaf, 'I'),
    F(threads, 'I'),
    F(bins, 'I'),
    F(sah_cost, 'd'),
    F(bytes, 'Q'),
    F(bytes_nodes, 'Q'),
    F(bytes_triangles, 'Q'),
    F(bytes_meshes, 'Q'),
    F(bytes_binary, 'Q'),
    F(seconds, 'd'),
    F(seconds_flatten, 'd'),
    F(seconds_tree, 'd'),
    F(exponent, 'i'),
    F(subtrees, 'I'),
    F(subtrees_built, 'I'),
    F(frame_changed, 'b'),
    F(seconds_join, 'd'),
    {0},
#undef F
};

static const field render_fields[] = {
#define F(name, type) {#name, offsetof(whittle_render_stats, name), type}
    F(rays, 'k'),
    F(nodes, 'k'),
    F(triangles, 'k'),
    F(shadow_rays_left_out, 'Q'),
    F(secondary_rays_left_out, 'Q'),
    F(dropped_weight, 'd'),
    F(own_box_misses, 'Q'),
    F(packets, 'Q'),
    F(packet_nodes, 'Q'),
    F(packet_rays, 'Q'),
    F(decided_first, 'Q'),
    F(decided_frustum, 'Q'),
    F(decided_brute_force, 'Q'),
    F(active_rays, 'Q'),
    F(visited_rays, 'Q'),
    F(node_lanes, 'Q'),
    F(node_lanes_used, 'Q'),
    F(triangle_lanes, 'Q'),
    F(triangle_lanes_used, 'Q'),
    F(seconds, 'd'),
    F(seconds_primary, 'd'),
    F(seconds_shadow, 'd'),
    F(seconds_secondary, 'd'),
    F(seconds_shade, 'd'),
    F(threads, 'I'),
    F(lanes, 'I'),
    F(bytes, 'Q'),
    {0},
#undef F
};

const char *const ray_kinds[WHITTLE_RAY_KINDS] = {"primary", "shadow", "reflection", "refraction"};

/* Puts a new reference into a dict and gives it up; false if there was none or it fails. */
static bool put(PyObject *dict, const char *key, PyObject *value) {
  const bool good = value && PyDict_SetItemString(dict, key, value) == 0;
  Py_XDECREF(value);
  return good;
}

static PyObject *by_kind(const uint64_t counts[WHITTLE_RAY_KINDS]) {
  PyObject *dict = PyDict_New();
  bool good = dict != NULL;
  for (int kind = 0; good && kind < WHITTLE_RAY_KINDS; kind++)
    good = put(dict, ray_kinds[kind], PyLong_FromUnsignedLongLong(counts[kind]));
  if (!good)
    Py_CLEAR(dict);
  return dict;
}

static PyObject *field_value(const char *from, char type) {
  switch (type) {
  case 'I':
    return PyLong_FromUnsignedLong(*(const uint32_t *)from);
  case 'i':
    return PyLong_FromLong(*(const int32_t *)from);
  case 'b':
    return PyBool_FromLong(*(const int32_t *)from);
  case 'Q':
    return PyLong_FromUnsignedLongLong(*(const uint64_t *)from);
  case 'd':
    return PyFloat_FromDouble(*(const double *)from);
  default:
    return by_kind((const uint64_t *)from);
  }
}

static PyObject *dict_of(const void *from, const field *fields) {
  PyObject *dict = PyDict_New();
  bool good = dict != NULL;
  for (const field *f = fields; good && f->name; f++)
    good = put(dict, f->name, field_value((const char *)from + f->offset, f->type));
  if (!good)
    Py_CLEAR(dict);
  return dict;
}

/* ---- Build ---- */

static PyObject *dropped_meshes(const whittle_scene *scene, uint32_t meshes) {
  PyObject *list = PyList_New(0);
  for (uint32_t mesh = 0; list && mesh < meshes; mesh++) {
    uint64_t non_finite = 0, zero_area = 0;
    if (whittle_scene_dropped(scene, mesh, &non_finite, &zero_area, NULL) ||
        (!non_finite && !zero_area))
      continue;
    PyObject *entry =
        Py_BuildValue("{sIsKsK}", "mesh", mesh, "non_finite", (unsigned long long)non_finite,
                      "zero_area", (unsigned long long)zero_area);
    if (!entry || PyList_Append(list, entry) < 0)
      Py_CLEAR(list);
    Py_XDECREF(entry);
  }
  return list;
}

PyObject *stats_of_build(const whittle_scene *scene, const whittle_build_stats *stats) {
  PyObject *dict = dict_of(stats, build_fields);
  const double *center = stats->center;
  if (dict && put(dict, "center", Py_BuildValue("(ddd)", center[0], center[1], center[2])) &&
      put(dict, "dropped", dropped_meshes(scene, stats->meshes)))
    return dict;
  Py_XDECREF(dict);
  return NULL;
}

/* ---- Render ---- */

/* A list made of each bit of a mask by `make`, which may give NULL with an exception. */
static PyObject *list_of_bits(uint32_t mask, PyObject *make(uint32_t bit)) {
  PyObject *list = PyList_New(0);
  for (uint32_t bit = 1; list && bit <= WHITTLE_NEED_ALL; bit <<= 1) {
    PyObject *entry = mask & bit ? make(bit) : NULL;
    if ((mask & bit) && (!entry || PyList_Append(list, entry) < 0))
      Py_CLEAR(list);
    Py_XDECREF(entry);
  }
  return list;
}

static PyObject *need_name(uint32_t bit) {
  return PyUnicode_FromString(whittle_need_name(bit));
}

static PyObject *need_reason(uint32_t bit) {
  return Py_BuildValue("(ss)", whittle_need_name(bit), whittle_need_reason(bit));
}

PyObject *stats_of_render(const whittle_render_stats *stats) {
  PyObject *dict = dict_of(stats, render_fields);
  const uint32_t left_out = WHITTLE_NEED_ALL & ~stats->kernel_needs;
  if (dict && put(dict, "needs", list_of_bits(stats->needs, need_name)) &&
      put(dict, "kernel_needs", list_of_bits(stats->kernel_needs, need_name)) &&
      put(dict, "left_out", list_of_bits(left_out, need_reason)))
    return dict;
  Py_XDECREF(dict);
  return NULL;
}
