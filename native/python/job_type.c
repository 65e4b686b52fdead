/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The type Job: a render in the background. */

#include "request.h"
#include "stats.h"

#include <time.h>

typedef struct job_object {
  PyObject_HEAD whittle_job *job;
  PyObject *scene; /* kept while the job may read it */
  render_images images;
  bool ended; /* its end was waited for; then these tell how it ended */
  whittle_status status;
  whittle_error error;
} job_object;

PyObject *job_start(PyObject *scene, PyObject *camera, PyObject *settings) {
  module_state *state = state_of(scene);
  render_request request;
  if (!request_read(state, camera, settings, &request))
    return NULL;
  PyTypeObject *type = (PyTypeObject *)state->job_type;
  job_object *self = (job_object *)((allocfunc)PyType_GetSlot(type, Py_tp_alloc))(type, 0);
  if (!self)
    return NULL;
  whittle_error error = {0};
  whittle_status status = WHITTLE_OK;
  self->scene = Py_NewRef(scene);
  if (images_new(state, scene_handle(scene), &request, &self->images)) {
    status = whittle_job_start(scene_handle(scene), &request.camera, &request.settings,
                               &self->images.image, &self->job, &error);
    if (!status)
      return (PyObject *)self;
    raise_status(state, status, &error);
  }
  Py_DECREF(self);
  return NULL;
}

static int job_traverse(PyObject *object, visitproc visit, void *arg) {
  job_object *self = (job_object *)object;
  Py_VISIT(Py_TYPE(object));
  Py_VISIT(self->scene);
  Py_VISIT(self->images.dict);
  return 0;
}

/* Only the dict that result() gave away can be part of a cycle. */
static int job_clear(PyObject *object) {
  job_object *self = (job_object *)object;
  if (self->ended)
    Py_CLEAR(self->images.dict);
  return 0;
}

static void job_dealloc(PyObject *object) {
  job_object *self = (job_object *)object;
  PyTypeObject *type = Py_TYPE(object);
  PyObject_GC_UnTrack(object);
  if (self->job) {
    Py_BEGIN_ALLOW_THREADS whittle_job_destroy(self->job);
    Py_END_ALLOW_THREADS
  }
  images_release(&self->images);
  Py_XDECREF(self->scene);
  ((freefunc)PyType_GetSlot(type, Py_tp_free))(object);
  Py_DECREF(type);
}

static PyObject *job_poll(PyObject *object, PyObject *unused) {
  (void)unused;
  int done = 0;
  const double fraction = whittle_job_poll(((job_object *)object)->job, &done);
  return Py_BuildValue("(dO)", fraction, done ? Py_True : Py_False);
}

static PyObject *job_cancel(PyObject *object, PyObject *unused) {
  (void)unused;
  whittle_job_cancel(((job_object *)object)->job);
  Py_RETURN_NONE;
}

/* Sleeps in steps short enough for Ctrl-C; false if a signal raised. */
static bool sleep_until_done(job_object *self) {
  const struct timespec step = {.tv_nsec = 1000000};
  for (int done = 0; whittle_job_poll(self->job, &done), !done;) {
    Py_BEGIN_ALLOW_THREADS nanosleep(&step, NULL);
    Py_END_ALLOW_THREADS if (PyErr_CheckSignals() < 0) return false;
  }
  return true;
}

/* Called with the GIL once the job is done, so that it waits for nothing and only once. */
static bool collect(job_object *self) {
  whittle_render_stats stats;
  self->status = whittle_job_wait(self->job, &stats, &self->error);
  self->ended = true;
  images_unhold(&self->images);
  Py_CLEAR(self->scene);
  if (self->status) {
    Py_CLEAR(self->images.dict);
    return true;
  }
  PyObject *measured = stats_of_render(&stats);
  const bool good = measured && PyDict_SetItemString(self->images.dict, "stats", measured) == 0;
  Py_XDECREF(measured);
  return good;
}

static PyObject *job_result(PyObject *object, PyObject *unused) {
  (void)unused;
  job_object *self = (job_object *)object;
  if (!self->ended && !sleep_until_done(self))
    return NULL;
  if (!self->ended && !collect(self))
    return NULL;
  if (self->status)
    return raise_status(state_of(object), self->status, &self->error);
  return Py_NewRef(self->images.dict);
}

static PyMethodDef job_methods[] = {
    {"poll", job_poll, METH_NOARGS, "poll($self)\n--\n\nFraction done, and whether it has ended."},
    {"cancel", job_cancel, METH_NOARGS, "cancel($self)\n--\n\nAsk it to stop."},
    {"result", job_result, METH_NOARGS,
     "result($self)\n--\n\nWait; what Scene.render gives or raises."},
    {0},
};

static PyType_Slot job_slots[] = {
    {Py_tp_doc, "A render in the background, started by Scene.start."},
    {Py_tp_dealloc, job_dealloc},
    {Py_tp_traverse, job_traverse},
    {Py_tp_clear, job_clear},
    {Py_tp_methods, job_methods},
    {0},
};

PyType_Spec job_type_spec = {
    .name = "whittle_core.Job",
    .basicsize = sizeof(job_object),
    .flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_HAVE_GC | Py_TPFLAGS_DISALLOW_INSTANTIATION,
    .slots = job_slots,
};
