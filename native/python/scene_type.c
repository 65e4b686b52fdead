/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The type Scene. */

#include "scene_methods.h"

typedef struct scene_object {
  PyObject_HEAD whittle_scene *scene;
} scene_object;

whittle_scene *scene_handle(PyObject *self) {
  return ((scene_object *)self)->scene;
}

static PyObject *scene_new(PyTypeObject *type, PyObject *args, PyObject *kwargs) {
  if (PyTuple_Size(args) || (kwargs && PyDict_Size(kwargs)))
    return PyErr_Format(PyExc_TypeError, "Scene() takes no arguments");
  allocfunc allocate = (allocfunc)PyType_GetSlot(type, Py_tp_alloc);
  scene_object *self = (scene_object *)allocate(type, 0);
  if (!self)
    return NULL;
  whittle_error error = {0};
  const whittle_status status = whittle_scene_create(&self->scene, &error);
  if (!status)
    return (PyObject *)self;
  raise_status(state_of((PyObject *)self), status, &error);
  Py_DECREF(self);
  return NULL;
}

static void scene_dealloc(PyObject *self) {
  PyTypeObject *type = Py_TYPE(self);
  whittle_scene_destroy(scene_handle(self));
  ((freefunc)PyType_GetSlot(type, Py_tp_free))(self);
  Py_DECREF(type);
}

#define METHOD(name, signature)                                                                    \
  {#name, (PyCFunction)(void (*)(void))scene_##name, METH_VARARGS | METH_KEYWORDS,                 \
   #name signature "\n--\n\nSee whittle_core.pyi."}

static PyMethodDef scene_methods[] = {
    METHOD(add_mesh, "($self, positions, triangles, normals=None, uvs=None, materials=None, "
                     "*, corners=None, keep=False)"),
    METHOD(add_instance, "($self, mesh, transform, object_id=0, visibility=15)"),
    METHOD(set_transform, "($self, instance, transform)"),
    METHOD(replace_mesh, "($self, mesh, positions, triangles, normals=None, uvs=None, "
                         "materials=None, *, corners=None, keep=False)"),
    METHOD(remove_instance, "($self, instance)"),
    METHOD(set_materials, "($self, materials)"),
    METHOD(set_lights, "($self, lights)"),
    METHOD(set_world, "($self, color, ambient=(0, 0, 0))"),
    METHOD(build, "($self, threads=0, bins=16, on_progress=None, *, max_leaf=0, "
                  "traversal_cost=0.0, by_instance=False, lean=False)"),
    METHOD(intersect,
           "($self, origins, directions, t_min=0.0, t_max=1e999, threads=0, *, packet=0, "
           "visibility=15, counters=False)"),
    METHOD(occluded, "($self, origins, directions, t_min=0.0, t_max=1e999, threads=0, *, packet=0, "
                     "visibility=15)"),
    METHOD(reference_intersect,
           "($self, origins, directions, t_min=0.0, t_max=1e999, threads=0, *, "
           "visibility=15)"),
    METHOD(render, "($self, camera, settings=None, on_progress=None)"),
    METHOD(start, "($self, camera, settings=None)"),
    METHOD(quality, "($self, overlap=False, by_instance=False, on_progress=None, *, threads=0, "
                    "overlap_samples=0)"),
    METHOD(probe, "($self, camera, settings, x, y)"),
    {"owners", scene_owners, METH_NOARGS,
     "owners($self)\n--\n\nWhose triangles lie under each node."},
    {"nodes", scene_nodes, METH_NOARGS, "nodes($self)\n--\n\nA copy of the binary tree."},
    {"triangles", scene_triangles, METH_NOARGS,
     "triangles($self)\n--\n\nThe triangles in leaf order."},
    {0},
};

static PyType_Slot scene_slots[] = {
    {Py_tp_doc, "Meshes, instances, materials, lights and world; then a BVH, rays and images."},
    {Py_tp_new, scene_new},
    {Py_tp_dealloc, scene_dealloc},
    {Py_tp_methods, scene_methods},
    {0},
};

PyType_Spec scene_type_spec = {
    .name = "whittle_core.Scene",
    .basicsize = sizeof(scene_object),
    .flags = Py_TPFLAGS_DEFAULT,
    .slots = scene_slots,
};
