/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* A tree for one instance after the other; the scene keeps none of them. */

#include "scene/own_trees.h"
#include "base/memory.h"
#include "bvh/measure.h"

#include <math.h>
#include <string.h>

/* Strays are at most one triangle in this many. */
enum { STRAYS = 100 };

whittle_status whittle_own_order(const judged_scene *judged, size_t instances, own_order *order,
                                 whittle_error *error) {
  const size_t count = judged->tree.triangle_count;
  order->triangles = whittle_allocate(count, sizeof *order->triangles);
  order->first = whittle_allocate(instances + 2, sizeof *order->first);
  if (!order->triangles || !order->first)
    return whittle_out_of_memory(error, "the triangles by instance");
  uint64_t *next = order->first + 1;
  memset(order->first, 0, (instances + 2) * sizeof *order->first);
  for (size_t i = 0; i < count; i++)
    order->first[judged->instances[i] + 2]++;
  for (size_t i = 0; i < instances; i++)
    next[i + 1] += next[i];
  for (size_t i = 0; i < count; i++)
    order->triangles[next[judged->instances[i]]++] = (uint32_t)i;
  return WHITTLE_OK;
}

void whittle_own_order_free(own_order *order) {
  whittle_release(order->triangles);
  whittle_release(order->first);
}

static void set_fragment(whittle_fragment *f, const float *corners) {
  for (int k = 0; k < 3; k++) {
    f->lo[k] = fminf(corners[k], fminf(corners[3 + k], corners[6 + k]));
    f->hi[k] = fmaxf(corners[k], fmaxf(corners[3 + k], corners[6 + k]));
  }
  f->triangle = f->instance = 0;
}

/* Triangles below a node, but no more than `most` + 1 are counted. */
static uint64_t count_below(const whittle_node *nodes, uint32_t index, uint64_t most) {
  if (nodes[index].count)
    return nodes[index].count;
  const uint64_t left = count_below(nodes, nodes[index].left_first, most);
  return left > most ? left : left + count_below(nodes, nodes[index].left_first + 1, most - left);
}

/* The heuristic sets a few far triangles apart near the root: following the other side down gives
 * the box without them. */
static void find_strays(const whittle_bvh *bvh, whittle_part_quality *part) {
  const whittle_node *nodes = bvh->nodes;
  const double whole = whittle_node_area(&nodes[0]);
  uint64_t left_out = 0, most = part->triangles / STRAYS;
  double least = whole;
  for (uint32_t core = 0; nodes[core].count == 0;) {
    const uint32_t child = nodes[core].left_first;
    const uint64_t left = count_below(nodes, child, most - left_out);
    const bool drop_left = left <= most - left_out;
    const uint64_t right = drop_left ? 0 : count_below(nodes, child + 1, most - left_out);
    if (!drop_left && right > most - left_out)
      break;
    left_out += drop_left ? left : right;
    core = child + drop_left;
    if (whittle_node_area(&nodes[core]) < least) {
      least = whittle_node_area(&nodes[core]);
      part->stray_triangles = left_out;
    }
  }
  part->stray_share = whole > 0.0 ? 1.0 - least / whole : 0.0;
}

static whittle_status own_tree(whittle_team *team, const judged_scene *judged,
                               const uint32_t *triangles, whittle_fragment *room,
                               whittle_part_quality *part, whittle_error *error) {
  const whittle_build_options *built = &judged->scene->options;
  const whittle_bvh_options options = {
      .bins = built->bins, .max_leaf = built->max_leaf, .traversal_cost = built->traversal_cost};
  const uint32_t count = (uint32_t)part->triangles;
  for (uint32_t i = 0; i < count; i++)
    set_fragment(&room[i], judged->vertices + 9 * (size_t)triangles[i]);
  whittle_bvh bvh;
  const whittle_status status =
      whittle_bvh_build(team, room, room + count, count, &options, &bvh, error);
  if (status == WHITTLE_OK && bvh.node_count && !whittle_cancelled(team->state)) {
    part->sah_cost = bvh.sah_cost;
    find_strays(&bvh, part);
  }
  whittle_release(bvh.block);
  return status;
}

whittle_status whittle_own_trees(whittle_team *team, const judged_scene *judged,
                                 const own_order *order, whittle_quality *quality,
                                 whittle_error *error) {
  uint64_t largest = 0;
  for (size_t i = 0; i < quality->instance_count; i++)
    if (quality->instances[i].triangles > largest)
      largest = quality->instances[i].triangles;
  whittle_fragment *room = whittle_allocate(2 * (size_t)largest, sizeof *room);
  if (!room)
    return whittle_out_of_memory(error, "a tree for each instance");
  whittle_status status = WHITTLE_OK;
  for (size_t i = 0; i < quality->instance_count && status == WHITTLE_OK; i++)
    if (!whittle_cancelled(team->state))
      status = own_tree(team, judged, order->triangles + order->first[i], room,
                        &quality->instances[i], error);
  whittle_release(room);
  return status;
}
