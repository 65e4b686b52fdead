/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The one exact test of a triangle, included once for single rays and once for lane groups. */

/* Woop, Benthin, Wald: Watertight Ray/Triangle Intersection, JCGT 2013, with its double-precision
 * fallback, and with the padded slab interval of the triangle's own box as part of the definition:
 * t at a grazing angle can otherwise lie before its box, and the winner would depend on the tree.
 * Every node's interval contains that of each triangle below it, so no cull can lose a hit. */

#ifndef FAMILY
#error "define FAMILY(name) as s_##name or v_##name"
#endif
#define REAL FAMILY(float)
#define MASK FAMILY(mask)
#define FN(name) FAMILY(name)

/* Axes of the sheared space for the dominant axis z: no swap of x and y, since the signs of U, V, W
 * only negate exactly. */
static const uint8_t FN(next_axis)[3] = {1, 2, 0};

/* A ray, or a lane group of them whose directions share the dominant axis; components in the order
 * of the sheared space. */
typedef struct FN(ray) {
  int axis[3]; /* which of x, y, z each component is: axis[2] is the dominant one */
  REAL origin[3];
  REAL inverse[3]; /* 1 / direction, infinite where that is 0 */
  REAL shear_x, shear_y;
  REAL t_min;
} FN(ray);

static inline void FN(set_axes)(FN(ray) * ray, int dominant) {
  ray->axis[2] = dominant;
  ray->axis[0] = FN(next_axis)[dominant];
  ray->axis[1] = FN(next_axis)[ray->axis[0]];
}

/* The interval of t in which a ray is inside a box grown by `pad`. All steps are monotonic, so that
 * of a box contains those of all boxes in it. A direction of 0 makes 0 * infinity where the origin
 * lies on a face: that NaN is the first operand of min and max, and vanishes. */
static inline void FN(slab)(const FN(ray) * ray, const float low[3], const float high[3], float pad,
                            REAL *near, REAL *far) {
  REAL below[3], above[3], reach = FN(set)(0.0f);
  for (int i = 0; i < 3; i++) {
    below[i] = ray->origin[i] - FN(set)(low[ray->axis[i]]);
    above[i] = FN(set)(high[ray->axis[i]]) - ray->origin[i];
    reach = FN(max)(FN(max)(below[i], above[i]), reach);
  }
  const REAL room = reach * FN(set)(pad), nothing = FN(set)(0.0f);
  *near = FN(set)(-__builtin_inff()), *far = FN(set)(__builtin_inff());
  for (int i = 0; i < 3; i++) {
    const MASK negative = FN(lt)(ray->inverse[i], nothing);
    const REAL to_low = nothing - (below[i] + room), to_high = above[i] + room;
    *near = FN(max)(FN(select)(negative, to_high, to_low) * ray->inverse[i], *near);
    *far = FN(min)(FN(select)(negative, to_low, to_high) * ray->inverse[i], *far);
  }
}

typedef struct FN(edges) {
  REAL u, v, w; /* weights of the three vertices times the determinant */
} FN(edges);

/* U, V and W of the lanes in `zero` again in double, where their signs are exact. A common power of
 * two keeps the smallest triangles from underflowing; u and v are ratios. */
__attribute__((noinline, cold)) static void FN(edges_in_double)(MASK zero, REAL ax, REAL ay,
                                                                REAL bx, REAL by, REAL cx, REAL cy,
                                                                FN(edges) * edges) {
  float in[6][FAMILY_LANES], out[3][FAMILY_LANES];
  FN(store)(in[0], ax), FN(store)(in[1], ay), FN(store)(in[2], bx);
  FN(store)(in[3], by), FN(store)(in[4], cx), FN(store)(in[5], cy);
  FN(store)(out[0], edges->u), FN(store)(out[1], edges->v), FN(store)(out[2], edges->w);
  const uint32_t bits = FN(bits)(zero);
  for (int lane = 0; lane < FAMILY_LANES; lane++) {
    if (!(bits >> lane & 1))
      continue;
    const double a[2] = {in[0][lane], in[1][lane]}, b[2] = {in[2][lane], in[3][lane]};
    const double c[2] = {in[4][lane], in[5][lane]};
    const double u = c[0] * b[1] - c[1] * b[0];
    const double v = a[0] * c[1] - a[1] * c[0];
    const double w = b[0] * a[1] - b[1] * a[0];
    const double scale = whittle_to_unit(u, v, w);
    out[0][lane] = (float)(u * scale), out[1][lane] = (float)(v * scale);
    out[2][lane] = (float)(w * scale);
  }
  edges->u = FN(load)(out[0]), edges->v = FN(load)(out[1]), edges->w = FN(load)(out[2]);
}

/* A triangle's vertices relative to the rays' origins, in the order of the sheared space. */
typedef struct FN(relative) {
  REAL x[3], y[3], z[3];
} FN(relative);

static inline FN(relative) FN(relate)(const FN(ray) * ray, const triangle_record *triangle) {
  const float *vertex[3] = {triangle->v0, triangle->v1, triangle->v2};
  FN(relative) r;
  for (int i = 0; i < 3; i++) {
    r.x[i] = FN(set)(vertex[i][ray->axis[0]]) - ray->origin[0];
    r.y[i] = FN(set)(vertex[i][ray->axis[1]]) - ray->origin[1];
    r.z[i] = FN(set)(vertex[i][ray->axis[2]]) - ray->origin[2];
  }
  return r;
}

/* The same where all rays share one origin: one subtraction serves all lanes. */
static inline FN(relative)
    FN(relate_common)(const float origin[3], const FN(ray) * ray, const triangle_record *triangle) {
  const float *vertex[3] = {triangle->v0, triangle->v1, triangle->v2};
  const int *k = ray->axis;
  FN(relative) r;
  for (int i = 0; i < 3; i++) {
    r.x[i] = FN(set)(vertex[i][k[0]] - origin[k[0]]);
    r.y[i] = FN(set)(vertex[i][k[1]] - origin[k[1]]);
    r.z[i] = FN(set)(vertex[i][k[2]] - origin[k[2]]);
  }
  return r;
}

/* The lanes of `active` whose line meets the triangle. */
static inline __attribute__((always_inline)) MASK FN(edge_test)(const FN(ray) * ray,
                                                                const FN(relative) * r, MASK active,
                                                                FN(edges) * edges) {
  const REAL ax = r->x[0] - ray->shear_x * r->z[0], ay = r->y[0] - ray->shear_y * r->z[0];
  const REAL bx = r->x[1] - ray->shear_x * r->z[1], by = r->y[1] - ray->shear_y * r->z[1];
  const REAL cx = r->x[2] - ray->shear_x * r->z[2], cy = r->y[2] - ray->shear_y * r->z[2];
  edges->u = cx * by - cy * bx;
  edges->v = ax * cy - ay * cx;
  edges->w = bx * ay - by * ax;
  const REAL nothing = FN(set)(0.0f);
  const REAL least = FN(min)(FN(min)(edges->u, edges->v), edges->w);
  const REAL most = FN(max)(FN(max)(edges->u, edges->v), edges->w);
  /* Below 0: signs differ. 0: one of the three is, or all are so small that they may be off. */
  const REAL product = least * most;
  active = FN(andnot)(active, FN(lt)(product, nothing));
  const MASK zero = FN (and)(active, FN(eq)(product, nothing));
  if (__builtin_expect(FN(bits)(zero) != 0, 0)) {
    FN(edges_in_double)(zero, ax, ay, bx, by, cx, cy, edges);
    const REAL low = FN(min)(FN(min)(edges->u, edges->v), edges->w);
    const REAL high = FN(max)(FN(max)(edges->u, edges->v), edges->w);
    active = FN(andnot)(active, FN (and)(FN(lt)(low, nothing), FN(lt)(nothing, high)));
  }
  return active;
}

/* t where the rays meet the triangle's plane: n.(v0 - o) / n.d. Weighing the vertices' depths by U,
 * V and W, as the paper does, is off by several per cent of a needle's length. */
static inline REAL FN(plane_distance)(const FN(ray) * ray, const FN(relative) * r,
                                      const triangle_plane *plane) {
  const REAL nx = FN(set)(plane->normal[ray->axis[0]]), ny = FN(set)(plane->normal[ray->axis[1]]);
  const REAL nz = FN(set)(plane->normal[ray->axis[2]]);
  const REAL above = (nx * r->x[0] + ny * r->y[0]) + nz * r->z[0];
  const REAL along = (nx * ray->shear_x + ny * ray->shear_y) + nz;
  return above / along * ray->inverse[2];
}

/* The lanes of `active`, which have passed the edges, that hit the triangle in (t_min, best], given
 * the distance of its plane and the interval of its box; *t is valid in those. In those of `tied`,
 * t is `best`: the order of triangles decides. */
static inline __attribute__((always_inline)) MASK FN(settle)(MASK active, REAL determinant,
                                                             REAL distance, REAL near, REAL far,
                                                             REAL t_min, REAL best, REAL *t,
                                                             MASK *tied, uint64_t *own_box_misses) {
  active = FN(andnot)(active, FN(eq)(determinant, FN(set)(0.0f)));
  const MASK inside = FN(le)(near, far);
  const uint32_t outside = FN(bits)(FN(andnot)(active, inside));
  if (__builtin_expect(outside != 0, 0))
    *own_box_misses += (uint64_t)__builtin_popcount(outside);
  active = FN (and)(active, inside);
#ifndef WHITTLE_BREAK_CLAMP
  distance = FN(min)(FN(max)(distance, near), far);
#endif
  active = FN (and)(active, FN (and)(FN(lt)(t_min, distance), FN(le)(distance, best)));
  *tied = FN (and)(active, FN(eq)(distance, best));
  *t = distance;
  return active;
}

/* + 0 turns -0 into 0: mirrored shears would else differ in the sign of zero. */
static inline REAL FN(weight)(REAL edge, REAL determinant) {
  return edge / determinant + FN(set)(0.0f);
}

/* FN(settle) for any rays; u and v are valid where t is. */
static inline __attribute__((always_inline)) MASK FN(decide)(const FN(ray) * ray,
                                                             const FN(relative) * relative,
                                                             const triangle_plane *plane,
                                                             const FN(edges) * edges, MASK active,
                                                             REAL best, REAL *t, REAL *u, REAL *v,
                                                             MASK *tied, uint64_t *own_box_misses) {
  const REAL determinant = (edges->u + edges->v) + edges->w;
  const REAL distance = FN(plane_distance)(ray, relative, plane);
  REAL near, far;
  FN(slab)(ray, plane->low, plane->high, WHITTLE_BOX_PAD, &near, &far);
  *u = FN(weight)(edges->v, determinant), *v = FN(weight)(edges->w, determinant);
  return FN(settle)(active, determinant, distance, near, far, ray->t_min, best, t, tied,
                    own_box_misses);
}

#undef REAL
#undef MASK
#undef FN
