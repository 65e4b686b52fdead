/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Generated scenes, and the names of all scenes. */

#include "scenes.h"

#include "buildings.h"
#include "fail.h"
#include "obj.h"
#include "ply.h"
#include "random.h"
#include "shapes.h"
#include "terrain.h"

#include <stdlib.h>
#include <string.h>

const char scenes_help[] =
    "FILE.obj, FILE.ply, stadium, stadium-near, atrium, spheres, terrain:N, slivers:N (about N "
    "triangles), any with +ground behind";

/* 7 x 7 spheres of various sizes standing on a square floor. */
static mesh make_spheres(void) {
  shapes s = {0};
  random_state state = random_seed(1);
  for (size_t i = 0; i < 49; i++) {
    float radius = 0.25f + 0.22f * random_unit(&state);
    vector centre = {(float)(i % 7) - 3, radius, (float)(i / 7) - 3};
    shapes_add_sphere(&s, centre, radius, 96, 48);
  }
  shapes_add_quad(&s, (vector){-6, 0, -6}, (vector){0, 0, 12}, (vector){12, 0, 0});
  mesh m = s.mesh;
  m.camera = (camera){{3.4f, 3.2f, 6.2f}, {0, 0.1f, 0.4f}, {0, 1, 0}, 45};
  m.light = (vector){-4, 7, 3};
  m.has_camera = m.has_light = 1;
  return m;
}

/* A ball of hairs a thousand times as long as wide, in all directions. */
static mesh make_slivers(size_t triangles) {
  mesh m = mesh_new(triangles * 3, triangles);
  random_state state = random_seed(2);
  for (size_t i = 0; i < triangles; i++) {
    vector start = scale(random_direction(&state), random_unit(&state));
    vector along = scale(random_direction(&state), 0.4f);
    vector across = scale(random_direction(&state), 0.0004f);
    vector end = add(start, along), side = add(start, across);
    const vector corners[3] = {start, end, side};
    memcpy(m.positions + i * 9, corners, sizeof(corners));
    for (size_t k = 0; k < 3; k++)
      m.triangles[i * 3 + k] = (uint32_t)(i * 3 + k);
  }
  return m;
}

static int ends_with(const char *text, const char *end) {
  size_t n = strlen(text), k = strlen(end);
  return n >= k && strcmp(text + n - k, end) == 0;
}

/* The N of "kind:N", or 0 if the name is of another kind. */
static size_t count_of(const char *name, const char *kind) {
  size_t n = strlen(kind);
  if (strncmp(name, kind, n) != 0 || name[n] != ':')
    return 0;
  char *end;
  unsigned long count = strtoul(name + n + 1, &end, 10);
  if (*end != '\0' || count < 2 || count > 100000000)
    fail("%s: the number of triangles must be from 2 to 100000000", name);
  return count;
}

static mesh load_named(const char *name) {
  size_t count;
  if (ends_with(name, ".obj"))
    return obj_read(name);
  if (ends_with(name, ".ply"))
    return ply_read(name);
  if (strcmp(name, "stadium") == 0 || strcmp(name, "stadium-near") == 0)
    return buildings_stadium(strcmp(name, "stadium") != 0);
  if (strcmp(name, "atrium") == 0)
    return buildings_atrium();
  if (strcmp(name, "spheres") == 0)
    return make_spheres();
  if ((count = count_of(name, "terrain")) != 0)
    return terrain_make(count);
  if ((count = count_of(name, "slivers")) != 0)
    return make_slivers(count);
  fail("no scene is called %s; scenes are %s", name, scenes_help);
}

mesh scenes_load(const char *name, float aspect) {
  char *base = strdup(name);
  int ground = ends_with(name, "+ground");
  if (ground)
    base[strlen(base) - strlen("+ground")] = '\0';
  mesh m = load_named(base);
  free(base);
  if (ground) {
    if (!m.has_camera)
      mesh_complete(&m, aspect); /* so that the camera looks at the mesh, not at the ground */
    mesh_add_ground(&m);
  }
  mesh_complete(&m, aspect);
  return m;
}

char *scenes_label(const char *name) {
  const char *slash = strrchr(name, '/');
  char *label = strdup(slash ? slash + 1 : name);
  for (const char *const *kind = (const char *const[]){".obj", ".ply", NULL}; *kind; kind++) {
    char *end = strstr(label, *kind);
    if (end)
      memmove(end, end + 4, strlen(end + 4) + 1);
  }
  return label;
}
