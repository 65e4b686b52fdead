/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* From a hit to its place and normals. Everything here is one number at a time, in a fixed order. */

typedef struct vector {
  float x, y, z;
} vector;

static inline vector vec(float x, float y, float z) { return (vector){x, y, z}; }
static inline vector vec_from(const float v[3]) { return (vector){v[0], v[1], v[2]}; }
static inline void vec_to(vector v, float out[3]) { out[0] = v.x, out[1] = v.y, out[2] = v.z; }
static inline vector vec_add(vector a, vector b) { return vec(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline vector vec_sub(vector a, vector b) { return vec(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline vector vec_mul(vector a, vector b) { return vec(a.x * b.x, a.y * b.y, a.z * b.z); }
static inline vector vec_scale(vector a, float s) { return vec(a.x * s, a.y * s, a.z * s); }
static inline float vec_dot(vector a, vector b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }
static inline float vec_most(vector a) { return s_max(s_max(a.x, a.y), a.z); }
static inline vector vec_cross(vector a, vector b) {
  return vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/* Scaled by its largest component first, so that tiny and huge vectors keep their direction. */
static inline vector vec_unit(vector a) {
  const float most = vec_most(vec(s_abs(a.x), s_abs(a.y), s_abs(a.z)));
  if (!(most > 0.0f))
    return vec(0.0f, 0.0f, 1.0f);
  const vector b = vec_scale(a, 1.0f / most);
  return vec_scale(b, 1.0f / s_sqrt(vec_dot(b, b)));
}

/* The unit geometric normal by cross product in double: a needle's would be lost in float. */
static inline vector geometric_normal(const triangle_record *r) {
  double a[3], b[3], n[3];
  for (int i = 0; i < 3; i++) {
    a[i] = (double)r->v1[i] - (double)r->v0[i];
    b[i] = (double)r->v2[i] - (double)r->v0[i];
  }
  n[0] = a[1] * b[2] - a[2] * b[1];
  n[1] = a[2] * b[0] - a[0] * b[2];
  n[2] = a[0] * b[1] - a[1] * b[0];
  const double scale = whittle_to_unit(n[0], n[1], n[2]);
  return vec_unit(vec((float)(n[0] * scale), (float)(n[1] * scale), (float)(n[2] * scale)));
}

/* Hit point by barycentrics, and how far along the normal its rounding can reach: Pharr, Jakob,
 * Humphreys, Physically Based Rendering, section 3.9. */
static inline void surface_place(surface *s, const triangle_record *r, float u, float v,
                                 vector normal) {
  const float gamma7 = 7.0f * 0x1p-24f / (1.0f - 7.0f * 0x1p-24f);
  const float w = (1.0f - u) - v;
  float bound[3];
  for (int i = 0; i < 3; i++) {
    const float a = w * r->v0[i], b = u * r->v1[i], c = v * r->v2[i];
    s->point[i] = (a + b) + c;
    bound[i] = gamma7 * ((s_abs(a) + s_abs(b)) + s_abs(c));
  }
  s->error = (s_abs(normal.x) * bound[0] + s_abs(normal.y) * bound[1]) + s_abs(normal.z) * bound[2];
}

/* The interpolated normal of a smooth mesh in scene space, outwards, or the geometric one. */
static inline vector smooth_normal(const whittle_scene *scene, const triangle_record *r, float u,
                                   float v, vector flat) {
  const instance *placed = &scene->instances[r->instance];
  const mesh *m = &scene->meshes[placed->mesh];
  if (m->normals == NULL)
    return flat;
  const uint32_t *corner = &m->triangles[3 * (size_t)r->triangle];
  vector n[3];
  for (int i = 0; i < 3; i++) {
    const size_t at = m->normals_by_corner ? 3 * (size_t)r->triangle + (size_t)i : corner[i];
    n[i] = vec_from(&m->normals[3 * at]);
  }
  const float w = (1.0f - u) - v;
  const vector local = vec_add(vec_add(vec_scale(n[0], w), vec_scale(n[1], u)), vec_scale(n[2], v));
  const float *row = placed->normal_matrix;
  const vector turned = vec(vec_dot(vec_from(row), local), vec_dot(vec_from(row + 3), local),
                            vec_dot(vec_from(row + 6), local));
  const float length = vec_dot(turned, turned);
  return length > 0.0f && length < __builtin_inff() ? vec_unit(turned) : flat;
}

/* Fills place, view and normals of a hit; true if the ray came from outside. */
static inline bool surface_load(const whittle_scene *scene, const ray_stream *rays, uint32_t i,
                                bool smooth, surface *s) {
  const triangle_record *r = &scene->triangles[rays->record[i]];
  const vector view = vec_unit(vec(-rays->direction[0][i], -rays->direction[1][i],
                                   -rays->direction[2][i]));
  const vector outward = vec_scale(geometric_normal(r), scene->instances[r->instance].side);
  const bool outside = vec_dot(outward, view) >= 0.0f;
  const vector geometric = outside ? outward : vec_scale(outward, -1.0f);
  vector normal = geometric;
  if (smooth) {
    normal = smooth_normal(scene, r, rays->u[i], rays->v[i], outward);
    normal = outside ? normal : vec_scale(normal, -1.0f);
    /* Past its silhouette a smooth normal looks away from the eye. */
    if (!(vec_dot(normal, view) > 0.0f))
      normal = geometric;
  }
  surface_place(s, r, rays->u[i], rays->v[i], geometric);
  vec_to(geometric, s->geometric);
  vec_to(normal, s->normal);
  vec_to(view, s->view);
  s->record = rays->record[i];
  return outside;
}

/* The next float after x in the direction of `towards`. */
static inline float step_float(float x, float towards) {
  if (towards == 0.0f)
    return x;
  if (x == 0.0f)
    return towards > 0.0f ? 0x1p-149f : -0x1p-149f;
  uint32_t bits;
  memcpy(&bits, &x, 4);
  bits += (x > 0.0f) == (towards > 0.0f) ? 1u : UINT32_MAX;
  memcpy(&x, &bits, 4);
  return x;
}

/* Where a ray leaves a surface on the side of `side` (1: where the view is; -1: the other). */
static inline void surface_origin(const surface *s, float side, float origin[3]) {
  for (int i = 0; i < 3; i++) {
    const float move = s->error * s->geometric[i] * side;
    origin[i] = step_float(s->point[i] + move, move);
  }
}
