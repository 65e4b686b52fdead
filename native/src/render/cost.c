/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Who pays for rays: the owners of nodes and triangles, and the tables of what they were charged.
 */

#include "render/cost.h"

#include "base/memory.h"
#include "bvh/owners.h"
#include "render/render.h"

#include <string.h>

/* ---- Owners -----------------------------------------------------------------------------------
 */

static void label_instances(const whittle_scene *scene, uint32_t *labels) {
  for (size_t i = 0; i < scene->triangle_count; i++)
    labels[i] = scene->triangles.ids[i].instance;
}

static void label_materials(const whittle_scene *scene, uint32_t *labels) {
  for (size_t i = 0; i < scene->triangle_count; i++) {
    const triangle_id id = scene->triangles.ids[i];
    const mesh *m = &scene->meshes[scene->instances[id.instance].mesh];
    labels[i] = m->materials ? m->materials[id.triangle] : 0;
  }
}

whittle_status whittle_scene_owners(const whittle_scene *scene, int32_t *instances,
                                    int32_t *materials, whittle_error *error) {
  whittle_status status = whittle_scene_read_begin(scene, error);
  if (status != WHITTLE_OK)
    return status;
  status = whittle_scene_has_binary(scene, "The owners of its nodes are", error);
  if (status == WHITTLE_OK)
    status = whittle_materials_exist(scene, error);
  uint32_t *labels = whittle_allocate(scene->triangle_count, sizeof *labels);
  if (status == WHITTLE_OK && labels == NULL)
    status = whittle_out_of_memory(error, "the owners of the triangles");
  const uint32_t shared = UINT32_MAX; /* as an int32_t, -1 */
  if (status == WHITTLE_OK && instances) {
    label_instances(scene, labels);
    whittle_owners(scene->nodes, scene->node_count, labels, shared, (uint32_t *)instances);
  }
  if (status == WHITTLE_OK && materials) {
    label_materials(scene, labels);
    whittle_owners(scene->nodes, scene->node_count, labels, shared, (uint32_t *)materials);
  }
  whittle_release(labels);
  whittle_scene_read_end(scene);
  return status;
}

/* Puts the owners of both kinds next to each other, where one visit finds them. */
static void pair_owners(const whittle_scene *scene, const cost_owners *owners, uint32_t *labels,
                        uint32_t *by_node, node_owner *pairs) {
  label_instances(scene, labels);
  whittle_owners(scene->nodes, scene->node_count, labels, owners->instance_count, by_node);
  for (size_t i = 0; i < scene->node_count; i++)
    pairs[i].instance = by_node[i];
  label_materials(scene, labels);
  whittle_owners(scene->nodes, scene->node_count, labels, owners->material_count, by_node);
  for (size_t i = 0; i < scene->node_count; i++)
    pairs[i].material = by_node[i];
}

whittle_status whittle_cost_begin(const whittle_scene *scene, cost_owners *owners,
                                  whittle_error *error) {
  uint32_t *labels = whittle_allocate(scene->triangle_count, sizeof *labels);
  uint32_t *by_node = whittle_allocate(scene->node_count, sizeof *by_node);
  node_owner *pairs = whittle_allocate(scene->node_count, sizeof *pairs);
  *owners = (cost_owners){.nodes = pairs,
                          .materials = labels,
                          .instance_count = (uint32_t)scene->instance_count,
                          .material_count = (uint32_t)scene->material_count};
  const bool room = labels && by_node && pairs;
  if (room)
    pair_owners(scene, owners, labels, by_node, pairs);
  else
    whittle_cost_end(owners);
  whittle_release(by_node);
  return room ? WHITTLE_OK : whittle_out_of_memory(error, "the owners of the nodes");
}

void whittle_cost_end(cost_owners *owners) {
  whittle_release((void *)owners->nodes);
  whittle_release((void *)owners->materials);
  *owners = (cost_owners){0};
}

size_t whittle_cost_owner_bytes(const cost_owners *owners, const whittle_scene *scene) {
  return scene->node_count * sizeof *owners->nodes +
         scene->triangle_count * sizeof *owners->materials;
}

/* ---- Tables -----------------------------------------------------------------------------------
 */

whittle_status whittle_scene_columns(const whittle_scene *scene, size_t *instances,
                                     size_t *materials, whittle_error *error) {
  const whittle_status status = whittle_scene_read_begin(scene, error);
  if (status != WHITTLE_OK)
    return status;
  *instances = scene->instance_count;
  *materials = scene->material_count;
  whittle_scene_read_end(scene);
  return WHITTLE_OK;
}

whittle_status whittle_cost_check(const whittle_scene *scene, const whittle_cost *cost,
                                  whittle_error *error) {
  if (cost->instances == scene->instance_count && cost->materials == scene->material_count)
    return WHITTLE_OK;
  return whittle_fail(error, WHITTLE_INVALID_ARGUMENT, "cost",
                      "cost has room for %zu instances and %zu materials, but the scene has %zu "
                      "and %zu: ask for the columns again",
                      cost->instances, cost->materials, scene->instance_count,
                      scene->material_count);
}

/* Numbers in one row of each of the four tables together. */
static size_t row_numbers(const cost_owners *owners) {
  return 2 * ((size_t)owners->instance_count + 1) + 2 * ((size_t)owners->material_count + 1);
}

bool whittle_cost_worker_begin(const cost_owners *owners, tile_worker *worker) {
  const size_t numbers = row_numbers(owners);
  uint64_t *block = whittle_allocate(WHITTLE_RAY_KINDS * numbers, sizeof *block);
  if (block == NULL)
    return false;
  memset(block, 0, whittle_cost_worker_bytes(owners));
  for (int kind = 0; kind < WHITTLE_RAY_KINDS; kind++) {
    cost_row *row = &worker->cost[kind];
    row->instance_nodes = block + kind * numbers;
    row->instance_triangles = row->instance_nodes + owners->instance_count + 1;
    row->material_nodes = row->instance_triangles + owners->instance_count + 1;
    row->material_triangles = row->material_nodes + owners->material_count + 1;
  }
  return true;
}

void whittle_cost_worker_end(tile_worker *worker) {
  whittle_release(worker->cost[0].instance_nodes);
}

size_t whittle_cost_worker_bytes(const cost_owners *owners) {
  return WHITTLE_RAY_KINDS * row_numbers(owners) * sizeof(uint64_t);
}

static void add_row(uint64_t *table, int kind, size_t columns, const uint64_t *row) {
  for (size_t i = 0; i < columns; i++)
    table[(size_t)kind * columns + i] += row[i];
}

void whittle_cost_sum(const cost_owners *owners, const tile_worker *workers, uint32_t count,
                      const whittle_cost *cost) {
  const size_t instances = (size_t)owners->instance_count + 1;
  const size_t materials = (size_t)owners->material_count + 1;
  memset(cost->instance_nodes, 0, WHITTLE_RAY_KINDS * instances * sizeof(uint64_t));
  memset(cost->instance_triangles, 0, WHITTLE_RAY_KINDS * instances * sizeof(uint64_t));
  memset(cost->material_nodes, 0, WHITTLE_RAY_KINDS * materials * sizeof(uint64_t));
  memset(cost->material_triangles, 0, WHITTLE_RAY_KINDS * materials * sizeof(uint64_t));
  for (uint32_t i = 0; i < count; i++)
    for (int kind = 0; kind < WHITTLE_RAY_KINDS; kind++) {
      const cost_row *row = &workers[i].cost[kind];
      add_row(cost->instance_nodes, kind, instances, row->instance_nodes);
      add_row(cost->instance_triangles, kind, instances, row->instance_triangles);
      add_row(cost->material_nodes, kind, materials, row->material_nodes);
      add_row(cost->material_triangles, kind, materials, row->material_triangles);
    }
}
