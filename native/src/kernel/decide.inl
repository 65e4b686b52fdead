/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The exact test's last step for one ray and one triangle: x, y and z in the lanes of a register,
 * with the operations of triangle.inl in their order, and without branches. */

/* What is read of a ray, in the order of the sheared space. */
typedef struct decided_ray {
  f4_float origin, inverse, shear; /* the shear of the third is 1 */
  float t_min;
} decided_ray;

static inline decided_ray decided_ray_of(const prepared_rays *p, uint32_t lane, float t_min) {
  return (decided_ray){f4_make(p->sheared_origin[0][lane], p->sheared_origin[1][lane],
                               p->sheared_origin[2][lane], 0.0f),
                       f4_make(p->sheared_inverse[0][lane], p->sheared_inverse[1][lane],
                               p->sheared_inverse[2][lane], 1.0f),
                       f4_make(p->shear_x[lane], p->shear_y[lane], 1.0f, 0.0f), t_min};
}

/* A triangle's vertices, in the order of the sheared space. */
typedef struct sheared_triangle {
  f4_float v0, v1, v2;
} sheared_triangle;

/* Triangle `index` of a block's rows, for rays along `axis`. */
static inline sheared_triangle sheared_triangle_of(const float *rows, uint32_t size, uint32_t index,
                                                   uint32_t axis) {
  const uint32_t second = v_next_axis[axis], third = v_next_axis[second];
  const float *const x = rows + second * size + index, *const y = rows + third * size + index;
  const float *const z = rows + axis * size + index;
  const size_t next = 3 * (size_t)size;
  return (sheared_triangle){f4_make(x[0], y[0], z[0], 0.0f),
                            f4_make(x[next], y[next], z[next], 0.0f),
                            f4_make(x[2 * next], y[2 * next], z[2 * next], 0.0f)};
}

/* x, y, z as y, z, x. */
static inline f4_float turned(f4_float a) {
  return _mm_shuffle_ps(a, a, _MM_SHUFFLE(3, 0, 2, 1));
}

/* whittle_to_unit without branches, of numbers above 0. */
static inline double unit_of(double a, double b, double c) {
  const __m128d ab = _mm_max_sd(_mm_set_sd(a), _mm_set_sd(b));
  const __m128d most = _mm_max_sd(ab, _mm_set_sd(c));
  const uint64_t exponent = (uint64_t)_mm_cvtsi128_si64(_mm_castpd_si128(most)) >> 52;
  const uint64_t inverse = 2046 - exponent - (exponent == 0) * 1023;
  return _mm_cvtsd_f64(_mm_castsi128_pd(_mm_cvtsi64_si128((int64_t)(inverse << 52))));
}

/* whittle_plane's normal. */
static inline f4_float decided_normal(const sheared_triangle *t) {
  const f4_float from = turned(t->v0);
  const four_doubles e1 = WIDENED(t->v1) - WIDENED(t->v0);
  const four_doubles e2 = WIDENED(t->v2) - WIDENED(t->v0);
  const four_doubles turned1 = WIDENED(turned(t->v1)) - WIDENED(from);
  const four_doubles turned2 = WIDENED(turned(t->v2)) - WIDENED(from);
  const four_doubles n = e1 * turned2 - turned1 * e2; /* as z, x, y */
  const double unit = unit_of(__builtin_fabs(n[0]), __builtin_fabs(n[1]), __builtin_fabs(n[2]));
  const four_doubles scaled = n * (four_doubles){unit, unit, unit, unit};
  return turned((f4_float)NARROWED(scaled));
}

/* FN(plane_distance). */
static inline float decided_distance(const decided_ray *ray, const sheared_triangle *t) {
  const f4_float normal = decided_normal(t);
  const f4_float above = normal * (t->v0 - ray->origin), along = normal * ray->shear;
  /* Both sums at once: (x + y) + z. */
  const f4_float xy = _mm_unpacklo_ps(above, along), z = _mm_unpackhi_ps(above, along);
  const f4_float sums = (xy + _mm_movehl_ps(xy, xy)) + z;
  const float distance = f4_first(sums) / f4_first(_mm_movehdup_ps(sums));
  return distance * f4_first(_mm_movehl_ps(ray->inverse, ray->inverse));
}

/* FN(slab) of the triangle's box. */
static inline void decided_slab(const decided_ray *ray, const sheared_triangle *t, float *near,
                                float *far) {
  const f4_float nothing = f4_set(0.0f);
  const f4_float below = ray->origin - f4_min(f4_min(t->v0, t->v1), t->v2);
  const f4_float above = f4_max(f4_max(t->v0, t->v1), t->v2) - ray->origin;
  const f4_float reach = f4_max(f4_max(below, above), nothing);
  const f4_float room = f4_set(f4_max3(reach) * WHITTLE_BOX_PAD);
  const f4_float to_low = nothing - (below + room), to_high = above + room;
  const f4_float close = f4_by_sign(ray->inverse, to_low, to_high) * ray->inverse;
  const f4_float away = f4_by_sign(ray->inverse, to_high, to_low) * ray->inverse;
  *near = f4_max3(f4_max(close, f4_set(-__builtin_inff())));
  *far = f4_min3(f4_min(away, f4_set(__builtin_inff())));
}
