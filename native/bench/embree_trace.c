/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Tracing a stream with Embree: single rays and packets of 4, 8 and 16. */

#include "embree.h"

#include <string.h>
#include <xmmintrin.h>

#define WIDTH 4
#include "embree_packet.h"
#undef WIDTH
#define WIDTH 8
#include "embree_packet.h"
#undef WIDTH
#define WIDTH 16
#include "embree_packet.h"
#undef WIDTH

static void trace_1(const embree *e, embree_query *query, const stream *s, const hits *h,
                    size_t first, size_t count) {
  embree_ray_hit one;
  memset(&one, 0, sizeof(one));
  one.ray.mask = UINT32_MAX;
  for (size_t i = first; i < first + count; i++) {
    for (int k = 0; k < 3; k++) {
      one.ray.origin[k] = stream_origin(s, i, k);
      one.ray.direction[k] = stream_direction(s, i, k);
    }
    one.ray.t_far = s->t_max;
    if (s->any_hit) {
      e->library.any_1(e->scene, &one.ray, query);
      h->blocked[i] = one.ray.t_far < 0;
      continue;
    }
    one.geometry = EMBREE_NOTHING;
    e->library.closest_1(e->scene, &one, query);
    int missed = one.geometry == EMBREE_NOTHING;
    h->t[i] = missed ? INFINITY : one.ray.t_far;
    h->triangle[i] = missed ? -1 : (int32_t)one.triangle;
    h->u[i] = one.u;
    h->v[i] = one.v;
  }
}

typedef struct trace_job {
  const embree *embree;
  const embree_mode *mode;
  const stream *stream;
  const hits *hits;
} trace_job;

static void trace_chunk(void *user, size_t first, size_t count) {
  const trace_job *job = user;
  embree_query query = {.features = UINT32_MAX, .flags = job->mode->coherent ? EMBREE_COHERENT : 0};
  /* Embree's manual asks for denormals to be flushed to zero, in and out. */
  unsigned before = _mm_getcsr();
  _mm_setcsr(before | 0x8040);
  void (*trace)(const embree *, embree_query *, const stream *, const hits *, size_t, size_t) =
      job->mode->width == 16  ? trace_16
      : job->mode->width == 8 ? trace_8
      : job->mode->width == 4 ? trace_4
                              : trace_1;
  trace(job->embree, &query, job->stream, job->hits, first, count);
  _mm_setcsr(before);
}

void embree_trace(const embree *e, const embree_mode *mode, const stream *s, const hits *h,
                  crew *threads) {
  trace_job job = {e, mode, s, h};
  crew_run(threads, s->count, EMBREE_CHUNK, trace_chunk, &job);
}
