/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The Python module whittle_core: its functions, constants and types. */

#include "module.h"

module_state *state_of(PyObject *self) {
  return PyType_GetModuleState(Py_TYPE(self));
}

PyObject *state_numpy(module_state *state) {
  if (!state->numpy)
    state->numpy = PyImport_ImportModule("numpy");
  return state->numpy;
}

/* ---- Functions ---- */

static PyObject *module_isa(PyObject *module, PyObject *unused) {
  (void)unused;
  whittle_error error = {0};
  const char *name = whittle_isa(&error);
  return name ? PyUnicode_FromString(name)
              : raise_status(PyModule_GetState(module), WHITTLE_UNSUPPORTED, &error);
}

static PyObject *module_isas(PyObject *module, PyObject *unused) {
  (void)module;
  (void)unused;
  PyObject *list = PyList_New(0);
  for (const char *const *isa = whittle_isas(); list && *isa; isa++) {
    PyObject *name = PyUnicode_FromString(*isa);
    if (!name || PyList_Append(list, name) < 0)
      Py_CLEAR(list);
    Py_XDECREF(name);
  }
  PyObject *result = list ? PyList_AsTuple(list) : NULL;
  Py_XDECREF(list);
  return result;
}

static PyObject *module_default_threads(PyObject *module, PyObject *unused) {
  (void)module;
  (void)unused;
  return PyLong_FromUnsignedLong(whittle_default_threads());
}

static PyMethodDef module_methods[] = {
    {"isa", module_isa, METH_NOARGS, "isa()\n--\n\nThe instruction set in use."},
    {"isas", module_isas, METH_NOARGS, "isas()\n--\n\nThe instruction sets that can run here."},
    {"default_threads", module_default_threads, METH_NOARGS,
     "default_threads()\n--\n\nWhat threads=0 means here."},
    {"triangulate", (PyCFunction)(void (*)(void))module_triangulate, METH_VARARGS | METH_KEYWORDS,
     "triangulate(positions, corners, faces, *, by_corner=False)\n--\n\nSee whittle_core.pyi."},
    {0},
};

/* ---- Contents ---- */

/* Adds a new reference and gives it up. */
static bool add(PyObject *module, const char *name, PyObject *object) {
  const bool good = object && PyModule_AddObjectRef(module, name, object) == 0;
  Py_XDECREF(object);
  return good;
}

static PyObject *pass_table(void) {
  PyObject *dict = PyDict_New();
  for (int i = 0; dict && i < WHITTLE_PASS_COUNT; i++) {
    PyObject *channels = PyLong_FromUnsignedLong(whittle_pass_channels((whittle_pass)i));
    if (!channels || PyDict_SetItemString(dict, whittle_pass_name((whittle_pass)i), channels) < 0)
      Py_CLEAR(dict);
    Py_XDECREF(channels);
  }
  return dict;
}

static bool add_types(PyObject *module, module_state *state) {
  state->cancelled = PyErr_NewExceptionWithDoc(
      "whittle_core.Cancelled", "The progress callback returned False, or the job was cancelled.",
      NULL, NULL);
  state->scene_type = PyType_FromModuleAndSpec(module, &scene_type_spec, NULL);
  state->job_type = PyType_FromModuleAndSpec(module, &job_type_spec, NULL);
  return state->cancelled && state->scene_type && state->job_type &&
         PyModule_AddObjectRef(module, "Cancelled", state->cancelled) == 0 &&
         PyModule_AddObjectRef(module, "Scene", state->scene_type) == 0 &&
         PyModule_AddObjectRef(module, "Job", state->job_type) == 0;
}

static int module_exec(PyObject *module) {
  const bool good = add_types(module, PyModule_GetState(module)) &&
                    add(module, "__version__", PyUnicode_FromString(WHITTLE_VERSION)) &&
                    add(module, "PASSES", pass_table()) &&
                    PyModule_AddIntConstant(module, "CAMERA", WHITTLE_CAMERA) == 0 &&
                    PyModule_AddIntConstant(module, "SHADOW", WHITTLE_SHADOW) == 0 &&
                    PyModule_AddIntConstant(module, "REFLECTION", WHITTLE_REFLECTION) == 0 &&
                    PyModule_AddIntConstant(module, "REFRACTION", WHITTLE_REFRACTION) == 0 &&
                    PyModule_AddIntConstant(module, "ALL", WHITTLE_ALL) == 0;
  return good ? 0 : -1;
}

/* ---- Life ---- */

static int module_traverse(PyObject *module, visitproc visit, void *arg) {
  module_state *state = PyModule_GetState(module);
  if (!state)
    return 0;
  Py_VISIT(state->numpy);
  Py_VISIT(state->cancelled);
  Py_VISIT(state->scene_type);
  Py_VISIT(state->job_type);
  return 0;
}

static int module_clear(PyObject *module) {
  module_state *state = PyModule_GetState(module);
  if (!state)
    return 0;
  Py_CLEAR(state->numpy);
  Py_CLEAR(state->cancelled);
  Py_CLEAR(state->scene_type);
  Py_CLEAR(state->job_type);
  return 0;
}

static void module_free(void *module) {
  module_clear(module);
}

static PyModuleDef_Slot module_slots[] = {{Py_mod_exec, module_exec}, {0}};

static PyModuleDef module_definition = {
    PyModuleDef_HEAD_INIT,
    .m_name = "whittle_core",
    .m_doc = "Scenes of triangles, their BVH, rays and Whitted images.",
    .m_size = sizeof(module_state),
    .m_methods = module_methods,
    .m_slots = module_slots,
    .m_traverse = module_traverse,
    .m_clear = module_clear,
    .m_free = module_free,
};

PyMODINIT_FUNC PyInit_whittle_core(void) {
  return PyModuleDef_Init(&module_definition);
}
