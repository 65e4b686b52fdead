/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Streams of rays, as a renderer would trace them. */

#ifndef BENCH_RAYS_H
#define BENCH_RAYS_H

#include "mesh.h"

/* Structure of arrays: all x, then all y, then all z. */
typedef struct stream {
  const char *kind; /* "primary", "shadow", "mirror", "random" */
  size_t count;
  float *origins; /* count x 3, or one for all */
  int one_origin;
  float *directions; /* count x 3 */
  float t_max;
  int any_hit; /* only whether there is a hit */
} stream;

/* What tracing a stream gives. */
typedef struct hits {
  float *t; /* infinity: miss */
  int32_t *triangle;
  float *u, *v;
  uint8_t *blocked; /* of streams with any_hit, instead of the above */
} hits;

hits hits_new(const stream *s);
void hits_free(hits *h);
void stream_free(stream *s);

/* Component 0 to 2 of a ray's origin. */
static inline float stream_origin(const stream *s, size_t ray, int component) {
  return s->one_origin ? s->origins[component] : s->origins[(size_t)component * s->count + ray];
}

static inline float stream_direction(const stream *s, size_t ray, int component) {
  return s->directions[(size_t)component * s->count + ray];
}

/* One ray through each pixel's centre, unit directions. Consecutive rays are compact: 4 x 4
 * pixels are 16 rays, 16 x 16 are 256, 32 x 32 are 1024. */
stream rays_primary(const mesh *m, unsigned width, unsigned height);

/* From each hit of the primary rays, in their order: to the light, just short of it (t_max is
 * 0.9999 of the way); or along the mirrored direction of the smooth normal. */
stream rays_shadow(const mesh *m, const stream *primary, const hits *found);
stream rays_mirror(const mesh *m, const stream *primary, const hits *found);

/* From points in the mesh's box in all directions. */
stream rays_random(const mesh *m, size_t count);

#endif
