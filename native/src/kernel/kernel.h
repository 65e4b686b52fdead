/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The interface to what is compiled once for each instruction set. */

#pragma once

#include "scene/rays.h"

#include <stdint.h>

#define WHITTLE_NONE UINT32_MAX
#define WHITTLE_MAX_PACKET 1024

/* Rays in scene space as structures of arrays. Arrays are readable and writable up to the next
 * multiple of WHITTLE_LANE_PAD entries past `count`; the padding is the traversal's to fill. */
#define WHITTLE_LANE_PAD 16
typedef struct ray_stream {
  uint32_t count;
  bool one_origin; /* known to be the same for all rays; else that is found out */
  float *origin[3];
  float *direction[3];
  float *t_min;
  float *t;         /* in: t_max; out: t of the hit */
  float *u, *v;     /* out: weights of the second and third vertex */
  uint32_t *record; /* out: index into scene->triangles, or WHITTLE_NONE */
  uint32_t *skip;   /* index into scene->triangles that this ray must not hit */
  uint32_t *nodes;  /* out if counting: nodes visited and triangles tested */
  uint32_t *triangles;
} ray_stream;

/* What the three tests of the lecture decided, over the packets of one worker. */
typedef struct packet_counters {
  uint64_t packets, nodes, rays;
  uint64_t decided_first, decided_frustum, decided_brute_force;
  uint64_t active_rays, visited_rays;
  uint64_t node_lanes, node_lanes_used, triangle_lanes, triangle_lanes_used;
} packet_counters;

/* What the packets of a worker have shown of those of the same kind of rays to come. */
typedef struct packet_memory {
  uint32_t viewless;     /* rays that go without a view before the next packet is tried */
  uint32_t doublings;    /* of that number, since a view last paid */
  uint32_t rays, leaves; /* without a view, lately, and the leaves that each of them visited */
} packet_memory;

typedef struct trace_context {
  const whittle_scene *scene;
  whittle_mode mode;
  uint32_t packet;     /* rays in a packet */
  uint32_t visibility; /* instances that share no bit with it are not seen */
  bool masked;         /* some instance is hidden from some rays; else visibility is not read */
  bool count;          /* fill nodes and triangles */
  const struct ray_watch *watch; /* NULL: nothing more is wanted */
  packet_counters *packets;      /* of the lecture mode */
  packet_memory *memory;         /* of the other */
  uint64_t *own_box_misses;
} trace_context;

struct tile_context;
struct tile_worker;

typedef struct kernel_table {
  uint32_t lanes;
  /* The caller's rays first .. first + count - 1 into scene space, and what they hit out again:
   * `rays` is the stream over the chunk, after `closest`. */
  void (*load)(const scene_frame *frame, const whittle_rays *rays, size_t first, uint32_t count,
               ray_chunk *chunk);
  void (*give)(const whittle_scene *scene, const ray_chunk *chunk, const ray_stream *rays,
               const whittle_hits *hits, size_t first);
  /* The same after `any`: 1 or 0 for each ray. */
  void (*give_blocked)(const ray_stream *rays, uint8_t *blocked);
  /* The nearest hit of each ray of the stream, and whether anything is hit at all. */
  void (*closest)(const trace_context *context, ray_stream *rays);
  void (*any)(const trace_context *context, ray_stream *rays);
  /* Renders a tile; false if memory for its rays ran out. */
  bool (*render_tile)(const struct tile_context *context, struct tile_worker *worker,
                      uint32_t tile);
} kernel_table;

/* The table of the instruction set in use, or NULL and an error. */
const kernel_table *whittle_kernels(whittle_error *error);

extern const kernel_table whittle_kernel_sse42, whittle_kernel_avx2, whittle_kernel_avx512;
