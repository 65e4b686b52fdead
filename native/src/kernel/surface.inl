/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* From hits to their places and normals, a lane group at a time. */

/* The numbers of a lane group's triangles, transposed: a row for each number. */
typedef struct corner_block {
  float vertex[9][V_LANES] __attribute__((aligned(64)));
  float normal[9][V_LANES] __attribute__((aligned(64)));
  float turn[9][V_LANES] __attribute__((aligned(64))); /* the instance's normal matrix */
  float side[V_LANES] __attribute__((aligned(64)));
  float u[V_LANES] __attribute__((aligned(64))), v[V_LANES] __attribute__((aligned(64)));
  uint32_t smooth; /* lanes whose mesh has normals */
} corner_block;

static inline void gather_normals(const whittle_scene *scene, triangle_id id, uint32_t lane,
                                  corner_block *block) {
  const instance *placed = &scene->instances[id.instance];
  const mesh *m = &scene->meshes[placed->mesh];
  if (m->normals == NULL)
    return;
  block->smooth |= 1u << lane;
  const uint32_t *corner = &m->triangles[3 * (size_t)id.triangle];
  for (uint32_t i = 0; i < 3; i++) {
    const size_t at = m->normals_by_corner ? 3 * (size_t)id.triangle + i : corner[i];
    for (uint32_t k = 0; k < 3; k++)
      block->normal[3 * i + k][lane] = m->normals[3 * at + k];
  }
  for (uint32_t k = 0; k < 9; k++)
    block->turn[k][lane] = placed->normal_matrix[k];
}

static inline void gather_corners(const whittle_scene *scene, const ray_stream *rays,
                                  const uint32_t *hits, uint32_t lanes, bool smooth,
                                  corner_block *block) {
  block->smooth = 0;
  for (uint32_t lane = 0; lane < V_LANES; lane++) {
    const uint32_t i = hits[lane < lanes ? lane : 0];
    const triangle_place place = whittle_find_triangle(&scene->triangles, rays->record[i]);
    const triangle_id id = scene->triangles.ids[rays->record[i]];
    for (uint32_t k = 0; k < 9; k++)
      block->vertex[k][lane] = place.first[k * place.size];
    block->side[lane] = scene->instances[id.instance].side;
    block->u[lane] = rays->u[i], block->v[lane] = rays->v[i];
    if (smooth)
      gather_normals(scene, id, lane, block);
  }
}

/* Unit geometric normals by cross product in double: a needle's would be lost in float. */
static inline v_vector geometric_normals(const corner_block *b) {
  float n[3][V_LANES] __attribute__((aligned(64)));
  for (uint32_t lane = 0; lane < V_LANES; lane++) {
    const double ax = (double)b->vertex[3][lane] - (double)b->vertex[0][lane];
    const double ay = (double)b->vertex[4][lane] - (double)b->vertex[1][lane];
    const double az = (double)b->vertex[5][lane] - (double)b->vertex[2][lane];
    const double bx = (double)b->vertex[6][lane] - (double)b->vertex[0][lane];
    const double by = (double)b->vertex[7][lane] - (double)b->vertex[1][lane];
    const double bz = (double)b->vertex[8][lane] - (double)b->vertex[2][lane];
    const double x = ay * bz - az * by, y = az * bx - ax * bz, z = ax * by - ay * bx;
    const double scale = (double)b->side[lane] / __builtin_sqrt((x * x + y * y) + z * z);
    n[0][lane] = (float)(x * scale);
    n[1][lane] = (float)(y * scale);
    n[2][lane] = (float)(z * scale);
  }
  return vec_rows(n);
}

/* Weights of the three vertices. */
static inline v_vector barycentrics(const corner_block *b) {
  const v_float u = v_load(b->u), v = v_load(b->v);
  return vec((v_set(1.0f) - u) - v, u, v);
}

/* Interpolated normals in scene space, outwards; the geometric ones where a mesh is flat. */
static inline v_vector smooth_normals(corner_block *b, v_vector flat) {
  if (b->smooth == 0)
    return flat;
  const v_vector w = barycentrics(b);
  const v_vector n0 = vec_scale(vec_rows(b->normal), w.x);
  const v_vector n1 = vec_scale(vec_rows(b->normal + 3), w.y);
  const v_vector local = vec_add(vec_add(n0, n1), vec_scale(vec_rows(b->normal + 6), w.z));
  const v_vector turned =
      vec(vec_dot(vec_rows(b->turn), local), vec_dot(vec_rows(b->turn + 3), local),
          vec_dot(vec_rows(b->turn + 6), local));
  return vec_select(v_from_bits(b->smooth), vec_unit(turned, flat), flat);
}

/* Hit points by barycentrics, and how far along the normal their rounding can reach: Pharr, Jakob,
 * Humphreys, Physically Based Rendering, section 3.9. */
static inline void place_surfaces(surface_batch *s, uint32_t at, corner_block *b, v_vector normal) {
  const v_float gamma7 = v_set(7.0f * 0x1p-24f / (1.0f - 7.0f * 0x1p-24f));
  const v_vector w = barycentrics(b);
  const v_vector p0 = vec_scale(vec_rows(b->vertex), w.x);
  const v_vector p1 = vec_scale(vec_rows(b->vertex + 3), w.y);
  const v_vector p2 = vec_scale(vec_rows(b->vertex + 6), w.z);
  const v_vector reach = vec_add(vec_add(vec_abs(p0), vec_abs(p1)), vec_abs(p2));
  vec_store(s->point, at, vec_add(vec_add(p0, p1), p2));
  v_store(s->error + at, vec_dot(vec_abs(normal), vec_scale(reach, gamma7)));
}

/* Fills place, view and normals of up to V_LANES hits; gives the lanes that came from outside. */
static inline v_mask load_surfaces(const whittle_scene *scene, const ray_stream *rays,
                                   const uint32_t *hits, uint32_t lanes, bool smooth,
                                   surface_batch *s, uint32_t at) {
  corner_block block;
  gather_corners(scene, rays, hits, lanes, smooth, &block);
  float d[3][V_LANES] __attribute__((aligned(64)));
  for (uint32_t lane = 0; lane < V_LANES; lane++)
    for (uint32_t k = 0; k < 3; k++)
      d[k][lane] = rays->direction[k][hits[lane < lanes ? lane : 0]];
  const v_float nothing = v_set(0.0f);
  const v_vector up = vec(nothing, nothing, v_set(1.0f));
  const v_vector view = vec_unit(vec_scale(vec_rows(d), v_set(-1.0f)), up);
  const v_vector outward = geometric_normals(&block);
  const v_mask outside = v_le(nothing, vec_dot(outward, view));
  const v_float flip = v_select(outside, v_set(1.0f), v_set(-1.0f));
  const v_vector geometric = vec_scale(outward, flip);
  v_vector normal = geometric;
  if (smooth) {
    normal = vec_scale(smooth_normals(&block, outward), flip);
    /* Past its silhouette a smooth normal looks away from the eye. */
    normal = vec_select(v_lt(nothing, vec_dot(normal, view)), normal, geometric);
  }
  place_surfaces(s, at, &block, geometric);
  vec_store(s->geometric, at, geometric);
  vec_store(s->normal, at, normal);
  vec_store(s->view, at, view);
  return outside;
}

/* The next float after x in the direction of `towards`, which is small beside x or 0. */
static inline v_float step_floats(v_float x, v_float towards) {
  const v_float up = v_next(x, 1), down = v_next(x, -1);
  const v_float moved = v_select(v_lt(v_set(0.0f), towards), up, down);
  return v_select(v_eq(towards, v_set(0.0f)), x, moved);
}

/* Where rays leave their surfaces on the side of `side` (1: where the view is; -1: the other). */
static inline v_vector surface_origins(const surface_batch *s, uint32_t at, float side) {
  const v_vector point = vec_load(s->point, at);
  const v_float along = v_load(s->error + at) * v_set(side);
  const v_vector move = vec_scale(vec_load(s->geometric, at), along);
  const v_vector to = vec_add(point, move);
  return vec(step_floats(to.x, move.x), step_floats(to.y, move.y), step_floats(to.z, move.z));
}
