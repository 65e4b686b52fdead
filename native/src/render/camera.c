/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* From a camera's matrices to rays that are affine in the pixel. */

#include "base/matrix.h"
#include "render/render.h"

#include <math.h>

/* A point of the near plane, seen from the camera, for pixel coordinates (x, y). */
static bool unproject(const double inverse[16], const whittle_camera *camera, double x, double y,
                      double point[3]) {
  const double ndc[4] = {2.0 * x / camera->width - 1.0, 2.0 * y / camera->height - 1.0, -1.0, 1.0};
  double p[4];
  for (int row = 0; row < 4; row++) {
    const double *m = inverse + 4 * row;
    p[row] = ((m[0] * ndc[0] + m[1] * ndc[1]) + m[2] * ndc[2]) + m[3] * ndc[3];
  }
  for (int i = 0; i < 3; i++)
    point[i] = p[i] / p[3];
  return isfinite(point[0]) && isfinite(point[1]) && isfinite(point[2]);
}

static whittle_status check(const whittle_camera *camera, whittle_error *error) {
  const whittle_status invalid = WHITTLE_INVALID_ARGUMENT;
  if (camera->width == 0 || camera->height == 0 || camera->width > 1u << 16 ||
      camera->height > 1u << 16)
    return whittle_fail(error, invalid, "width", "width and height must be 1 to 65536, not %u x %u",
                        camera->width, camera->height);
  const uint32_t *r = camera->region;
  const bool whole = !(r[0] | r[1] | r[2] | r[3]);
  if (!whole && (r[0] >= r[2] || r[1] >= r[3] || r[2] > camera->width || r[3] > camera->height))
    return whittle_fail(error, invalid, "region",
                        "region (%u, %u, %u, %u) is empty or not inside %u x %u", r[0], r[1], r[2],
                        r[3], camera->width, camera->height);
  if (!(camera->clip_start >= 0.0) || !(camera->clip_end >= 0.0) || isinf(camera->clip_start))
    return whittle_fail(error, invalid, "clip_start",
                        "clip distances must be finite and not negative");
  return WHITTLE_OK;
}

/* Origin and direction in scene space of a point that the camera sees; perspective directions
 * reach depth 1, so that t is the depth, whatever the length of the matrix's axes. */
static void place(const whittle_scene *scene, const double *m, const double at[3], bool flat,
                  double origin[3], double direction[3]) {
  const double from[3] = {flat ? at[0] : 0.0, flat ? at[1] : 0.0, 0.0};
  double world[3];
  whittle_matrix_point(m, from, world);
  for (int i = 0; i < 3; i++) {
    origin[i] = ldexp(world[i] - scene->frame.center[i], -scene->frame.exponent);
    const double x = flat ? 0.0 : at[0] / -at[2], y = flat ? 0.0 : at[1] / -at[2];
    direction[i] = (m[4 * i] * x + m[4 * i + 1] * y) - m[4 * i + 2];
  }
}

whittle_status whittle_camera_rays(const whittle_scene *scene, const whittle_camera *camera,
                                   camera_rays *rays, whittle_error *error) {
  const whittle_status status = check(camera, error);
  if (status != WHITTLE_OK)
    return status;
  double inverse[16], unused[16];
  if (!whittle_matrix_invert(camera->projection, inverse))
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "projection",
                        "projection is not finite or cannot be inverted");
  if (!whittle_matrix_invert(camera->to_world, unused))
    return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "to_world",
                        "to_world is not finite or cannot be inverted");
  const double *p = camera->projection;
  const bool flat = p[12] == 0.0 && p[13] == 0.0 && p[14] == 0.0;
  double corner[3][3], origin[3][3], direction[3][3];
  for (int c = 0; c < 3; c++) {
    if (!unproject(inverse, camera, c == 1 ? camera->width : 0, c == 2 ? camera->height : 0,
                   corner[c]) ||
        (!flat && corner[c][2] == 0.0))
      return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "projection",
                          "projection maps a corner of the image nowhere");
    place(scene, camera->to_world, corner[c], flat, origin[c], direction[c]);
  }
  for (int i = 0; i < 3; i++) {
    rays->origin[i] = (float)origin[0][i];
    rays->origin_x[i] = (float)((origin[1][i] - origin[0][i]) / camera->width);
    rays->origin_y[i] = (float)((origin[2][i] - origin[0][i]) / camera->height);
    rays->direction[i] = (float)direction[0][i];
    rays->direction_x[i] = (float)((direction[1][i] - direction[0][i]) / camera->width);
    rays->direction_y[i] = (float)((direction[2][i] - direction[0][i]) / camera->height);
  }
  rays->t_min = (float)ldexp(camera->clip_start, -scene->frame.exponent);
  rays->t_max =
      camera->clip_end > 0.0 ? (float)ldexp(camera->clip_end, -scene->frame.exponent) : INFINITY;
  return WHITTLE_OK;
}
