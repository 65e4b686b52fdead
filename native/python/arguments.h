/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Numbers, words and mappings from Python, each refused by name if it is not what it should be. */

#pragma once

#include "module.h"

/* All give false and set ValueError naming NAME if the object does not fit. */
bool argument_uint32(PyObject *object, const char *name, uint32_t least, uint32_t *value);
bool argument_int32(PyObject *object, const char *name, int32_t *value);
bool argument_double(PyObject *object, const char *name, double *value);
bool argument_float(PyObject *object, const char *name, float *value); /* finite as a float */
bool argument_flag(PyObject *object, const char *name, int *value);

/* One of WORDS (ended by NULL): its place. */
bool argument_word(PyObject *object, const char *name, const char *const *words, int *place);

/* A new dict with the items of a mapping. Its keys are all among KEYS (ended by NULL), unless that
 * is NULL. */
PyObject *argument_mapping(PyObject *object, const char *name, const char *const *keys);

/* A new list with the items of a sequence that is not a string. */
PyObject *argument_sequence(PyObject *object, const char *name);

/* Names of items for the messages above: "camera['width']", "materials[3]". */
enum { NAME_SIZE = 96 };
void name_key(char name[NAME_SIZE], const char *mapping, const char *key);
void name_index(char name[NAME_SIZE], const char *sequence, Py_ssize_t index);
