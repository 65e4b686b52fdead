/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Loading Embree, and its devices and scenes. */

#include "embree.h"

#include "clock.h"
#include "fail.h"

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>

static const char *const names[] = {
    "rtcNewDevice",
    "rtcReleaseDevice",
    "rtcGetDeviceProperty",
    "rtcGetDeviceError",
    "rtcSetDeviceMemoryMonitorFunction",
    "rtcNewScene",
    "rtcReleaseScene",
    "rtcSetSceneFlags",
    "rtcSetSceneBuildQuality",
    "rtcCommitScene",
    "rtcNewGeometry",
    "rtcReleaseGeometry",
    "rtcCommitGeometry",
    "rtcSetSharedGeometryBuffer",
    "rtcAttachGeometry",
    "rtcIntersect1",
    "rtcOccluded1",
    "rtcIntersect4",
    "rtcOccluded4",
    "rtcIntersect8",
    "rtcOccluded8",
    "rtcIntersect16",
    "rtcOccluded16",
};

enum { NAMES = sizeof(names) / sizeof(names[0]) };

_Static_assert(sizeof(embree_library) == NAMES * sizeof(void *), "one name a function");

void embree_load(embree *e, const char *path) {
  memset(e, 0, sizeof(*e));
  void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (!library)
    fail("cannot load Embree: %s", dlerror());
  for (int i = 0; i < NAMES; i++) {
    void *symbol = dlsym(library, names[i]);
    if (!symbol)
      fail("%s has no %s: the benchmark needs Embree 4", path, names[i]);
    memcpy((char *)&e->library + (size_t)i * sizeof(void *), &symbol, sizeof(void *));
  }
}

static void check(const embree *e, const char *what) {
  int error = e->library.error(e->device);
  if (error != 0)
    fail("Embree fails to %s: its error %d", what, error);
}

static bool count_bytes(void *user, ssize_t bytes, bool after) {
  (void)after;
  __atomic_fetch_add((long long *)user, (long long)bytes, __ATOMIC_RELAXED);
  return true;
}

static void add_mode(embree *e, const char *name, unsigned width, int coherent) {
  e->modes[e->mode_count++] = (embree_mode){name, width, coherent};
}

/* Packets narrower than the widest native ones are kept only beside AVX-512's, where 8 rays were
 * the best for streams without any coherence. Without AVX-512 Embree splits packets of 16. */
static void list_modes(embree *e) {
  int native_8 = e->library.property(e->device, EMBREE_NATIVE_8) != 0;
  int native_16 = e->library.property(e->device, EMBREE_NATIVE_16) != 0;
  e->mode_count = 0;
  add_mode(e, "1", 1, 0);
  if (!native_8) {
    add_mode(e, "4", 4, 0);
    add_mode(e, "4 coherent", 4, 1);
    return;
  }
  add_mode(e, "8", 8, 0);
  add_mode(e, "8 coherent", 8, 1);
  if (native_16)
    add_mode(e, "16", 16, 0);
  add_mode(e, "16 coherent", 16, 1);
}

void embree_open(embree *e, unsigned threads, const char *isa) {
  char config[64];
  snprintf(config, sizeof(config), "threads=%u%s%s", threads, isa ? ",isa=" : "", isa ? isa : "");
  e->device = e->library.new_device(config);
  if (!e->device)
    fail("Embree refuses the device \"%s\": its error %d", config, e->library.error(NULL));
  check(e, "open a device");
  e->bytes = 0;
  e->library.monitor_memory(e->device, count_bytes, &e->bytes);
  snprintf(e->version, sizeof(e->version), "%zd.%zd.%zd",
           e->library.property(e->device, EMBREE_VERSION_MAJOR),
           e->library.property(e->device, EMBREE_VERSION_MINOR),
           e->library.property(e->device, EMBREE_VERSION_PATCH));
  if (strncmp(e->version, "4.", 2) != 0)
    fail("the library is Embree %s: the benchmark needs Embree 4", e->version);
  list_modes(e);
}

void embree_close(embree *e) {
  e->library.release_device(e->device);
  e->device = NULL;
}

static void set_quality(const embree *e, const char *quality) {
  static const char *const known[] = {"low", "medium", "high", "robust"};
  static const int levels[] = {EMBREE_LOW, EMBREE_MEDIUM, EMBREE_HIGH, EMBREE_MEDIUM};
  for (int i = 0; i < 4; i++)
    if (strcmp(quality, known[i]) == 0) {
      e->library.set_quality(e->scene, levels[i]);
      e->library.set_flags(e->scene, i == 3 ? EMBREE_ROBUST : 0);
      return;
    }
  fail("Embree's quality is low, medium, high or robust, not %s", quality);
}

double embree_build(embree *e, unsigned place, const mesh *m, const char *quality) {
  const embree_library *l = &e->library;
  e->scenes[place] = l->new_scene(e->device);
  embree_choose(e, place);
  set_quality(e, quality);
  embree_geometry *geometry = l->new_geometry(e->device, EMBREE_TRIANGLES);
  l->share_buffer(geometry, EMBREE_VERTICES, 0, EMBREE_FLOAT3, m->positions, 0, 3 * sizeof(float),
                  m->vertex_count);
  l->share_buffer(geometry, EMBREE_INDICES, 0, EMBREE_UINT3, m->triangles, 0, 3 * sizeof(uint32_t),
                  m->triangle_count);
  l->commit_geometry(geometry);
  l->attach(e->scene, geometry);
  l->release_geometry(geometry);
  check(e, "take the mesh");
  double start = clock_seconds();
  l->commit_scene(e->scene);
  double seconds = clock_seconds() - start;
  check(e, "build");
  return seconds;
}

void embree_choose(embree *e, unsigned place) {
  e->scene = e->scenes[place];
}

void embree_release(embree *e) {
  for (unsigned i = 0; i < EMBREE_BUILDS; i++)
    if (e->scenes[i])
      e->library.release_scene(e->scenes[i]);
  memset(e->scenes, 0, sizeof(e->scenes));
  e->scene = NULL;
}
