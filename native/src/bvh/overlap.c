/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Surface in boxes that are not its own: the end-point overlap of Aila, Karras and Laine (On
 * Quality Metrics of Bounding Volume Hierarchies, 2013), clipped exactly; and the test of single
 * points. */

#include "bvh/overlap.h"
#include "base/memory.h"
#include "bvh/clip.h"

enum { GRAIN = 16 };

typedef struct search {
  whittle_team *team;
  const whittle_judged *tree;
  const uint32_t *first; /* the first triangle below each node */
  double traversal_cost;
  whittle_overlap *overlap;
} search;

/* Triangles below a node lie next to each other, and children come after their parent. */
static void find_first(const whittle_judged *tree, uint32_t *first) {
  for (size_t i = tree->node_count; i-- > 0;) {
    const whittle_node *node = &tree->nodes[i];
    first[i] = node->count ? node->left_first : first[node->left_first];
  }
}

/* What a triangle's part within the parent costs in a node and below; `end` is the first triangle
 * behind the node's. */
static double foreign(const search *s, uint32_t index, size_t end, size_t triangle,
                      const polygon *part) {
  const whittle_node *node = &s->tree->nodes[index];
  polygon inside;
  double sum = 0.0;
  if (triangle < s->first[index] || triangle >= end) {
    whittle_polygon_clip(part, node, &inside);
    const double area = whittle_polygon_area(&inside);
    if (!(area > 0.0))
      return 0.0;
    sum = area * (node->count ? (double)node->count : s->traversal_cost);
    part = &inside;
  }
  if (node->count)
    return sum;
  const uint32_t left = node->left_first;
  sum += foreign(s, left, s->first[left + 1], triangle, part);
  return sum + foreign(s, left + 1, end, triangle, part);
}

static void search_pieces(void *context, uint64_t begin, uint64_t end) {
  const search *s = context;
  for (uint64_t i = begin; i < end && !whittle_cancelled(s->team->state); i++) {
    const size_t triangle = whittle_overlap_triangle(s->tree, s->overlap->count, i);
    const polygon whole = whittle_polygon_of(s->tree->vertices + 9 * triangle);
    s->overlap->area[i] = whittle_polygon_area(&whole);
    s->overlap->foreign[i] = foreign(s, 0, s->tree->triangle_count, triangle, &whole);
    whittle_advance(s->team->state, WHITTLE_OVERLAP_UNITS);
  }
}

whittle_status whittle_judge_overlap(whittle_team *team, const whittle_judged *tree,
                                     double traversal_cost, whittle_overlap *overlap,
                                     whittle_error *error) {
  uint32_t *first = whittle_allocate(tree->node_count, sizeof *first);
  if (!first)
    return whittle_out_of_memory(error, "the overlap of boxes");
  find_first(tree, first);
  search s = {team, tree, first, traversal_cost, overlap};
  whittle_team_for(team, overlap->count, GRAIN, search_pieces, &s);
  whittle_release(first);
  return WHITTLE_OK;
}

static int contains(const whittle_node *node, const double point[3]) {
  for (int i = 0; i < 3; i++)
    if (!(point[i] >= node->bounds_min[i] && point[i] <= node->bounds_max[i]))
      return 0;
  return 1;
}

int whittle_in_foreign_leaf(const whittle_judged *tree, const uint32_t *owners, uint32_t label,
                            const double point[3]) {
  uint32_t stack[WHITTLE_MAX_DEPTH + 2] = {0}, waiting = 1;
  while (waiting) {
    const uint32_t index = stack[--waiting];
    const whittle_node *node = &tree->nodes[index];
    if (owners[index] == label || !contains(node, point))
      continue;
    if (node->count)
      return 1;
    stack[waiting++] = node->left_first + 1;
    stack[waiting++] = node->left_first;
  }
  return 0;
}
