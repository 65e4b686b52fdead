/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Arrays through the buffer protocol. */

#include "arrays.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

/* ---- In ---- */

static bool attribute_long(PyObject *object, const char *name, long *value) {
  PyObject *attribute = PyObject_GetAttrString(object, name);
  if (!attribute)
    return false;
  *value = PyLong_AsLong(attribute);
  Py_DECREF(attribute);
  return *value != -1 || !PyErr_Occurred();
}

/* dtype.kind and dtype.itemsize as numpy documents them: f 4, i 8, ... */
static bool dtype_of(PyObject *array, char *kind, long *itemsize) {
  PyObject *dtype = PyObject_GetAttrString(array, "dtype");
  PyObject *word = dtype ? PyObject_GetAttrString(dtype, "kind") : NULL;
  const bool good = word && attribute_long(dtype, "itemsize", itemsize);
  if (good)
    *kind = (char)PyUnicode_ReadChar(word, 0);
  Py_XDECREF(word);
  Py_XDECREF(dtype);
  return good && !PyErr_Occurred();
}

/* The type that elements of this kind and size are read as, or 0 if they will not do. An array
 * without elements has no wrong ones: numpy calls an empty list float64. */
static char read_as(array_kind wanted, char kind, long itemsize, bool empty) {
  if (wanted == ARRAY_REAL && strchr("fiu", kind))
    return kind == 'f' && itemsize <= 4 ? 'f' : 'd';
  if (wanted == ARRAY_WHOLE && kind == 'u')
    return itemsize <= 4 ? 'I' : 'Q';
  if (wanted == ARRAY_WHOLE && kind == 'i')
    return 'q';
  return wanted == ARRAY_WHOLE && kind == 'f' && empty ? 'I' : 0;
}

static bool aligned(const Py_buffer *buffer) {
  size_t bits = (size_t)buffer->buf;
  for (int axis = 0; axis < buffer->ndim; axis++)
    if (buffer->shape[axis] > 1)
      bits |= (size_t)buffer->strides[axis];
  return bits % (size_t)buffer->itemsize == 0;
}

/* Takes a reference of the array. */
static bool hold(PyObject *array, char type, array_view *view) {
  const bool good = array && PyObject_GetBuffer(array, &view->buffer, PyBUF_STRIDED_RO) == 0;
  Py_XDECREF(array);
  view->type = type;
  return good;
}

/* numpy.asarray or numpy.array (which copies) of one of our types in native bytes. */
static PyObject *convert(PyObject *numpy, const char *how, PyObject *array, char type) {
  const char text[2] = {type, 0};
  return PyObject_CallMethod(numpy, how, "Os", array, text);
}

static bool read_array(PyObject *numpy, PyObject *array, const char *name, array_kind wanted,
                       array_view *view) {
  char kind = 0;
  long itemsize = 0, size = 0;
  if (!dtype_of(array, &kind, &itemsize) || !attribute_long(array, "size", &size))
    return false;
  const char type = read_as(wanted, kind, itemsize, size == 0);
  if (!type) {
    PyObject *dtype = PyObject_GetAttrString(array, "dtype");
    if (dtype)
      raise_value(name, "must hold %s numbers, not %S", wanted == ARRAY_REAL ? "real" : "whole",
                  dtype);
    Py_XDECREF(dtype);
    return false;
  }
  if (!hold(convert(numpy, "asarray", array, type), type, view))
    return false;
  if (aligned(&view->buffer))
    return true;
  array_release(view);
  return hold(convert(numpy, "array", array, type), type, view);
}

bool array_read(module_state *state, PyObject *object, const char *name, array_kind kind,
                array_view *view) {
  PyObject *numpy = state_numpy(state);
  if (!numpy)
    return false;
  PyObject *array = PyObject_CallMethod(numpy, "asarray", "(O)", object);
  if (!array)
    return raise_caused(name, "must be an array");
  const bool good = read_array(numpy, array, name, kind, view);
  Py_DECREF(array);
  return good;
}

void array_release(array_view *view) {
  PyBuffer_Release(&view->buffer);
}

/* ---- Shapes ---- */

bool array_has_shape(const array_view *view, int ndim, const Py_ssize_t *shape) {
  bool same = view->buffer.ndim == ndim;
  for (int axis = 0; same && axis < ndim; axis++)
    same = shape[axis] < 0 || view->buffer.shape[axis] == shape[axis];
  return same;
}

bool array_check_shape(const array_view *view, const char *name, const char *shape_text, int ndim,
                       const Py_ssize_t *shape) {
  if (array_has_shape(view, ndim, shape))
    return true;
  PyObject *found = PyTuple_New(view->buffer.ndim);
  for (int axis = 0; found && axis < view->buffer.ndim; axis++)
    PyTuple_SetItem(found, axis, PyLong_FromSsize_t(view->buffer.shape[axis]));
  if (found && !PyErr_Occurred())
    raise_value(name, "must have shape %s, not %R", shape_text, found);
  Py_XDECREF(found);
  return false;
}

/* ---- Elements ---- */

/* Writes one element and says whether it fits. */
typedef bool put_element(const char *from, char type, void *to);

static double real_at(const char *from, char type) {
  return type == 'f' ? (double)*(const float *)from : *(const double *)from;
}

static bool put_double(const char *from, char type, void *to) {
  *(double *)to = real_at(from, type);
  return true;
}

static bool put_float(const char *from, char type, void *to) {
  *(float *)to = (float)real_at(from, type);
  return true;
}

static bool put_uint(const char *from, char type, void *to) {
  if (type == 'I')
    *(uint32_t *)to = *(const uint32_t *)from;
  else
    *(uint32_t *)to = (uint32_t)*(const uint64_t *)from; /* negative: a huge uint64 */
  return type == 'I' || *(const uint64_t *)from <= UINT32_MAX;
}

/* Copies what lies from `from` on along the axes from `axis` on; the element that does not fit, or
 * NULL. */
static const char *copy_axes(const array_view *view, int axis, const char *from, put_element *put,
                             size_t size, char **to) {
  if (axis == view->buffer.ndim) {
    const bool fits = put(from, view->type, *to);
    *to += size;
    return fits ? NULL : from;
  }
  const char *unfit = NULL;
  for (Py_ssize_t i = 0; i < view->buffer.shape[axis] && !unfit; i++)
    unfit = copy_axes(view, axis + 1, from + i * view->buffer.strides[axis], put, size, to);
  return unfit;
}

static size_t element_count(const array_view *view) {
  return (size_t)(view->buffer.len / view->buffer.itemsize);
}

static void *copied(const array_view *view, put_element *put, size_t size, const char **unfit) {
  char *const memory = PyMem_Malloc(element_count(view) * size);
  char *to = memory;
  if (memory)
    *unfit = copy_axes(view, 0, view->buffer.buf, put, size, &to);
  else
    PyErr_NoMemory();
  return memory;
}

const float *array_floats(const array_view *view, void **owned) {
  if (view->type == 'f' && PyBuffer_IsContiguous(&view->buffer, 'C'))
    return view->buffer.buf;
  const char *unfit;
  return *owned = copied(view, put_float, sizeof(float), &unfit);
}

const uint32_t *array_uints(const array_view *view, const char *name, void **owned) {
  if (view->type == 'I' && PyBuffer_IsContiguous(&view->buffer, 'C'))
    return view->buffer.buf;
  const char *unfit = NULL;
  *owned = copied(view, put_uint, sizeof(uint32_t), &unfit);
  if (!unfit)
    return *owned;
  if (view->type == 'q')
    raise_value(name, "must hold numbers from 0 to %llu, not %lld", (unsigned long long)UINT32_MAX,
                (long long)*(const int64_t *)unfit);
  else
    raise_value(name, "must hold numbers from 0 to %llu, not %llu", (unsigned long long)UINT32_MAX,
                (unsigned long long)*(const uint64_t *)unfit);
  return NULL;
}

void array_doubles(const array_view *view, double *out) {
  char *to = (char *)out;
  copy_axes(view, 0, view->buffer.buf, put_double, sizeof(double), &to);
}

whittle_array array_strided(const array_view *view) {
  const Py_buffer *buffer = &view->buffer;
  return (whittle_array){
      .data = buffer->buf,
      .is_double = view->type == 'd',
      .stride = buffer->ndim > 0 ? buffer->strides[0] : 0,
      .component_stride = buffer->ndim > 1 ? buffer->strides[1] : 0,
  };
}

bool array_vector(module_state *state, PyObject *object, const char *name, int count, double *out) {
  char shape_text[16];
  PyOS_snprintf(shape_text, sizeof shape_text, "(%d,)", count);
  array_view view = {0};
  bool good = array_read(state, object, name, ARRAY_REAL, &view) &&
              array_check_shape(&view, name, shape_text, 1, (Py_ssize_t[]){count});
  if (good)
    array_doubles(&view, out);
  array_release(&view);
  for (int i = 0; good && i < count; i++)
    if (!isfinite(out[i]))
      good = raise_value(name, "must be finite, not %R", object);
  return good;
}

bool array_matrix(module_state *state, PyObject *object, const char *name, double out[16]) {
  array_view view = {0};
  const bool good = array_read(state, object, name, ARRAY_REAL, &view) &&
                    array_check_shape(&view, name, "(4, 4)", 2, (Py_ssize_t[]){4, 4});
  if (good)
    array_doubles(&view, out);
  array_release(&view);
  return good;
}

/* ---- Out ---- */

PyObject *array_new(module_state *state, int ndim, const Py_ssize_t *shape, PyObject *dtype,
                    array_view *view, void **data) {
  PyObject *numpy = state_numpy(state);
  PyObject *lengths = numpy ? PyTuple_New(ndim) : NULL;
  for (int axis = 0; lengths && axis < ndim; axis++)
    PyTuple_SetItem(lengths, axis, PyLong_FromSsize_t(shape[axis]));
  PyObject *array = lengths && !PyErr_Occurred()
                        ? PyObject_CallMethod(numpy, "empty", "OO", lengths, dtype)
                        : NULL;
  Py_XDECREF(lengths);
  if (array && PyObject_GetBuffer(array, &view->buffer, PyBUF_CONTIG) < 0)
    Py_CLEAR(array);
  if (array)
    *data = view->buffer.buf;
  return array;
}

PyObject *array_new_of(module_state *state, int ndim, const Py_ssize_t *shape, const char *dtype,
                       array_view *view, void **data) {
  PyObject *text = PyUnicode_FromString(dtype);
  PyObject *array = text ? array_new(state, ndim, shape, text, view, data) : NULL;
  Py_XDECREF(text);
  return array;
}
