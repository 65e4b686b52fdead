/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What the triangles of each instance and material are like, and what they take. */

#include "scene/parts.h"
#include "base/memory.h"
#include "bvh/clip.h"
#include "bvh/measure.h"
#include "scene/mesh.h"
#include "scene/triangles.h"

#include <math.h>
#include <string.h>

static whittle_status read_labels(const whittle_scene *scene, judged_scene *judged,
                                  whittle_error *error) {
  for (size_t i = 0; i < scene->triangle_count; i++) {
    const triangle_id id = scene->triangles.ids[i];
    const triangle_record record = whittle_take_triangle(&scene->triangles, (uint32_t)i);
    const uint32_t number = scene->instances[id.instance].mesh;
    const uint32_t *materials = scene->meshes[number].materials;
    const uint32_t material = materials ? materials[id.triangle] : 0;
    if (material >= scene->material_count)
      return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "materials",
                          "mesh %u, triangle %u: material %u of %zu does not exist", number,
                          id.triangle, material, scene->material_count);
    judged->instances[i] = id.instance;
    judged->materials[i] = material;
    memcpy(judged->vertices + 9 * i, record.v0, sizeof record.v0);
    memcpy(judged->vertices + 9 * i + 3, record.v1, sizeof record.v1);
    memcpy(judged->vertices + 9 * i + 6, record.v2, sizeof record.v2);
  }
  return WHITTLE_OK;
}

whittle_status whittle_judged_begin(const whittle_scene *scene, judged_scene *judged,
                                    whittle_error *error) {
  const size_t count = scene->triangle_count;
  memset(judged, 0, sizeof *judged);
  judged->scene = scene;
  judged->vertices = whittle_allocate(count, 9 * sizeof(float));
  judged->instances = whittle_allocate(count, sizeof(uint32_t));
  judged->materials = whittle_allocate(count, sizeof(uint32_t));
  judged->owners = whittle_allocate(scene->node_count, sizeof(uint32_t));
  if (!judged->vertices || !judged->instances || !judged->materials || !judged->owners)
    return whittle_out_of_memory(error, "judging the tree");
  judged->tree = (whittle_judged){scene->nodes, scene->node_count, judged->vertices, count};
  return read_labels(scene, judged, error);
}

void whittle_judged_free(judged_scene *judged) {
  whittle_release(judged->vertices);
  whittle_release(judged->instances);
  whittle_release(judged->materials);
  whittle_release(judged->owners);
}

/* ---- Triangles ---- */

typedef struct triangle_measure {
  float lo[3], hi[3];
  double area, fill;
} triangle_measure;

static triangle_measure measure(const float *corners) {
  triangle_measure m;
  for (int k = 0; k < 3; k++) {
    m.lo[k] = fminf(corners[k], fminf(corners[3 + k], corners[6 + k]));
    m.hi[k] = fmaxf(corners[k], fmaxf(corners[3 + k], corners[6 + k]));
  }
  const polygon p = whittle_polygon_of(corners);
  m.area = whittle_polygon_area(&p);
  const double half = whittle_half_area(m.lo, m.hi);
  m.fill = half > 0.0 ? fmin(2.0 * m.area / half, 1.0) : 0.0;
  return m;
}

/* Sums first: largest_triangle_share holds the largest area, box_fill the sum, boxes scene space.
 */
static void add(whittle_part_quality *part, const triangle_measure *m) {
  for (int k = 0; k < 3; k++) {
    part->box_min[k] = part->triangles ? fmin(part->box_min[k], m->lo[k]) : m->lo[k];
    part->box_max[k] = part->triangles ? fmax(part->box_max[k], m->hi[k]) : m->hi[k];
  }
  part->triangles++;
  part->slivers += m->fill < WHITTLE_SLIVER;
  part->area += m->area;
  part->box_fill += m->fill;
  part->largest_triangle_share = fmax(part->largest_triangle_share, m->area);
}

static void finish(whittle_part_quality *part, const scene_frame *frame) {
  if (part->triangles == 0)
    return;
  part->largest_triangle_share /= part->area;
  part->box_fill /= (double)part->triangles;
  part->area = ldexp(part->area, 2 * frame->exponent);
  for (int k = 0; k < 3; k++) {
    part->box_min[k] = ldexp(part->box_min[k], frame->exponent) + frame->center[k];
    part->box_max[k] = ldexp(part->box_max[k], frame->exponent) + frame->center[k];
  }
}

static void measure_triangles(const judged_scene *judged, whittle_quality *quality) {
  const size_t count = judged->tree.triangle_count;
  for (size_t i = 0; i < count; i++) {
    const triangle_measure m = measure(judged->vertices + 9 * i);
    add(&quality->instances[judged->instances[i]], &m);
    add(&quality->materials[judged->materials[i]], &m);
    quality->box_fill += m.fill;
    quality->slivers += m.fill < WHITTLE_SLIVER;
  }
  quality->triangles = count;
  quality->box_fill = count ? quality->box_fill / (double)count : 0.0;
  for (size_t i = 0; i < quality->instance_count; i++)
    finish(&quality->instances[i], &judged->scene->frame);
  for (size_t i = 0; i < quality->material_count; i++)
    finish(&quality->materials[i], &judged->scene->frame);
}

/* ---- Memory ---- */

/* A mesh is paid for by its triangles in the tree, wherever they are placed. */
static whittle_status share_meshes(const judged_scene *judged, whittle_quality *quality,
                                   whittle_error *error) {
  const whittle_scene *scene = judged->scene;
  double *each = whittle_allocate(scene->mesh_count, sizeof *each);
  double *instances = whittle_allocate(quality->instance_count, sizeof *instances);
  double *materials = whittle_allocate(quality->material_count, sizeof *materials);
  const bool room = each && instances && materials;
  if (room) {
    memset(each, 0, scene->mesh_count * sizeof *each);
    memset(instances, 0, quality->instance_count * sizeof *instances);
    memset(materials, 0, quality->material_count * sizeof *materials);
    for (size_t i = 0; i < quality->instance_count; i++)
      each[scene->instances[i].mesh] += (double)quality->instances[i].triangles;
    for (size_t i = 0; i < scene->mesh_count; i++)
      if (each[i] > 0.0)
        each[i] = (double)whittle_mesh_bytes(&scene->meshes[i]) / each[i];
    for (size_t i = 0; i < judged->tree.triangle_count; i++) {
      const uint32_t instance = judged->instances[i];
      instances[instance] += each[scene->instances[instance].mesh];
      materials[judged->materials[i]] += each[scene->instances[instance].mesh];
    }
    for (size_t i = 0; i < quality->instance_count; i++)
      quality->instances[i].bytes += (uint64_t)(instances[i] + 0.5);
    for (size_t i = 0; i < quality->material_count; i++)
      quality->materials[i].bytes += (uint64_t)(materials[i] + 0.5);
  }
  whittle_release(each);
  whittle_release(instances);
  whittle_release(materials);
  return room ? WHITTLE_OK : whittle_out_of_memory(error, "the memory of meshes");
}

static void share_tree(const whittle_scene *scene, const whittle_label_share *share,
                       whittle_part_quality *part) {
  const whittle_build_stats *stats = &scene->stats;
  part->nodes = share->nodes;
  part->stretch = share->stretch;
  part->bytes = whittle_triangles_bytes(part->triangles);
  if (scene->node_count)
    part->bytes += (uint64_t)(0.5 + (double)stats->bytes_nodes * (double)share->nodes /
                                        (double)scene->node_count);
}

static whittle_status judge_labels(const judged_scene *judged, const uint32_t *labels,
                                   uint32_t *owners, whittle_part_quality *parts, size_t count,
                                   whittle_error *error) {
  whittle_label_share *shares = whittle_allocate(count, sizeof *shares);
  if (!shares)
    return whittle_out_of_memory(error, "judging the tree");
  memset(shares, 0, count * sizeof *shares);
  whittle_judge_labels(&judged->tree, labels, owners, shares, count);
  for (size_t i = 0; i < count; i++)
    share_tree(judged->scene, &shares[i], &parts[i]);
  whittle_release(shares);
  return WHITTLE_OK;
}

whittle_status whittle_judge_parts(const judged_scene *judged, whittle_quality *quality,
                                   whittle_error *error) {
  measure_triangles(judged, quality);
  whittle_status status = judge_labels(judged, judged->instances, judged->owners,
                                       quality->instances, quality->instance_count, error);
  if (status == WHITTLE_OK)
    status = judge_labels(judged, judged->materials, NULL, quality->materials,
                          quality->material_count, error);
  return status == WHITTLE_OK ? share_meshes(judged, quality, error) : status;
}
