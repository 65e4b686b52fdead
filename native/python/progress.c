/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Calls of the core that report progress to Python and listen to its signals. */

#include "module.h"

bool progress_init(progress_call *call, PyObject *on_progress) {
  *call = (progress_call){0};
  if (!on_progress || on_progress == Py_None)
    return true;
  if (!PyCallable_Check(on_progress)) {
    raise_value("on_progress", "must be callable or None, not %R",
                (PyObject *)Py_TYPE(on_progress));
    return false;
  }
  call->callable = on_progress;
  return true;
}

/* 1: go on; 0: the callable said stop; -1: an exception is set. */
static int ask(PyObject *callable, double fraction) {
  if (PyErr_CheckSignals() < 0)
    return -1;
  if (!callable)
    return 1;
  PyObject *answer = PyObject_CallFunction(callable, "d", fraction);
  if (!answer)
    return -1;
  const int go = answer == Py_None ? 1 : PyObject_IsTrue(answer);
  Py_DECREF(answer);
  return go;
}

static int report(void *user, double fraction) {
  progress_call *call = user;
  PyEval_RestoreThread(call->thread);
  const int go = call->type ? -1 : ask(call->callable, fraction);
  if (go < 0 && !call->type)
    PyErr_Fetch(&call->type, &call->value, &call->traceback);
  call->thread = PyEval_SaveThread();
  return go > 0;
}

whittle_progress progress_begin(progress_call *call) {
  call->thread = PyEval_SaveThread();
  return (whittle_progress){.report = report, .user = call};
}

bool progress_end(progress_call *call) {
  PyEval_RestoreThread(call->thread);
  if (!call->type)
    return true;
  PyErr_Restore(call->type, call->value, call->traceback);
  return false;
}
