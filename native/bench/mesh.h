/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* One triangle mesh with the camera and the light that its rays come from. */

#ifndef BENCH_MESH_H
#define BENCH_MESH_H

#include "vector.h"

#include <stddef.h>
#include <stdint.h>

typedef struct camera {
  vector eye, target, up;
  float fov; /* vertical, in degrees */
} camera;

typedef struct mesh {
  float *positions; /* vertex_count x 3 */
  size_t vertex_count;
  uint32_t *triangles; /* triangle_count x 3 */
  size_t triangle_count;
  float *normals; /* vertex_count x 3, smooth, unit length or zero */
  camera camera;
  vector light;
  int has_camera, has_light; /* else mesh_complete chooses */
} mesh;

mesh mesh_new(size_t vertex_count, size_t triangle_count);
void mesh_free(mesh *m);

static inline vector mesh_vertex(const mesh *m, size_t triangle, unsigned corner) {
  return vector_from(m->positions + (size_t)m->triangles[triangle * 3 + corner] * 3);
}

/* The box around all vertices; its diagonal. */
void mesh_bounds(const mesh *m, vector *low, vector *high);
float mesh_size(const mesh *m);

/* Puts a square of four diagonals' width under the mesh, y being up. */
void mesh_add_ground(mesh *m);

/* Smooth normals, and the camera and light if the file named none: the camera looks down at the
 * whole mesh from the front and right, as near as an image of this aspect allows. */
void mesh_complete(mesh *m, float aspect);

#endif
