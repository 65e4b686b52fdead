/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Counting hits and mismatches. */

#include "compare.h"

#include <math.h>
#include <string.h>

static int is_hit(const stream *s, const hits *h, size_t ray) {
  return s->any_hit ? h->blocked[ray] != 0 : h->triangle[ray] >= 0;
}

size_t compare_count_hits(const stream *s, const hits *h) {
  size_t count = 0;
  for (size_t i = 0; i < s->count; i++)
    count += (size_t)is_hit(s, h, i);
  return count;
}

/* Written so that a t which is not a number is a mismatch. */
static int is_mismatch(const stream *s, const hits *a, const hits *b, size_t ray) {
  int hit = is_hit(s, a, ray);
  if (hit != is_hit(s, b, ray))
    return 1;
  if (s->any_hit || !hit)
    return 0;
  float difference = fabsf(a->t[ray] - b->t[ray]);
  return !(difference <= 1e-4f * fmaxf(fabsf(a->t[ray]), fabsf(b->t[ray])));
}

size_t compare_mismatches(const stream *s, const hits *a, const hits *b) {
  size_t count = 0;
  for (size_t i = 0; i < s->count; i++)
    count += (size_t)is_mismatch(s, a, b, i);
  return count;
}

int compare_identical(const stream *s, const hits *a, const hits *b) {
  if (s->any_hit)
    return memcmp(a->blocked, b->blocked, s->count) == 0;
  size_t bytes = s->count * sizeof(float);
  return memcmp(a->t, b->t, bytes) == 0 && memcmp(a->triangle, b->triangle, bytes) == 0 &&
         memcmp(a->u, b->u, bytes) == 0 && memcmp(a->v, b->v, bytes) == 0;
}
