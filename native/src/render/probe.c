/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The rays of one pixel: a render of that pixel alone, with everything written down. */

#include "render/render.h"

#include "base/memory.h"

#include <math.h>
#include <string.h>

static whittle_status check_pixel(const whittle_camera *camera, uint32_t x, uint32_t y,
                                  whittle_error *error) {
  if (x < camera->width && y < camera->height)
    return WHITTLE_OK;
  return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, x < camera->width ? "y" : "x",
                      "pixel (%u, %u) is not in an image of %u x %u, whose pixels are counted "
                      "from 0 at the lower left",
                      x, y, camera->width, camera->height);
}

/* From scene space to world space, with t unchanged: directions are scaled instead. */
static void place_ray(const scene_frame *frame, const logged_ray *from, whittle_probe_ray *to) {
  for (int axis = 0; axis < 3; axis++) {
    to->origin[axis] = ldexp(from->origin[axis], frame->exponent) + frame->center[axis];
    to->direction[axis] = ldexp(from->direction[axis], frame->exponent);
  }
}

static void place_hit(const whittle_scene *scene, const logged_ray *from, whittle_probe_ray *to) {
  to->t = INFINITY;
  to->instance = to->triangle = to->material = -1;
  if (from->record == WHITTLE_NONE)
    return;
  const triangle_id id = scene->triangles.ids[from->record];
  const mesh *m = &scene->meshes[scene->instances[id.instance].mesh];
  to->t = from->t, to->u = from->u, to->v = from->v;
  to->instance = (int32_t)id.instance;
  to->triangle = (int32_t)id.triangle;
  to->material = m->materials ? (int32_t)m->materials[id.triangle] : 0;
}

/* A number of the log, with -1 for none. */
static int64_t or_none(uint32_t number) {
  return number == WHITTLE_NONE ? -1 : (int64_t)number;
}

static void give_rays(const whittle_scene *scene, const ray_log *log, whittle_probe_ray *rays) {
  size_t node = 0, triangle = 0;
  for (size_t i = 0; i < log->count; i++) {
    const logged_ray *from = &log->rays[i];
    rays[i] = (whittle_probe_ray){.kind = from->kind,
                                  .sample = from->sample,
                                  .depth = from->depth,
                                  .parent = or_none(from->parent),
                                  .light = or_none(from->light),
                                  .t_min = from->t_min,
                                  .t_max = from->t_max,
                                  .nodes = log->nodes.numbers + node,
                                  .node_count = from->nodes,
                                  .triangles = log->triangles.numbers + triangle,
                                  .triangle_count = from->triangles};
    place_ray(&scene->frame, from, &rays[i]);
    place_hit(scene, from, &rays[i]);
    node += from->nodes, triangle += from->triangles;
  }
}

/* What whittle_probe_release finds again. */
typedef struct probe_block {
  whittle_probe probe;
  ray_log log;
} probe_block;

/* Renders the one pixel of the camera's region and gives its rays. The caller reads the scene. */
static whittle_status fill(const whittle_scene *scene, const whittle_camera *camera,
                           const whittle_settings *settings, probe_block *block,
                           whittle_error *error) {
  const whittle_image image = {.cost = NULL};
  whittle_run_state state = {0};
  const whittle_status status =
      whittle_render_run(scene, camera, settings, &image, &block->log, NULL, &state, error);
  if (status != WHITTLE_OK)
    return status;
  whittle_probe_ray *rays = whittle_allocate(block->log.count, sizeof *rays);
  if (rays == NULL)
    return whittle_out_of_memory(error, "the rays of the pixel");
  give_rays(scene, &block->log, rays);
  block->probe = (whittle_probe){.rays = rays, .count = block->log.count};
  return WHITTLE_OK;
}

whittle_status whittle_probe_pixel(const whittle_scene *scene, const whittle_camera *camera,
                                   const whittle_settings *settings, uint32_t x, uint32_t y,
                                   whittle_probe **probe, whittle_error *error) {
  whittle_status status = check_pixel(camera, x, y, error);
  if (status != WHITTLE_OK)
    return status;
  probe_block *block = whittle_allocate(1, sizeof *block);
  if (block == NULL)
    return whittle_out_of_memory(error, "the probe");
  *block = (probe_block){.probe = {.count = 0}};
  whittle_camera pixel = *camera;
  memcpy(pixel.region, (uint32_t[]){x, y, x + 1, y + 1}, sizeof pixel.region);
  whittle_settings alone = *settings;
  alone.threads = 1;
  alone.progress = (whittle_progress){0};
  status = whittle_scene_read_begin(scene, error);
  if (status == WHITTLE_OK) {
    status = fill(scene, &pixel, &alone, block, error);
    whittle_scene_read_end(scene);
  }
  if (status == WHITTLE_OK)
    *probe = &block->probe;
  else
    whittle_probe_release(&block->probe);
  return status;
}

void whittle_probe_release(whittle_probe *probe) {
  if (probe == NULL)
    return;
  probe_block *block = (probe_block *)probe;
  whittle_release((void *)probe->rays);
  ray_log_release(&block->log);
  whittle_release(block);
}
