/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Cameras and settings from Python, and new images. */

#include "request.h"

#include "arguments.h"

#include <string.h>

/* A dict, and how its items are called in messages. */
typedef struct items {
  PyObject *dict;
  const char *owner;
  char name[NAME_SIZE]; /* of the item last looked for */
} items;

/* Borrowed; NULL without an exception if it is not there. */
static PyObject *item(items *from, const char *key) {
  name_key(from->name, from->owner, key);
  return PyDict_GetItemString(from->dict, key);
}

static PyObject *needed(items *from, const char *key) {
  PyObject *value = item(from, key);
  return value ? value : raise_value(from->name, "is missing");
}

/* An item that may be missing leaves the value alone. */
static bool get_uint32(items *from, const char *key, uint32_t least, uint32_t *value) {
  PyObject *object = item(from, key);
  return !object || argument_uint32(object, from->name, least, value);
}

static bool get_flag(items *from, const char *key, int *value) {
  PyObject *object = item(from, key);
  return !object || argument_flag(object, from->name, value);
}

static bool get_distance(items *from, const char *key, double *value) {
  PyObject *object = item(from, key);
  return !object || (argument_double(object, from->name, value) &&
                     (*value >= 0 || raise_value(from->name, "must be 0 or more, not %R", object)));
}

static bool get_word(items *from, const char *key, const char *const *words, int *place) {
  PyObject *object = item(from, key);
  return !object || argument_word(object, from->name, words, place);
}

/* ---- Camera ---- */

static bool get_matrix(module_state *state, items *from, const char *key, double out[16]) {
  PyObject *object = needed(from, key);
  return object && array_matrix(state, object, from->name, out);
}

static bool get_size(items *from, const char *key, uint32_t *value) {
  PyObject *object = needed(from, key);
  return object && argument_uint32(object, from->name, 1, value);
}

static bool get_region(items *from, whittle_camera *camera) {
  uint32_t *const region = camera->region;
  PyObject *object = item(from, "region");
  memcpy(region, (uint32_t[]){0, 0, camera->width, camera->height}, sizeof camera->region);
  if (!object || object == Py_None)
    return true;
  PyObject *list = argument_sequence(object, from->name);
  bool good = list && (PyList_Size(list) == 4 ||
                       raise_value(from->name, "must be four integers: x0, y0, x1, y1"));
  for (int i = 0; good && i < 4; i++)
    good = argument_uint32(PyList_GetItem(list, i), from->name, 0, &region[i]);
  Py_XDECREF(list);
  if (!good)
    return false;
  return (region[0] < region[2] && region[2] <= camera->width && region[1] < region[3] &&
          region[3] <= camera->height) ||
         raise_value(from->name, "must be x0 < x1 <= %d and y0 < y1 <= %d, not %R",
                     (int)camera->width, (int)camera->height, object);
}

static bool read_camera(module_state *state, PyObject *object, whittle_camera *camera) {
  static const char *const keys[] = {"to_world",   "projection", "width",  "height",
                                     "clip_start", "clip_end",   "region", NULL};
  items from = {.dict = argument_mapping(object, "camera", keys), .owner = "camera"};
  const bool good = from.dict && get_matrix(state, &from, "to_world", camera->to_world) &&
                    get_matrix(state, &from, "projection", camera->projection) &&
                    get_size(&from, "width", &camera->width) &&
                    get_size(&from, "height", &camera->height) &&
                    get_distance(&from, "clip_start", &camera->clip_start) &&
                    get_distance(&from, "clip_end", &camera->clip_end) && get_region(&from, camera);
  Py_XDECREF(from.dict);
  return good;
}

/* ---- Settings ---- */

static bool pass_by_name(PyObject *object, const char *name, whittle_pass *pass) {
  const char *words[WHITTLE_PASS_COUNT + 1] = {0};
  for (int i = 0; i < WHITTLE_PASS_COUNT; i++)
    words[i] = whittle_pass_name((whittle_pass)i);
  int place;
  if (!argument_word(object, name, words, &place))
    return false;
  *pass = (whittle_pass)place;
  return true;
}

static bool has_pass(const render_request *request, whittle_pass pass) {
  for (int i = 0; i < request->pass_count; i++)
    if (request->passes[i] == pass)
      return true;
  return false;
}

static bool get_passes(items *from, render_request *request) {
  PyObject *object = item(from, "passes");
  if (!object)
    return true;
  PyObject *list = argument_sequence(object, from->name);
  const Py_ssize_t length = list ? PyList_Size(list) : 0;
  bool good = list != NULL;
  request->pass_count = 0;
  for (Py_ssize_t i = 0; good && i < length; i++) {
    whittle_pass pass;
    good = pass_by_name(PyList_GetItem(list, i), from->name, &pass);
    if (good && !has_pass(request, pass))
      request->passes[request->pass_count++] = pass;
  }
  Py_XDECREF(list);
  return good && (request->pass_count > 0 || raise_value(from->name, "must name a pass"));
}

/* Zero means zero here, where for the core it means the default. */
static bool get_depth(items *from, whittle_settings *settings) {
  PyObject *object = item(from, "max_depth");
  if (object && !argument_uint32(object, from->name, 0, &settings->max_depth))
    return false;
  settings->no_bounces = object && settings->max_depth == 0;
  return true;
}

static bool get_cutoff(items *from, whittle_settings *settings) {
  PyObject *object = item(from, "cutoff");
  if (object && !argument_float(object, from->name, &settings->cutoff))
    return false;
  settings->no_cutoff = object && settings->cutoff == 0;
  return true;
}

static bool get_modes(items *from, whittle_settings *settings) {
  static const char *const patterns[] = {"regular", "stratified", NULL};
  static const char *const modes[] = {"fast", "lecture", "single", NULL};
  int pattern = WHITTLE_REGULAR, mode = WHITTLE_FAST;
  if (!get_word(from, "pattern", patterns, &pattern) || !get_word(from, "mode", modes, &mode))
    return false;
  settings->pattern = (whittle_pattern)pattern;
  settings->mode = (whittle_mode)mode;
  return true;
}

static bool read_settings(PyObject *object, render_request *request) {
  static const char *const keys[] = {"passes",  "samples",     "pattern", "seed",   "max_depth",
                                     "cutoff",  "transparent", "mode",    "packet", "threads",
                                     "generic", "cost",        NULL};
  whittle_settings *settings = &request->settings;
  request->passes[request->pass_count++] = WHITTLE_PASS_COMBINED;
  if (!object || object == Py_None)
    return true;
  items from = {.dict = argument_mapping(object, "settings", keys), .owner = "settings"};
  const bool good = from.dict && get_passes(&from, request) &&
                    get_uint32(&from, "samples", 1, &settings->samples) &&
                    get_uint32(&from, "seed", 0, &settings->seed) && get_depth(&from, settings) &&
                    get_cutoff(&from, settings) && get_modes(&from, settings) &&
                    get_flag(&from, "transparent", &settings->transparent) &&
                    get_uint32(&from, "packet", 0, &settings->packet) &&
                    get_uint32(&from, "threads", 0, &settings->threads) &&
                    get_flag(&from, "generic", &settings->generic) &&
                    get_flag(&from, "cost", &request->cost);
  Py_XDECREF(from.dict);
  return good;
}

bool request_read(module_state *state, PyObject *camera, PyObject *settings,
                  render_request *request) {
  *request = (render_request){0};
  return read_camera(state, camera, &request->camera) && read_settings(settings, request);
}

/* ---- Images ---- */

static bool add_image(module_state *state, const whittle_camera *camera, whittle_pass pass,
                      render_images *images) {
  const Py_ssize_t shape[] = {camera->region[3] - camera->region[1],
                              camera->region[2] - camera->region[0], whittle_pass_channels(pass)};
  if ((double)shape[0] * (double)shape[1] * 16 > (double)(PY_SSIZE_T_MAX / 2))
    return PyErr_Format(PyExc_MemoryError, "no memory holds an image of %zd x %zd pixels", shape[1],
                        shape[0]);
  void *data = NULL;
  PyObject *array = array_new_of(state, 3, shape, "f4", &images->views[pass], &data);
  images->image.pass[pass] = data;
  const bool good =
      array && PyDict_SetItemString(images->dict, whittle_pass_name(pass), array) == 0;
  Py_XDECREF(array);
  return good;
}

static bool add_cost(module_state *state, const whittle_scene *scene, render_images *images) {
  PyObject *cost = cost_tables_new(state, scene, &images->tables);
  images->image.cost = &images->tables.cost;
  const bool good = cost && PyDict_SetItemString(images->dict, "cost", cost) == 0;
  Py_XDECREF(cost);
  return good;
}

bool images_new(module_state *state, const whittle_scene *scene, const render_request *request,
                render_images *images) {
  *images = (render_images){.dict = PyDict_New()};
  bool good = images->dict != NULL;
  for (int i = 0; good && i < request->pass_count; i++)
    good = add_image(state, &request->camera, request->passes[i], images);
  return good && (!request->cost || add_cost(state, scene, images));
}

void images_unhold(render_images *images) {
  for (int i = 0; i < WHITTLE_PASS_COUNT; i++)
    array_release(&images->views[i]);
  cost_tables_release(&images->tables);
}

void images_release(render_images *images) {
  images_unhold(images);
  Py_CLEAR(images->dict);
}
