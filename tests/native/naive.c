/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What one writes first: triangle and box tests by brute force, to show that the tests are sharp.
 */

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

typedef enum triangle_test {
  WOOP,       /* Woop, Benthin, Wald 2013 with the double fallback: the control, never a culprit */
  WOOP_FMA,   /* the same as a compiler contracts it, without the fallback */
  MOLLER,     /* Moeller-Trumbore without any epsilon */
  MOLLER_DET, /* and with |det| < 1e-7 taken for parallel */
  MOLLER_LOOSE, /* and written as rejections, which NaN passes */
  PLUECKER,     /* signed volumes in float, strict */
} triangle_test;

typedef enum box_test {
  NO_BOX,
  UNPADDED,       /* near and far by the direction's sign, nothing added */
  FUSED,          /* plane * (1/d) - origin * (1/d) in one rounding */
  FMIN_FMAX,      /* sorts the two distances by fmin and fmax */
  COMPARE_SORT,   /* sorts them by a < b ? a : b */
  ENTRY_IN_FRONT, /* wants the entry to lie before the ray */
  FIRST_SIGNS,    /* near and far by the signs of the packet's first ray */
  PADDED,         /* Ize 2013: the control */
} box_test;

typedef struct ray {
  float o[3], d[3], inverse[3];
  int x, y, z;      /* axes for Woop: z is the largest */
  float sx, sy, sz; /* shear */
  int near_side[3]; /* 1: the upper plane is met first */
} ray;

static void set_up(ray *r, const float *o, const float *d) {
  r->z = fabsf(d[0]) >= fabsf(d[1]) && fabsf(d[0]) >= fabsf(d[2]) ? 0
         : fabsf(d[1]) >= fabsf(d[2])                             ? 1
                                                                  : 2;
  r->x = (r->z + 1) % 3;
  r->y = (r->x + 1) % 3;
  for (int k = 0; k < 3; k++) {
    r->o[k] = o[k];
    r->d[k] = d[k];
    r->inverse[k] = 1.0f / d[k];
    r->near_side[k] = signbit(d[k]) != 0;
  }
  r->sx = d[r->x] / d[r->z];
  r->sy = d[r->y] / d[r->z];
  r->sz = 1.0f / d[r->z];
}

static int woop(const ray *r, const float *v, int fused, float *t) {
  float x[3], y[3], z[3];
  for (int i = 0; i < 3; i++) {
    const float px = v[3 * i + r->x] - r->o[r->x], py = v[3 * i + r->y] - r->o[r->y];
    z[i] = v[3 * i + r->z] - r->o[r->z];
    x[i] = fused ? fmaf(-r->sx, z[i], px) : px - r->sx * z[i];
    y[i] = fused ? fmaf(-r->sy, z[i], py) : py - r->sy * z[i];
  }
  float e[3];
  for (int i = 0; i < 3; i++) {
    const int a = (i + 2) % 3, b = (i + 1) % 3;
    e[i] = fused ? fmaf(x[a], y[b], -(y[a] * x[b])) : x[a] * y[b] - y[a] * x[b];
  }
  if (!fused && (e[0] == 0 || e[1] == 0 || e[2] == 0))
    for (int i = 0; i < 3; i++) {
      const int a = (i + 2) % 3, b = (i + 1) % 3;
      e[i] = (float)((double)x[a] * y[b] - (double)y[a] * x[b]);
    }
  if ((e[0] < 0 || e[1] < 0 || e[2] < 0) && (e[0] > 0 || e[1] > 0 || e[2] > 0))
    return 0;
  const float det = (e[0] + e[1]) + e[2];
  if (det == 0)
    return 0;
  *t = (((e[0] * z[0] + e[1] * z[1]) + e[2] * z[2]) * r->sz) / det;
  return 1;
}

static void cross(const float *a, const float *b, float *out) {
  for (int k = 0; k < 3; k++)
    out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static float dot(const float *a, const float *b) {
  return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}

static void subtract(const float *a, const float *b, float *out) {
  for (int k = 0; k < 3; k++)
    out[k] = a[k] - b[k];
}

static int moller(const ray *r, const float *v, triangle_test test, float *t) {
  float e1[3], e2[3], p[3], s[3], q[3];
  subtract(v + 3, v, e1);
  subtract(v + 6, v, e2);
  cross(r->d, e2, p);
  const float det = dot(e1, p);
  if (test == MOLLER_DET && fabsf(det) < 1e-7f)
    return 0;
  if (test != MOLLER_LOOSE && det == 0)
    return 0;
  subtract(r->o, v, s);
  cross(s, e1, q);
  const float u = dot(s, p) / det, w = dot(r->d, q) / det;
  *t = dot(e2, q) / det;
  if (test == MOLLER_LOOSE)
    return !(u < 0 || u > 1 || w < 0 || u + w > 1);
  return u >= 0 && w >= 0 && u + w <= 1;
}

static int pluecker(const ray *r, const float *v, float *t) {
  float p[3][3], c[3], e1[3], e2[3], n[3], volume[3];
  for (int i = 0; i < 3; i++)
    subtract(v + 3 * i, r->o, p[i]);
  for (int i = 0; i < 3; i++) {
    cross(p[(i + 2) % 3], p[(i + 1) % 3], c);
    volume[i] = dot(r->d, c);
  }
  const int in = (volume[0] >= 0 && volume[1] >= 0 && volume[2] >= 0) ||
                 (volume[0] <= 0 && volume[1] <= 0 && volume[2] <= 0);
  subtract(v + 3, v, e1);
  subtract(v + 6, v, e2);
  cross(e1, e2, n);
  *t = dot(n, p[0]) / dot(n, r->d);
  return in && (volume[0] != 0 || volume[1] != 0 || volume[2] != 0);
}

static int hits_triangle(const ray *r, const float *v, triangle_test test, float *t) {
  if (test == WOOP || test == WOOP_FMA)
    return woop(r, v, test == WOOP_FMA, t);
  return test == PLUECKER ? pluecker(r, v, t) : moller(r, v, test, t);
}

static int hits_box(const ray *r, const ray *first, const float *low, const float *high,
                    box_test test, float t_max) {
  float tn = test == ENTRY_IN_FRONT ? -INFINITY : 0, tf = t_max;
  for (int k = 0; k < 3; k++) {
    const int swap = test == FIRST_SIGNS ? first->near_side[k] : r->near_side[k];
    float a = ((swap ? high : low)[k] - r->o[k]) * r->inverse[k];
    float b = ((swap ? low : high)[k] - r->o[k]) * r->inverse[k];
    if (test == FUSED) {
      const float rest = r->o[k] * r->inverse[k];
      a = fmaf((swap ? high : low)[k], r->inverse[k], -rest);
      b = fmaf((swap ? low : high)[k], r->inverse[k], -rest);
    } else if (test == FMIN_FMAX || test == COMPARE_SORT) {
      const int by_library = test == FMIN_FMAX;
      const float near_one = by_library ? fminf(a, b) : a < b ? a : b;
      b = by_library ? fmaxf(a, b) : a > b ? a : b;
      a = near_one;
    } else if (test == PADDED) {
      b *= 1.00000024f;
    }
    tn = a > tn ? a : tn;
    tf = b < tf ? b : tf;
  }
  return tn <= tf && (test != ENTRY_IN_FRONT || tn > 0);
}

/* The box of some triangles by compares that let NaN in, as it comes. */
static void bound(const float *v, int64_t count, float *low, float *high) {
  for (int k = 0; k < 3; k++) {
    low[k] = high[k] = v[k];
    for (int64_t i = 1; i < 3 * count; i++) {
      low[k] = low[k] < v[3 * i + k] ? low[k] : v[3 * i + k];
      high[k] = high[k] > v[3 * i + k] ? high[k] : v[3 * i + k];
    }
  }
}

/* The nearest hit of each ray over all triangles, in the order given; boxes lie around `group`
 * triangles in a row. `lowest` decides between equal t by index, else the first found stays. 1 if
 * memory is short. */
int naive_trace(int test, int box, int group, int lowest, const float *v, int64_t n, const float *o,
                const float *d, int64_t rays, float *t, int32_t *id) {
  ray *all = malloc((size_t)(rays + 1) * sizeof *all);
  if (!all)
    return 1;
  for (int64_t i = 0; i < rays; i++) {
    set_up(&all[i], o + 3 * i, d + 3 * i);
    t[i] = INFINITY;
    id[i] = -1;
  }
  for (int64_t j = 0; j < n; j += group) {
    const int64_t members = n - j < group ? n - j : group;
    float low[3], high[3];
    bound(v + 9 * j, members, low, high);
    for (int64_t i = 0; i < rays; i++) {
      if (box != NO_BOX && !hits_box(&all[i], &all[0], low, high, (box_test)box, t[i]))
        continue;
      for (int64_t k = j; k < j + members; k++) {
        float at;
        if (!hits_triangle(&all[i], v + 9 * k, (triangle_test)test, &at))
          continue;
        if (test == MOLLER_LOOSE ? at <= 0 || at >= t[i] : !(at > 0 && at <= t[i]))
          continue;
        if (at == t[i] && !(lowest && k < id[i]))
          continue;
        t[i] = at;
        id[i] = (int32_t)k;
      }
    }
  }
  free(all);
  return 0;
}

/* t of ray i and triangle i, without any box; infinity where they miss. */
void naive_pairs(int test, const float *v, const float *o, const float *d, int64_t rows, float *t) {
  for (int64_t i = 0; i < rows; i++) {
    ray r;
    set_up(&r, o + 3 * i, d + 3 * i);
    if (!hits_triangle(&r, v + 9 * i, (triangle_test)test, &t[i]) || !(t[i] > 0))
      t[i] = INFINITY;
  }
}

/* One triangle, one box and one ray a row: how many hits of the triangle the box loses. */
int64_t naive_box_losses(int test, int box, const float *v, const float *o, const float *d,
                         int64_t rows, int64_t *hits) {
  int64_t lost = 0;
  *hits = 0;
  for (int64_t i = 0; i < rows; i++) {
    ray r;
    float low[3], high[3], t;
    set_up(&r, o + 3 * i, d + 3 * i);
    if (!hits_triangle(&r, v + 9 * i, (triangle_test)test, &t) || !(t > 0))
      continue;
    ++*hits;
    bound(v + 9 * i, 1, low, high);
    lost += !hits_box(&r, &r, low, high, (box_test)box, INFINITY);
  }
  return lost;
}

/* Pairs a, b of points in the plane for which edge(a, b) is not -edge(b, a). */
int64_t naive_edge_asymmetry(int fused, const float *a, const float *b, int64_t pairs) {
  int64_t bad = 0;
  for (int64_t i = 0; i < pairs; i++) {
    const float ax = a[2 * i], ay = a[2 * i + 1], bx = b[2 * i], by = b[2 * i + 1];
    const float ab = fused ? fmaf(ax, by, -(ay * bx)) : ax * by - ay * bx;
    const float ba = fused ? fmaf(bx, ay, -(by * ax)) : bx * ay - by * ax;
    bad += ab != -ba;
  }
  return bad;
}

/* Draws whole tiles without looking at the image's size, into a buffer with room to spare; gives
 * how many pixels outside the image's memory were written. `buffer` holds `room` zeros. */
int64_t naive_tiles(int64_t width, int64_t height, int64_t tile, uint8_t *buffer, int64_t room) {
  int64_t outside = 0;
  for (int64_t y0 = 0; y0 < height; y0 += tile)
    for (int64_t x0 = 0; x0 < width; x0 += tile)
      for (int64_t y = y0; y < y0 + tile; y++)
        for (int64_t x = x0; x < x0 + tile; x++)
          if (y * width + x < room)
            buffer[y * width + x] = 1;
  for (int64_t i = width * height; i < room; i++)
    outside += buffer[i];
  return outside;
}

/* How many of the boxes that some ray of a packet hits are culled by four planes through the
 * corner rays' points in world coordinates: the false culls. Rays share an origin; corners are the
 * indices of the packet's corner rays in turn. */
int64_t naive_frustum_culls(const float *o, const float *d, int64_t rays, const int32_t *corner,
                            const float *boxes, int64_t count, int64_t *hit) {
  float normal[4][3], offset[4];
  for (int i = 0; i < 4; i++) {
    float p[3], q[3], a[3], b[3];
    for (int k = 0; k < 3; k++) {
      p[k] = o[k] + d[3 * corner[i] + k];
      q[k] = o[k] + d[3 * corner[(i + 1) % 4] + k];
    }
    subtract(p, o, a);
    subtract(q, o, b);
    cross(a, b, normal[i]);
    offset[i] = dot(normal[i], o);
    float inner[3];
    for (int k = 0; k < 3; k++)
      inner[k] = d[3 * corner[(i + 2) % 4] + k];
    if (dot(normal[i], inner) < 0) {
      for (int k = 0; k < 3; k++)
        normal[i][k] = -normal[i][k];
      offset[i] = -offset[i];
    }
  }
  int64_t culled = 0;
  *hit = 0;
  for (int64_t j = 0; j < count; j++) {
    const float *low = boxes + 6 * j, *high = low + 3;
    int any = 0, outside = 0;
    for (int64_t i = 0; i < rays && !any; i++) {
      double tn = 0, tf = INFINITY;
      for (int k = 0; k < 3; k++) {
        const double inverse = 1.0 / (double)d[3 * i + k];
        const double a = ((double)low[k] - o[k]) * inverse, b = ((double)high[k] - o[k]) * inverse;
        tn = fmax(tn, fmin(a, b));
        tf = fmin(tf, fmax(a, b));
      }
      any = tn <= tf;
    }
    for (int i = 0; i < 4; i++) {
      float far_point[3];
      for (int k = 0; k < 3; k++)
        far_point[k] = normal[i][k] > 0 ? high[k] : low[k];
      outside |= dot(normal[i], far_point) - offset[i] < 0;
    }
    *hit += any;
    culled += any && outside;
  }
  return culled;
}
