/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* From hits to their places and normals, a lane group at a time. */

/* The numbers of a lane group's triangles, transposed: a row for each number. */
typedef struct corner_block {
  float vertex[9][V_LANES] __attribute__((aligned(64)));
  float normal[9][V_LANES] __attribute__((aligned(64)));
  float turn[9][V_LANES] __attribute__((aligned(64))); /* the instance's normal matrix */
  float side[V_LANES] __attribute__((aligned(64)));
  uint32_t smooth; /* lanes whose mesh has normals */
} corner_block;

/* Whether the numbers of so many lanes are all the same. */
static inline bool all_same(const uint32_t *numbers, uint32_t lanes) {
  const uint32_t same = v_bits(v_equ(v_loadu(numbers), v_setu(numbers[0])));
  return (~same & (uint32_t)((1ull << lanes) - 1)) == 0;
}

/* A column of `rows`, or if `every` the one of all lanes. */
static inline void fill_column(float (*rows)[V_LANES], uint32_t count, uint32_t lane, bool every,
                               const float *numbers, uint32_t step) {
  for (uint32_t k = 0; every && k < count; k++)
    v_store(rows[k], v_set(numbers[k * step]));
  for (uint32_t k = 0; !every && k < count; k++)
    rows[k][lane] = numbers[k * step];
}

static inline const float *vertex_normal(const mesh *m, uint32_t triangle, uint32_t corner) {
  const size_t at = 3 * (size_t)triangle + corner;
  return m->normals + 3 * (m->normals_by_corner ? at : (size_t)m->triangles[at]);
}

/* The triangle of a lane, or if `every` that of all of them. */
static inline void gather_triangle(const whittle_scene *scene, uint32_t record, uint32_t lane,
                                   bool every, bool smooth, corner_block *block) {
  const triangle_place place = whittle_find_triangle(&scene->triangles, record);
  const triangle_id id = scene->triangles.ids[record];
  const mesh *m = &scene->meshes[scene->instances[id.instance].mesh];
  fill_column(block->vertex, 9, lane, every, place.first, place.size);
  if (!smooth || m->normals == NULL)
    return;
  block->smooth |= every ? (uint32_t)((1ull << V_LANES) - 1) : 1u << lane;
  for (uint32_t i = 0; i < 3; i++)
    fill_column(block->normal + 3 * i, 3, lane, every, vertex_normal(m, id.triangle, i), 1);
}

static inline void gather_instance(const instance *placed, uint32_t lane, bool every, bool smooth,
                                   corner_block *block) {
  fill_column(&block->side, 1, lane, every, &placed->side, 1);
  if (smooth)
    fill_column(block->turn, 9, lane, every, placed->normal_matrix, 1);
}

/* What the triangles of a lane group need; neighbours have mostly met the same, or at least the
 * same instance. */
static inline void gather_corners(const whittle_scene *scene, const uint32_t *records,
                                  uint32_t lanes, bool smooth, corner_block *block) {
  const bool one = all_same(records, lanes);
  uint32_t owners[V_LANES];
  block->smooth = 0;
  if (one)
    gather_triangle(scene, records[0], 0, true, smooth, block);
  for (uint32_t lane = 0; lane < V_LANES; lane++) {
    const uint32_t record = records[lane < lanes ? lane : 0];
    owners[lane] = scene->triangles.ids[record].instance;
    if (!one)
      gather_triangle(scene, record, lane, false, smooth, block);
  }
  const bool together = all_same(owners, V_LANES);
  for (uint32_t lane = 0; lane < (together ? 1 : V_LANES); lane++)
    gather_instance(&scene->instances[owners[lane]], lane, together, block->smooth != 0, block);
}

/* ---- What is to come is fetched, in the order in which one thing tells where the next is ---- */

#define FETCH_AHEAD (2 * V_LANES) /* surfaces between one and the next */

static inline void fetch_ids(const whittle_scene *scene, uint32_t record) {
  whittle_prefetch(&scene->triangles.ids[record]);
  whittle_prefetch(&scene->triangles.places[record]);
}

static inline void fetch_triangle(const whittle_scene *scene, uint32_t record) {
  const triangle_id id = scene->triangles.ids[record];
  const mesh *m = &scene->meshes[scene->instances[id.instance].mesh];
  const triangle_place place = whittle_find_triangle(&scene->triangles, record);
  for (uint32_t k = 0; k < 9; k += 2)
    whittle_prefetch(place.first + k * place.size);
  whittle_prefetch(&m->triangles[3 * (size_t)id.triangle]);
  if (m->materials != NULL)
    whittle_prefetch(&m->materials[id.triangle]);
}

static inline void fetch_normals(const whittle_scene *scene, uint32_t record) {
  const triangle_id id = scene->triangles.ids[record];
  const mesh *m = &scene->meshes[scene->instances[id.instance].mesh];
  for (uint32_t i = 0; m->normals != NULL && i < 3; i++)
    whittle_prefetch(vertex_normal(m, id.triangle, i));
}

/* Fetches for lane groups that come after the one at `at`. */
static inline void fetch_ahead(const whittle_scene *scene, const surface_batch *s, uint32_t at) {
  for (uint32_t first = at + FETCH_AHEAD, i = first; i < first + V_LANES; i++) {
    const uint32_t next = i + FETCH_AHEAD, last = next + FETCH_AHEAD;
    if (i < s->count && s->record[i] != s->record[i - 1])
      fetch_normals(scene, s->record[i]);
    if (next < s->count && s->record[next] != s->record[next - 1])
      fetch_triangle(scene, s->record[next]);
    if (last < s->count && s->record[last] != s->record[last - 1])
      fetch_ids(scene, s->record[last]);
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
static inline v_vector barycentrics(const surface_batch *s, uint32_t at) {
  const v_float u = v_load(s->u + at), v = v_load(s->v + at);
  return vec((v_set(1.0f) - u) - v, u, v);
}

/* Interpolated normals in scene space, outwards; the geometric ones where a mesh is flat. */
static inline v_vector smooth_normals(corner_block *b, v_vector w, v_vector flat) {
  if (b->smooth == 0)
    return flat;
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
static inline void place_surfaces(surface_batch *s, uint32_t at, corner_block *b, v_vector w,
                                  v_vector normal) {
  const v_float gamma7 = v_set(7.0f * 0x1p-24f / (1.0f - 7.0f * 0x1p-24f));
  const v_vector p0 = vec_scale(vec_rows(b->vertex), w.x);
  const v_vector p1 = vec_scale(vec_rows(b->vertex + 3), w.y);
  const v_vector p2 = vec_scale(vec_rows(b->vertex + 6), w.z);
  const v_vector reach = vec_add(vec_add(vec_abs(p0), vec_abs(p1)), vec_abs(p2));
  vec_store(s->point, at, vec_add(vec_add(p0, p1), p2));
  v_store(s->error + at, vec_dot(vec_abs(normal), vec_scale(reach, gamma7)));
}

/* Fills place, view and normals of up to V_LANES hits; gives the lanes that came from outside. */
static inline v_mask load_surfaces(const whittle_scene *scene, uint32_t lanes, bool smooth,
                                   surface_batch *s, uint32_t at) {
  corner_block block;
  gather_corners(scene, s->record + at, lanes, smooth, &block);
  const v_float nothing = v_set(0.0f);
  const v_vector up = vec(nothing, nothing, v_set(1.0f)), weights = barycentrics(s, at);
  const v_vector view = vec_unit(vec_scale(vec_load(s->view, at), v_set(-1.0f)), up);
  const v_vector outward = geometric_normals(&block);
  const v_mask outside = v_le(nothing, vec_dot(outward, view));
  const v_float flip = v_select(outside, v_set(1.0f), v_set(-1.0f));
  const v_vector geometric = vec_scale(outward, flip);
  v_vector normal = geometric;
  if (smooth) {
    normal = vec_scale(smooth_normals(&block, weights, outward), flip);
    /* Past its silhouette a smooth normal looks away from the eye. */
    normal = vec_select(v_lt(nothing, vec_dot(normal, view)), normal, geometric);
  }
  place_surfaces(s, at, &block, weights, geometric);
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
