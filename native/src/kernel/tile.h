/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What a render shares between its tiles, and what each worker holds for itself. */

#pragma once

#include "kernel/batch.h"
#include "kernel/watch.h"

#include <stdatomic.h>

/* Samples that a tile has on their way at once: all of a pixel's, which see nearly the same, and of
 * as many pixels as they leave room for. */
#define WHITTLE_TILE_SLOTS 4096
#define WHITTLE_TILE_EDGE 32 /* pixels at most */
#define WHITTLE_TILE_PIXELS (WHITTLE_TILE_EDGE * WHITTLE_TILE_EDGE)

/* Rays of the camera in scene space: affine in the pixel coordinates x and y. */
typedef struct camera_rays {
  float origin[3], origin_x[3], origin_y[3];
  float direction[3], direction_x[3], direction_y[3];
  float t_min, t_max;
} camera_rays;

/* A light in scene space. */
typedef struct light_record {
  float place[3]; /* point: position; sun: direction towards it */
  float intensity[3];
  whittle_light_kind kind;
  bool shadow;
} light_record;

/* What was hit, as shading needs it: structures of arrays, padded like rays. Normals point to the
 * side that the ray came from. */
typedef struct surface_batch {
  float *point[3];
  float *error; /* distance along the geometric normal that clears the rounding of `point` */
  float *geometric[3], *normal[3];
  float *view[3];   /* at first the ray's direction */
  float *u, *v;     /* weights of the second and third vertex */
  float *origin[3]; /* of rays that leave where the view is; only of lit groups */
  float *weight[3];
  float *diffuse[3];             /* already divided by pi */
  float *highlight[3], *alpha;   /* GGX lobe; alpha 0: none */
  uint32_t *record, *slot, *ray; /* ray: its index in the batch */
  uint32_t *lit, lit_groups;     /* where lane groups begin in which a surface answers to light */
  uint32_t first_ray;            /* the number in the log of the batch's first ray */
  uint32_t count, capacity;
  void *memory;
} surface_batch;

/* Makes room for `count` surfaces and forgets those it holds; false if there is no memory. */
bool surface_batch_reserve(surface_batch *batch, uint32_t count);
void surface_batch_release(surface_batch *batch);
size_t surface_batch_bytes(const surface_batch *batch);

typedef struct tile_context {
  const whittle_scene *scene;
  const kernel_table *kernels;
  whittle_settings settings; /* with all defaults filled in */
  camera_rays camera;
  double depth_scale; /* scene t to world depth */
  const light_record *lights;
  uint32_t light_count;
  uint32_t needs;         /* of the kernel */
  uint32_t width, height; /* of the whole image */
  uint32_t region[4];
  uint32_t tile_edge, tiles_x, tiles;
  uint32_t grid;                       /* samples along each axis of a pixel */
  uint32_t together;                   /* samples of a pixel that are on their way at once */
  uint32_t packets[WHITTLE_RAY_KINDS]; /* rays in a packet of each kind */
  bool count;                          /* nodes and triangles */
  bool watch;                /* more of each ray: owners, log, the deepest leaf, the packets */
  bool coherence;            /* of the packets */
  const cost_owners *owners; /* NULL: nobody is charged */
  ray_log *log;              /* NULL: nothing is logged; then there is one worker */
  const whittle_image *image;
  atomic_int *cancelled;
} tile_context;

typedef struct tile_worker {
  ray_batch primary, shadow;
  ray_batch secondary[2][2]; /* generation even or odd; reflection or refraction */
  surface_batch surfaces;
  uint32_t pixels, slots; /* slot: a sample of a pixel, those of one pixel side by side */
  uint32_t pixel_x[WHITTLE_TILE_PIXELS], pixel_y[WHITTLE_TILE_PIXELS];
  uint32_t slot_x[WHITTLE_TILE_SLOTS], slot_y[WHITTLE_TILE_SLOTS]; /* the pixel's */
  uint32_t slot_sample[WHITTLE_TILE_SLOTS];                        /* its number in the pixel */
  float column[WHITTLE_TILE_SLOTS], row[WHITTLE_TILE_SLOTS];       /* its cell of the pixel */
  float sample_x[WHITTLE_TILE_SLOTS + WHITTLE_LANE_PAD];
  float sample_y[WHITTLE_TILE_SLOTS + WHITTLE_LANE_PAD];
  uint32_t depth, light; /* of the rays at hand; the light of shadow rays */
  float sample[4][WHITTLE_TILE_SLOTS + WHITTLE_LANE_PAD]; /* light and alpha, by slot */
  float sum[4][WHITTLE_TILE_PIXELS]; /* of a pixel's samples, and what follows: by pixel */
  uint32_t nodes[WHITTLE_RAY_KINDS][WHITTLE_TILE_PIXELS];
  uint32_t triangles[WHITTLE_RAY_KINDS][WHITTLE_TILE_PIXELS];
  uint32_t leaf_depth[WHITTLE_TILE_PIXELS];
  packet_share shares[WHITTLE_TILE_PIXELS];
  cost_row cost[WHITTLE_RAY_KINDS]; /* one block, cost[0].instance_nodes, if anyone is charged */
  packet_counters packet_counters;
  packet_memory packet_memory[WHITTLE_RAY_KINDS];
  whittle_render_stats stats;
  char separate[64]; /* workers share no cache line */
} tile_worker;
