/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What the benchmark uses of the C interface of Embree 4, which it loads at run time. */

#ifndef BENCH_EMBREE_ABI_H
#define BENCH_EMBREE_ABI_H

#include <stdbool.h>
#include <stdint.h>
#include <sys/types.h>

/* Handles. */
typedef struct embree_device embree_device;
typedef struct embree_scene embree_scene;
typedef struct embree_geometry embree_geometry;

enum {
  EMBREE_VERSION_MAJOR = 1, /* device properties */
  EMBREE_VERSION_MINOR = 2,
  EMBREE_VERSION_PATCH = 3,
  EMBREE_NATIVE_8 = 33,
  EMBREE_NATIVE_16 = 34,
  EMBREE_TRIANGLES = 0, /* geometry type */
  EMBREE_INDICES = 0,   /* buffer types */
  EMBREE_VERTICES = 1,
  EMBREE_UINT3 = 0x5003, /* formats */
  EMBREE_FLOAT3 = 0x9003,
  EMBREE_LOW = 0, /* build qualities */
  EMBREE_MEDIUM = 1,
  EMBREE_HIGH = 2,
  EMBREE_ROBUST = 4,         /* scene flag */
  EMBREE_COHERENT = 1 << 16, /* query flag */
};

#define EMBREE_NOTHING UINT32_MAX /* the index of what was not hit */

/* Ends every hit: instance indices, as many as the library was built to nest, and room to spare. */
enum { EMBREE_INSTANCE_WORDS = 8 };

typedef struct embree_ray {
  float origin[3], t_near;
  float direction[3], time;
  float t_far; /* becomes the hit's t, or -infinity where only asked whether there is a hit */
  uint32_t mask, id, flags;
} __attribute__((aligned(16))) embree_ray;

typedef struct embree_ray_hit {
  embree_ray ray;
  float normal[3], u, v;
  uint32_t triangle, geometry, instance[EMBREE_INSTANCE_WORDS];
} __attribute__((aligned(16))) embree_ray_hit;

/* The arguments of a query; zero and all features otherwise. */
typedef struct embree_query {
  uint32_t flags, features;
  void *context;
  void (*filter)(void *);
  void (*callback)(void *);
  uint64_t spare[4]; /* for libraries built with options that lengthen it */
} embree_query;

/* The functions, in the order of their names' table in embree.c. */
typedef struct embree_library {
  embree_device *(*new_device)(const char *config);
  void (*release_device)(embree_device *);
  ssize_t (*property)(embree_device *, int property);
  int (*error)(embree_device *);
  void (*monitor_memory)(embree_device *, bool (*)(void *, ssize_t, bool), void *user);
  embree_scene *(*new_scene)(embree_device *);
  void (*release_scene)(embree_scene *);
  void (*set_flags)(embree_scene *, int flags);
  void (*set_quality)(embree_scene *, int quality);
  void (*commit_scene)(embree_scene *);
  embree_geometry *(*new_geometry)(embree_device *, int type);
  void (*release_geometry)(embree_geometry *);
  void (*commit_geometry)(embree_geometry *);
  void (*share_buffer)(embree_geometry *, int type, unsigned slot, int format, const void *data,
                       size_t offset, size_t stride, size_t count);
  unsigned (*attach)(embree_scene *, embree_geometry *);
  void (*closest_1)(embree_scene *, embree_ray_hit *, embree_query *);
  void (*any_1)(embree_scene *, embree_ray *, embree_query *);
  void (*closest_4)(const int *, embree_scene *, void *, embree_query *);
  void (*any_4)(const int *, embree_scene *, void *, embree_query *);
  void (*closest_8)(const int *, embree_scene *, void *, embree_query *);
  void (*any_8)(const int *, embree_scene *, void *, embree_query *);
  void (*closest_16)(const int *, embree_scene *, void *, embree_query *);
  void (*any_16)(const int *, embree_scene *, void *, embree_query *);
} embree_library;

#endif
