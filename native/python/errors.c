/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The core's failures and wrong arguments as Python exceptions. */

#include "module.h"

#include <stdarg.h>
#include <string.h>

PyObject *raise_value(const char *name, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  PyObject *sentence = PyUnicode_FromFormatV(format, arguments);
  va_end(arguments);
  if (sentence)
    PyErr_Format(PyExc_ValueError, "%s %U", name, sentence);
  Py_XDECREF(sentence);
  return NULL;
}

PyObject *raise_caused(const char *name, const char *sentence) {
  if (!PyErr_ExceptionMatches(PyExc_TypeError) && !PyErr_ExceptionMatches(PyExc_ValueError) &&
      !PyErr_ExceptionMatches(PyExc_OverflowError))
    return NULL;
  PyObject *type, *cause, *traceback;
  PyErr_Fetch(&type, &cause, &traceback);
  PyErr_NormalizeException(&type, &cause, &traceback);
  if (traceback)
    PyException_SetTraceback(cause, traceback);
  Py_XDECREF(type);
  Py_XDECREF(traceback);
  PyErr_Format(PyExc_ValueError, "%s %s (%S)", name, sentence, cause);
  PyObject *raised;
  PyErr_Fetch(&type, &raised, &traceback);
  PyErr_NormalizeException(&type, &raised, &traceback);
  PyException_SetCause(raised, cause); /* takes the reference */
  PyErr_Restore(type, raised, traceback);
  return NULL;
}

static PyObject *exception_of(module_state *state, whittle_status status) {
  switch (status) {
  case WHITTLE_INVALID_ARGUMENT:
    return PyExc_ValueError;
  case WHITTLE_OUT_OF_MEMORY:
    return PyExc_MemoryError;
  case WHITTLE_CANCELLED:
    return state->cancelled;
  default:
    return PyExc_RuntimeError;
  }
}

PyObject *raise_status(module_state *state, whittle_status status, const whittle_error *error) {
  PyObject *exception = exception_of(state, status);
  if (error->argument[0] && !strstr(error->message, error->argument))
    return PyErr_Format(exception, "%s: %s", error->argument, error->message);
  return PyErr_Format(exception, "%s", error->message[0] ? error->message : "cancelled");
}
