/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Arrays in through the buffer protocol, and new numpy arrays out. */

#pragma once

#include "module.h"

/* An array of Python's, held until array_release. Zeroed, it holds nothing. */
typedef struct array_view {
  Py_buffer buffer;
  char type; /* of its elements: f float, d double, I uint32, q int64, Q uint64 */
} array_view;

/* What an array is to hold: any real number, or whole numbers. */
typedef enum array_kind { ARRAY_REAL, ARRAY_WHOLE } array_kind;

/* Whatever numpy makes an array of; elements are native and aligned, strides may be anything. */
bool array_read(module_state *state, PyObject *object, const char *name, array_kind kind,
                array_view *view);
void array_release(array_view *view);

/* Whether the shape is this one, where -1 stands for any length. */
bool array_has_shape(const array_view *view, int ndim, const Py_ssize_t *shape);

/* The same, else ValueError: NAME must have SHAPE, such as "(n, 3)". */
bool array_check_shape(const array_view *view, const char *name, const char *shape_text, int ndim,
                       const Py_ssize_t *shape);

/* Elements in C order without gaps: the view's own memory if it is so already, else a copy, which
 * *owned then holds for PyMem_Free. NULL with an exception if that fails; whole numbers must lie in
 * 0 .. 2^32 - 1. Doubles too large for a float become infinite. */
const float *array_floats(const array_view *view, void **owned);
const uint32_t *array_uints(const array_view *view, const char *name, void **owned);

/* As many doubles as the view has elements. */
void array_doubles(const array_view *view, double *out);

/* A view of (k,), (k, 3) or () floats or doubles as the core reads it. */
whittle_array array_strided(const array_view *view);

/* Exactly `count` finite numbers, such as a colour or a point. */
bool array_vector(module_state *state, PyObject *object, const char *name, int count, double *out);

/* A 4x4 matrix by rows. */
bool array_matrix(module_state *state, PyObject *object, const char *name, double out[16]);

/* A new numpy array; its memory is in *data, which stays where it is while the array lives and the
 * view, if there is one, is held. */
PyObject *array_new(module_state *state, int ndim, const Py_ssize_t *shape, PyObject *dtype,
                    array_view *view, void **data);
PyObject *array_new_of(module_state *state, int ndim, const Py_ssize_t *shape, const char *dtype,
                       array_view *view, void **data);
