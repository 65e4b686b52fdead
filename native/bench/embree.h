/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Embree as the other side of the comparison. */

#ifndef BENCH_EMBREE_H
#define BENCH_EMBREE_H

#include "crew.h"
#include "embree_abi.h"
#include "rays.h"

/* A way to trace: rays at a time, and whether the query says that they are coherent. */
typedef struct embree_mode {
  const char *name;
  unsigned width;
  int coherent;
} embree_mode;

enum { EMBREE_MODES = 5, EMBREE_BUILDS = 4 };

typedef struct embree {
  embree_library library;
  embree_device *device;
  embree_scene *scene; /* that is traced: one of scenes */
  embree_scene *scenes[EMBREE_BUILDS];
  long long bytes;                 /* that the device holds now, the shared buffers not counted */
  embree_mode modes[EMBREE_MODES]; /* those that this device supports, single rays first */
  unsigned mode_count;
  char version[32];
} embree;

/* Loads the library at `path`. */
void embree_load(embree *e, const char *path);

/* A device for builds with so many threads, restricted to an instruction set ("avx2") or not
 * (NULL). At most one device exists at a time: its threads are the library's. */
void embree_open(embree *e, unsigned threads, const char *isa);
void embree_close(embree *e);

/* Builds the mesh as scene `place` of those that exist side by side, which is then the one that is
 * traced, and gives the seconds that the build itself took. `quality` is "low", "medium", "high" or
 * "robust" (medium with robust intersection). */
double embree_build(embree *e, unsigned place, const mesh *m, const char *quality);
void embree_choose(embree *e, unsigned place); /* which one is traced */
void embree_release(embree *e);                /* all scenes */

/* Traces a whole stream, in chunks of so many rays that the crew takes. */
enum { EMBREE_CHUNK = 4096 };
void embree_trace(const embree *e, const embree_mode *mode, const stream *s, const hits *h,
                  crew *threads);

#endif
