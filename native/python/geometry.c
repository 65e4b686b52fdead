/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Scene.add_mesh, Scene.replace_mesh and Scene.add_instance. */

#include "arguments.h"
#include "arrays.h"
#include "scene_methods.h"

/* What a mesh is made of while it is handed over. */
typedef struct mesh_arrays {
  array_view positions, triangles, normals, materials, corners;
  void *owned[5];
  whittle_mesh mesh;
} mesh_arrays;

static void release_arrays(mesh_arrays *arrays) {
  array_release(&arrays->positions);
  array_release(&arrays->triangles);
  array_release(&arrays->normals);
  array_release(&arrays->materials);
  array_release(&arrays->corners);
  for (int i = 0; i < 5; i++)
    PyMem_Free(arrays->owned[i]);
}

static bool read_surface(module_state *state, PyObject *positions, PyObject *triangles,
                         mesh_arrays *arrays) {
  if (!array_read(state, positions, "positions", ARRAY_REAL, &arrays->positions) ||
      !array_check_shape(&arrays->positions, "positions", "(n, 3)", 2, (Py_ssize_t[]){-1, 3}) ||
      !array_read(state, triangles, "triangles", ARRAY_WHOLE, &arrays->triangles) ||
      !array_check_shape(&arrays->triangles, "triangles", "(m, 3)", 2, (Py_ssize_t[]){-1, 3}))
    return false;
  whittle_mesh *mesh = &arrays->mesh;
  mesh->vertex_count = (size_t)arrays->positions.buffer.shape[0];
  mesh->triangle_count = (size_t)arrays->triangles.buffer.shape[0];
  mesh->positions = array_floats(&arrays->positions, &arrays->owned[0]);
  mesh->triangles = array_uints(&arrays->triangles, "triangles", &arrays->owned[1]);
  return mesh->positions && mesh->triangles;
}

/* Whether the view has WIDTH numbers for each vertex or for each corner; else ValueError. With as
 * many vertices as triangles the number of axes tells them apart. */
static bool by_vertex_or_corner(const array_view *view, const char *name, const whittle_mesh *mesh,
                                Py_ssize_t width, int *by_corner) {
  const Py_ssize_t n = (Py_ssize_t)mesh->vertex_count, m = (Py_ssize_t)mesh->triangle_count;
  *by_corner = array_has_shape(view, 3, (Py_ssize_t[]){m, 3, width});
  if (*by_corner || array_has_shape(view, 2, (Py_ssize_t[]){n, width}))
    return true;
  char text[80];
  PyOS_snprintf(text, sizeof text, "(%lld, %lld) or (%lld, 3, %lld)", (long long)n,
                (long long)width, (long long)m, (long long)width);
  return array_check_shape(view, name, text, -1, NULL);
}

static bool by_polygon_corner(const array_view *view, const whittle_mesh *mesh) {
  const Py_ssize_t shape[] = {(Py_ssize_t)mesh->corner_count, 3};
  char text[32];
  PyOS_snprintf(text, sizeof text, "(%lld, 3)", (long long)shape[0]);
  return array_check_shape(view, "normals", text, 2, shape);
}

static bool read_normals(module_state *state, PyObject *normals, mesh_arrays *arrays) {
  whittle_mesh *mesh = &arrays->mesh;
  if (normals == Py_None)
    return true;
  if (!array_read(state, normals, "normals", ARRAY_REAL, &arrays->normals))
    return false;
  mesh->normals_by_corner = mesh->corners != NULL;
  const bool fits = mesh->corners ? by_polygon_corner(&arrays->normals, mesh)
                                  : by_vertex_or_corner(&arrays->normals, "normals", mesh, 3,
                                                        &mesh->normals_by_corner);
  return fits && (mesh->normals = array_floats(&arrays->normals, &arrays->owned[2]));
}

static bool read_materials(module_state *state, PyObject *materials, mesh_arrays *arrays) {
  whittle_mesh *mesh = &arrays->mesh;
  if (materials == Py_None)
    return true;
  const Py_ssize_t shape[] = {(Py_ssize_t)mesh->triangle_count};
  char text[32];
  PyOS_snprintf(text, sizeof text, "(%lld,)", (long long)shape[0]);
  return array_read(state, materials, "materials", ARRAY_WHOLE, &arrays->materials) &&
         array_check_shape(&arrays->materials, "materials", text, 1, shape) &&
         (mesh->materials = array_uints(&arrays->materials, "materials", &arrays->owned[3]));
}

static bool read_corners(module_state *state, PyObject *corners, mesh_arrays *arrays) {
  whittle_mesh *mesh = &arrays->mesh;
  if (corners == Py_None)
    return true;
  if (!array_read(state, corners, "corners", ARRAY_WHOLE, &arrays->corners) ||
      !array_check_shape(&arrays->corners, "corners", "(k,)", 1, (Py_ssize_t[]){-1}))
    return false;
  mesh->corner_count = (size_t)arrays->corners.buffer.shape[0];
  return (mesh->corners = array_uints(&arrays->corners, "corners", &arrays->owned[4])) != NULL;
}

static bool check_uv_map(module_state *state, PyObject *key, PyObject *uvs,
                         const whittle_mesh *mesh) {
  if (!PyUnicode_Check(key))
    return raise_value("uvs", "must have names as its keys, not %R", key);
  PyObject *label = PyUnicode_FromFormat("uvs[%R]", key);
  PyObject *bytes = label ? PyUnicode_AsUTF8String(label) : NULL;
  const char *name = bytes ? PyBytes_AsString(bytes) : NULL;
  array_view view = {0};
  int by_corner;
  const bool good = name && array_read(state, uvs, name, ARRAY_REAL, &view) &&
                    by_vertex_or_corner(&view, name, mesh, 2, &by_corner);
  array_release(&view);
  Py_XDECREF(bytes);
  Py_XDECREF(label);
  return good;
}

/* Nothing reads texture coordinates yet, so they are checked and not kept. */
static bool check_uvs(module_state *state, PyObject *uvs, const whittle_mesh *mesh) {
  PyObject *maps = uvs == Py_None ? PyDict_New() : argument_mapping(uvs, "uvs", NULL);
  PyObject *key, *value;
  Py_ssize_t position = 0;
  bool good = maps != NULL;
  while (good && PyDict_Next(maps, &position, &key, &value))
    good = check_uv_map(state, key, value, mesh);
  Py_XDECREF(maps);
  return good;
}

/* What add_mesh and replace_mesh are given, but not yet read. */
typedef struct mesh_arguments {
  PyObject *positions, *triangles, *normals, *uvs, *materials, *corners, *keep;
} mesh_arguments;

/* Called by the core when a mesh goes, whichever thread that is on. */
static void release_kept(void *owner) {
  const PyGILState_STATE state = PyGILState_Ensure();
  release_arrays(owner);
  PyMem_Free(owner);
  PyGILState_Release(state);
}

/* An array that nobody can write to by accident; an absent one is fine. */
static bool can_keep(const array_view *view, const void *owned, const char *name) {
  if (!view->buffer.obj || (view->buffer.readonly && !owned))
    return true;
  return raise_value(name, "must be read-only, of the core's own type and without gaps to be kept");
}

/* Lets the core use the arrays as they are, from a place of their own. With corners it copies
 * triangles and normals. */
static bool keep_arrays(mesh_arrays *arrays) {
  if (!can_keep(&arrays->positions, arrays->owned[0], "positions") ||
      !can_keep(&arrays->triangles, arrays->owned[1], "triangles") ||
      !can_keep(&arrays->normals, arrays->owned[2], "normals") ||
      !can_keep(&arrays->materials, arrays->owned[3], "materials"))
    return false;
  mesh_arrays *kept = PyMem_Calloc(1, sizeof *kept);
  if (!kept)
    return PyErr_NoMemory();
  kept->positions = arrays->positions;
  kept->materials = arrays->materials;
  if (!arrays->mesh.corners) {
    kept->triangles = arrays->triangles;
    kept->normals = arrays->normals;
  }
  arrays->mesh.release = release_kept;
  arrays->mesh.owner = kept;
  return true;
}

static bool read_mesh(module_state *state, const mesh_arguments *from, mesh_arrays *arrays) {
  int keep = 0;
  return (!from->keep || argument_flag(from->keep, "keep", &keep)) &&
         read_surface(state, from->positions, from->triangles, arrays) &&
         read_corners(state, from->corners, arrays) && read_normals(state, from->normals, arrays) &&
         read_materials(state, from->materials, arrays) &&
         check_uvs(state, from->uvs, &arrays->mesh) && (!keep || keep_arrays(arrays));
}

/* Gives up what no mesh of the core keeps. */
static void end_mesh(mesh_arrays *arrays, bool added) {
  const array_view none = {0};
  if (!added)
    PyMem_Free(arrays->mesh.owner);
  if (added && arrays->mesh.owner) {
    arrays->positions = arrays->materials = none;
    if (!arrays->mesh.corners)
      arrays->triangles = arrays->normals = none;
  }
  release_arrays(arrays);
}

PyObject *scene_add_mesh(PyObject *self, PyObject *args, PyObject *kwargs) {
  static char *names[] = {"positions", "triangles", "normals", "uvs",
                          "materials", "corners",   "keep",    NULL};
  mesh_arguments from = {
      .normals = Py_None, .uvs = Py_None, .materials = Py_None, .corners = Py_None};
  if (!PyArg_ParseTupleAndKeywords(args, kwargs, "OO|OOO$OO:add_mesh", names, &from.positions,
                                   &from.triangles, &from.normals, &from.uvs, &from.materials,
                                   &from.corners, &from.keep))
    return NULL;
  module_state *state = state_of(self);
  mesh_arrays arrays = {0};
  bool added = false;
  PyObject *result = NULL;
  if (read_mesh(state, &from, &arrays)) {
    uint32_t index = 0;
    whittle_error error = {0};
    whittle_status status;
    Py_BEGIN_ALLOW_THREADS status =
        whittle_scene_add_mesh(scene_handle(self), &arrays.mesh, &index, &error);
    Py_END_ALLOW_THREADS result =
        status ? raise_status(state, status, &error) : PyLong_FromUnsignedLong(index);
    added = status == WHITTLE_OK;
  }
  end_mesh(&arrays, added);
  return result;
}

PyObject *scene_replace_mesh(PyObject *self, PyObject *args, PyObject *kwargs) {
  static char *names[] = {"mesh",      "positions", "triangles", "normals", "uvs",
                          "materials", "corners",   "keep",      NULL};
  mesh_arguments from = {
      .normals = Py_None, .uvs = Py_None, .materials = Py_None, .corners = Py_None};
  PyObject *number;
  uint32_t mesh;
  if (!PyArg_ParseTupleAndKeywords(args, kwargs, "OOO|OOO$OO:replace_mesh", names, &number,
                                   &from.positions, &from.triangles, &from.normals, &from.uvs,
                                   &from.materials, &from.corners, &from.keep) ||
      !argument_uint32(number, "mesh", 0, &mesh))
    return NULL;
  module_state *state = state_of(self);
  mesh_arrays arrays = {0};
  bool added = false;
  PyObject *result = NULL;
  if (read_mesh(state, &from, &arrays)) {
    whittle_error error = {0};
    whittle_status status;
    Py_BEGIN_ALLOW_THREADS status =
        whittle_scene_replace_mesh(scene_handle(self), mesh, &arrays.mesh, &error);
    Py_END_ALLOW_THREADS result = status ? raise_status(state, status, &error) : Py_BuildValue("");
    added = status == WHITTLE_OK;
  }
  end_mesh(&arrays, added);
  return result;
}

PyObject *scene_add_instance(PyObject *self, PyObject *args, PyObject *kwargs) {
  static char *names[] = {"mesh", "transform", "object_id", "visibility", NULL};
  PyObject *mesh_object, *matrix, *id_object = NULL, *visibility_object = NULL;
  if (!PyArg_ParseTupleAndKeywords(args, kwargs, "OO|OO:add_instance", names, &mesh_object, &matrix,
                                   &id_object, &visibility_object))
    return NULL;
  module_state *state = state_of(self);
  uint32_t mesh, visibility = WHITTLE_ALL, index = 0;
  int32_t object_id = 0;
  double transform[16];
  if (!argument_uint32(mesh_object, "mesh", 0, &mesh) ||
      !array_matrix(state, matrix, "transform", transform) ||
      (id_object && !argument_int32(id_object, "object_id", &object_id)) ||
      (visibility_object && !argument_uint32(visibility_object, "visibility", 0, &visibility)))
    return NULL;
  whittle_error error = {0};
  const whittle_status status = whittle_scene_add_instance(scene_handle(self), mesh, transform,
                                                           object_id, visibility, &index, &error);
  return status ? raise_status(state, status, &error) : PyLong_FromUnsignedLong(index);
}
