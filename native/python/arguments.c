/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Numbers, words and mappings from Python. */

#include "arguments.h"

#include <math.h>
#include <stdio.h>

/* An integer between two bounds; anything with __index__ will do. */
static bool argument_integer(PyObject *object, const char *name, long long least, long long most,
                             long long *value) {
  PyObject *integer = PyNumber_Index(object);
  if (!integer)
    return raise_caused(name, "must be an integer");
  int overflow;
  *value = PyLong_AsLongLongAndOverflow(integer, &overflow);
  Py_DECREF(integer);
  if (overflow || *value < least || *value > most)
    return raise_value(name, "must be from %lld to %lld, not %R", least, most, object);
  return true;
}

bool argument_uint32(PyObject *object, const char *name, uint32_t least, uint32_t *value) {
  long long wide = 0;
  if (!argument_integer(object, name, least, UINT32_MAX, &wide))
    return false;
  *value = (uint32_t)wide;
  return true;
}

bool argument_int32(PyObject *object, const char *name, int32_t *value) {
  long long wide = 0;
  if (!argument_integer(object, name, INT32_MIN, INT32_MAX, &wide))
    return false;
  *value = (int32_t)wide;
  return true;
}

bool argument_double(PyObject *object, const char *name, double *value) {
  *value = PyFloat_AsDouble(object);
  if (*value == -1.0 && PyErr_Occurred())
    return raise_caused(name, "must be a number");
  return true;
}

bool argument_float(PyObject *object, const char *name, float *value) {
  double wide;
  if (!argument_double(object, name, &wide))
    return false;
  *value = (float)wide;
  if (!isfinite(*value))
    return raise_value(name, "must be finite as a float, not %R", object);
  return true;
}

bool argument_flag(PyObject *object, const char *name, int *value) {
  if (!PyNumber_Check(object))
    return raise_value(name, "must be True or False, not %R", object);
  *value = PyObject_IsTrue(object);
  return *value >= 0;
}

static PyObject *joined(const char *const *words) {
  PyObject *text = PyUnicode_FromString(words[0]);
  for (int i = 1; text && words[i]; i++) {
    PyObject *longer = PyUnicode_FromFormat("%U, %s", text, words[i]);
    Py_DECREF(text);
    text = longer;
  }
  return text;
}

static int place_of(PyObject *object, const char *const *words) {
  for (int i = 0; PyUnicode_Check(object) && words[i]; i++)
    if (PyUnicode_CompareWithASCIIString(object, words[i]) == 0)
      return i;
  return -1;
}

static bool refuse_word(PyObject *object, const char *name, const char *const *words,
                        const char *sentence) {
  PyObject *known = joined(words);
  if (known)
    raise_value(name, sentence, known, object);
  Py_XDECREF(known);
  return false;
}

bool argument_word(PyObject *object, const char *name, const char *const *words, int *place) {
  *place = place_of(object, words);
  return *place >= 0 || refuse_word(object, name, words, "must be one of %U, not %R");
}

static bool known_keys(PyObject *dict, const char *name, const char *const *keys) {
  PyObject *key, *value;
  Py_ssize_t position = 0;
  while (PyDict_Next(dict, &position, &key, &value))
    if (place_of(key, keys) < 0)
      return refuse_word(key, name, keys, "may hold %U, but not %R");
  return true;
}

PyObject *argument_mapping(PyObject *object, const char *name, const char *const *keys) {
  if (!PyDict_Check(object) && !PyObject_HasAttrString(object, "keys"))
    return raise_value(name, "must be a mapping, not %R", (PyObject *)Py_TYPE(object));
  PyObject *dict = PyDict_New();
  if (!dict)
    return NULL;
  if (PyDict_Update(dict, object) < 0)
    raise_caused(name, "must be a mapping");
  else if (!keys || known_keys(dict, name, keys))
    return dict;
  Py_DECREF(dict);
  return NULL;
}

PyObject *argument_sequence(PyObject *object, const char *name) {
  if (PyUnicode_Check(object) || PyBytes_Check(object) || PyDict_Check(object))
    return raise_value(name, "must be a sequence, not %R", (PyObject *)Py_TYPE(object));
  PyObject *list = PySequence_List(object);
  return list ? list : raise_caused(name, "must be a sequence");
}

void name_key(char name[NAME_SIZE], const char *mapping, const char *key) {
  snprintf(name, NAME_SIZE, "%s['%s']", mapping, key);
}

void name_index(char name[NAME_SIZE], const char *sequence, Py_ssize_t index) {
  snprintf(name, NAME_SIZE, "%s[%zd]", sequence, index);
}
