/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Whittle as one side of the comparison, through its public interface only. */

#ifndef BENCH_OURS_H
#define BENCH_OURS_H

#include "rays.h"
#include "whittle.h"

typedef struct ours {
  whittle_scene *scene;
  whittle_build_stats stats;
} ours;

/* Builds the mesh and gives the seconds that the build itself took. */
double ours_build(ours *o, const mesh *m, unsigned threads);

/* Bytes of the binary tree, which a build keeps only to count on. */
uint64_t ours_bytes_to_count(const mesh *m, unsigned threads);
void ours_release(ours *o);

/* Traces a whole stream with one call. */
void ours_trace(const ours *o, const stream *s, const hits *h, unsigned threads);

/* Means over the stream's rays, each alone on a binary tree made for this: nodes visited, triangles
 * tested. */
void ours_count(const mesh *m, const stream *s, unsigned threads, double *nodes, double *triangles);

/* The name of the instruction set in use, and whether it is the widest that can run here. */
const char *ours_isa(int *is_widest);

#endif
