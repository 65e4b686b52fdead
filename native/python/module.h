/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What the files of the Python module share: its state, errors and progress. */

#pragma once

#define Py_LIMITED_API 0x030b0000
#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include "whittle.h"

#include <stdbool.h>

typedef struct module_state {
  PyObject *numpy; /* NULL until an array is first needed */
  PyObject *cancelled;
  PyObject *scene_type, *job_type;
} module_state;

/* Types are final, so the type of self is the module's own. */
module_state *state_of(PyObject *self);

/* numpy, borrowed; NULL and ImportError if it is not installed. */
PyObject *state_numpy(module_state *state);

/* The specifications of the two types, and how a job comes to be. */
extern PyType_Spec scene_type_spec, job_type_spec;
PyObject *job_start(PyObject *scene, PyObject *camera, PyObject *settings);

/* polygons.c */
PyObject *module_triangulate(PyObject *module, PyObject *args, PyObject *kwargs);

/* The scene behind a Scene object. */
whittle_scene *scene_handle(PyObject *self);

/* ---- errors.c ---- */

/* ValueError "NAME <format>"; always gives NULL. */
PyObject *raise_value(const char *name, const char *format, ...);

/* Turns a pending TypeError, ValueError or OverflowError into a ValueError about NAME that has it
 * as its cause; other exceptions stay. Always gives NULL. */
PyObject *raise_caused(const char *name, const char *sentence);

/* The exception that says what a function of the core said; always gives NULL. */
PyObject *raise_status(module_state *state, whittle_status status, const whittle_error *error);

/* ---- progress.c ---- */

/* A call into the core without the GIL, which comes back to call Python. */
typedef struct progress_call {
  PyObject *callable; /* borrowed, or NULL */
  PyThreadState *thread;
  PyObject *type, *value, *traceback; /* what the callable raised */
} progress_call;

/* False and ValueError if on_progress cannot be called; None means none. */
bool progress_init(progress_call *call, PyObject *on_progress);
whittle_progress progress_begin(progress_call *call); /* releases the GIL */
bool progress_end(progress_call *call); /* takes it back; false if an exception is set */
