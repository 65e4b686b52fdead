/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* How much of an instance's surface stands in leaves of others, by points spread evenly over it. */

#include "bvh/clip.h"
#include "bvh/overlap.h"
#include "scene/own_trees.h"

#include <math.h>

/* Twice as many points as triangles, within these bounds. */
enum { FEWEST_POINTS = 256, MOST_POINTS = 16384 };

typedef struct scatter {
  whittle_team *team;
  const judged_scene *judged;
  const own_order *order;
  whittle_part_quality *parts;
} scatter;

static uint64_t points_for(uint64_t triangles) {
  const uint64_t wanted = 2 * triangles;
  return triangles == 0           ? 0
         : wanted < FEWEST_POINTS ? FEWEST_POINTS
         : wanted > MOST_POINTS   ? MOST_POINTS
                                  : wanted;
}

static double area_of(const float *corners) {
  const polygon p = whittle_polygon_of(corners);
  return whittle_polygon_area(&p);
}

/* Point number i of a sequence that fills a triangle evenly (Roberts, 2018: the additive recurrence
 * of the plastic number), folded from the square. */
static void point_in(const float *corners, uint64_t i, double point[3]) {
  double u = 0.5 + (double)i * 0.75487766624669276, v = 0.5 + (double)i * 0.56984029099805327;
  u -= floor(u), v -= floor(v);
  if (u + v > 1.0) {
    u = 1.0 - u;
    v = 1.0 - v;
  }
  for (int k = 0; k < 3; k++)
    point[k] = corners[k] + (u * ((double)corners[3 + k] - corners[k]) +
                             v * ((double)corners[6 + k] - corners[k]));
}

/* Points lie at equal steps of the area, triangle after triangle. */
static double inside_others(const scatter *s, uint32_t instance, double area) {
  const uint64_t count = points_for(s->parts[instance].triangles);
  const uint32_t *triangles = s->order->triangles + s->order->first[instance];
  double passed = 0.0;
  uint64_t next = 0, inside = 0;
  for (uint64_t t = 0; t < s->parts[instance].triangles; t++) {
    const float *corners = s->judged->vertices + 9 * (size_t)triangles[t];
    passed += area_of(corners);
    for (; next < count && ((double)next + 0.5) * area <= passed * (double)count; next++) {
      double point[3];
      if (whittle_cancelled(s->team->state))
        return 0.0;
      point_in(corners, next, point);
      inside +=
          (uint64_t)whittle_in_foreign_leaf(&s->judged->tree, s->judged->owners, instance, point);
    }
  }
  return next ? (double)inside / (double)next : 0.0;
}

static void scatter_pieces(void *context, uint64_t begin, uint64_t end) {
  const scatter *s = context;
  for (uint64_t i = begin; i < end; i++) {
    const uint64_t first = s->order->first[i];
    double area = 0.0;
    for (uint64_t t = 0; t < s->parts[i].triangles; t++)
      area += area_of(s->judged->vertices + 9 * (size_t)s->order->triangles[first + t]);
    s->parts[i].overlap = inside_others(s, (uint32_t)i, area);
    whittle_advance(s->team->state, points_for(s->parts[i].triangles));
  }
}

void whittle_inside_others(whittle_team *team, const judged_scene *judged, const own_order *order,
                           whittle_quality *quality) {
  scatter s = {team, judged, order, quality->instances};
  whittle_team_for(team, quality->instance_count, 1, scatter_pieces, &s);
}

uint64_t whittle_own_units(const own_order *order, size_t instances) {
  uint64_t sum = 0;
  for (size_t i = 0; i < instances; i++) {
    const uint64_t count = order->first[i + 1] - order->first[i];
    sum += whittle_bvh_units(count) + points_for(count);
  }
  return sum;
}
