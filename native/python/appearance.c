/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Scene.set_materials, Scene.set_lights and Scene.set_world. */

#include "arguments.h"
#include "arrays.h"
#include "scene_methods.h"

#include <math.h>
#include <stddef.h>

static bool finite_float(double wide, const char *name, float *value) {
  *value = (float)wide;
  return isfinite(*value) || raise_value(name, "must be finite as floats");
}

static bool read_color(module_state *state, PyObject *object, const char *name, float color[3]) {
  double wide[3];
  bool good = array_vector(state, object, name, 3, wide);
  for (int i = 0; good && i < 3; i++)
    good = finite_float(wide[i], name, &color[i]);
  return good;
}

/* An item of a dict, borrowed; NULL without an exception if it is not there. */
static PyObject *item(PyObject *dict, const char *key, const char *owner, char name[NAME_SIZE]) {
  name_key(name, owner, key);
  return PyDict_GetItemString(dict, key);
}

/* ---- Materials ---- */

/* Where each number of a material goes. */
static const struct field {
  const char *key;
  size_t offset;
  bool color;
} material_fields[] = {
    {"diffuse", offsetof(whittle_material, diffuse), true},
    {"mirror", offsetof(whittle_material, mirror), true},
    {"metal", offsetof(whittle_material, metal), true},
    {"metal_weight", offsetof(whittle_material, metal_weight), false},
    {"specular", offsetof(whittle_material, specular), true},
    {"transmission", offsetof(whittle_material, transmission), true},
    {"emission", offsetof(whittle_material, emission), true},
    {"ior", offsetof(whittle_material, ior), false},
    {"roughness", offsetof(whittle_material, roughness), false},
};
enum { MATERIAL_FIELDS = sizeof material_fields / sizeof material_fields[0] };

static bool read_material(module_state *state, PyObject *dict, const char *owner,
                          whittle_material *material) {
  for (int i = 0; i < MATERIAL_FIELDS; i++) {
    const struct field *field = &material_fields[i];
    char name[NAME_SIZE];
    float *const to = (float *)((char *)material + field->offset);
    PyObject *value = item(dict, field->key, owner, name);
    if (value &&
        !(field->color ? read_color(state, value, name, to) : argument_float(value, name, to)))
      return false;
    if (value && to == &material->ior && *to == 0)
      return raise_value(name, "must be above 0");
  }
  return true;
}

/* ---- Lights ---- */

static bool read_light_place(module_state *state, PyObject *dict, const char *owner,
                             whittle_light *light) {
  char name[NAME_SIZE];
  const bool sun = light->kind == WHITTLE_SUN;
  PyObject *place = item(dict, sun ? "direction" : "position", owner, name);
  if (!place)
    return raise_value(name, "is missing: a %s light needs it", sun ? "sun" : "point");
  return array_vector(state, place, name, 3, sun ? light->direction : light->position);
}

static bool read_light(module_state *state, PyObject *dict, const char *owner,
                       whittle_light *light) {
  static const char *const kinds[] = {"point", "sun", NULL};
  char name[NAME_SIZE];
  int kind, shadow = 1;
  PyObject *value = item(dict, "kind", owner, name);
  if (!value)
    return raise_value(name, "is missing: \"point\" or \"sun\"");
  if (!argument_word(value, name, kinds, &kind))
    return false;
  light->kind = (whittle_light_kind)kind;
  if (!(value = item(dict, "intensity", owner, name)))
    return raise_value(name, "is missing: three floats");
  if (!read_color(state, value, name, light->intensity))
    return false;
  if ((value = item(dict, "shadow", owner, name)) && !argument_flag(value, name, &shadow))
    return false;
  light->no_shadow = !shadow;
  return read_light_place(state, dict, owner, light);
}

/* ---- Lists of either ---- */

typedef bool read_entry(module_state *state, PyObject *dict, const char *owner, void *entry);

static bool read_material_entry(module_state *state, PyObject *dict, const char *owner,
                                void *entry) {
  return read_material(state, dict, owner, entry);
}

static bool read_light_entry(module_state *state, PyObject *dict, const char *owner, void *entry) {
  return read_light(state, dict, owner, entry);
}

/* Zeroed entries of `size` bytes filled from a sequence of mappings; NULL and an exception if one
 * does not fit. To be freed with PyMem_Free. */
static void *read_entries(module_state *state, PyObject *object, const char *name,
                          const char *const *keys, read_entry *read, size_t size, size_t *count) {
  PyObject *list = argument_sequence(object, name);
  if (!list)
    return NULL;
  *count = (size_t)PyList_Size(list);
  char *entries = PyMem_Calloc(*count, size);
  bool good = entries || PyErr_NoMemory();
  for (size_t i = 0; good && i < *count; i++) {
    char owner[NAME_SIZE];
    name_index(owner, name, (Py_ssize_t)i);
    PyObject *dict = argument_mapping(PyList_GetItem(list, (Py_ssize_t)i), owner, keys);
    good = dict && read(state, dict, owner, entries + i * size);
    Py_XDECREF(dict);
  }
  Py_DECREF(list);
  if (good)
    return entries;
  PyMem_Free(entries);
  return NULL;
}

static PyObject *none_or_raise(module_state *state, whittle_status status,
                               const whittle_error *error) {
  if (status)
    return raise_status(state, status, error);
  Py_RETURN_NONE;
}

PyObject *scene_set_materials(PyObject *self, PyObject *args, PyObject *kwargs) {
  static char *names[] = {"materials", NULL};
  const char *keys[MATERIAL_FIELDS + 1] = {0};
  for (int i = 0; i < MATERIAL_FIELDS; i++)
    keys[i] = material_fields[i].key;
  PyObject *list;
  if (!PyArg_ParseTupleAndKeywords(args, kwargs, "O:set_materials", names, &list))
    return NULL;
  module_state *state = state_of(self);
  size_t count;
  whittle_material *materials =
      read_entries(state, list, "materials", keys, read_material_entry, sizeof *materials, &count);
  if (!materials)
    return NULL;
  whittle_error error = {0};
  const whittle_status status =
      whittle_scene_set_materials(scene_handle(self), materials, count, &error);
  PyMem_Free(materials);
  return none_or_raise(state, status, &error);
}

PyObject *scene_set_lights(PyObject *self, PyObject *args, PyObject *kwargs) {
  static char *names[] = {"lights", NULL};
  static const char *const keys[] = {"kind", "intensity", "position", "direction", "shadow", NULL};
  PyObject *list;
  if (!PyArg_ParseTupleAndKeywords(args, kwargs, "O:set_lights", names, &list))
    return NULL;
  module_state *state = state_of(self);
  size_t count;
  whittle_light *lights =
      read_entries(state, list, "lights", keys, read_light_entry, sizeof *lights, &count);
  if (!lights)
    return NULL;
  whittle_error error = {0};
  const whittle_status status = whittle_scene_set_lights(scene_handle(self), lights, count, &error);
  PyMem_Free(lights);
  return none_or_raise(state, status, &error);
}

PyObject *scene_set_world(PyObject *self, PyObject *args, PyObject *kwargs) {
  static char *names[] = {"color", "ambient", NULL};
  PyObject *color, *ambient = NULL;
  if (!PyArg_ParseTupleAndKeywords(args, kwargs, "O|O:set_world", names, &color, &ambient))
    return NULL;
  module_state *state = state_of(self);
  whittle_world world = {0};
  if (!read_color(state, color, "color", world.color) ||
      (ambient && !read_color(state, ambient, "ambient", world.ambient)))
    return NULL;
  whittle_error error = {0};
  const whittle_status status = whittle_scene_set_world(scene_handle(self), &world, &error);
  return none_or_raise(state, status, &error);
}
