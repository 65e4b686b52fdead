/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Primary, shadow, mirror and random rays. */

#include "rays.h"

#include "fail.h"
#include "random.h"

#include <stdlib.h>
#include <string.h>

static stream stream_new(const char *kind, size_t count, int one_origin) {
  stream s = {.kind = kind, .count = count, .one_origin = one_origin, .t_max = INFINITY};
  s.origins = allocate((one_origin ? 1 : count) * 3, sizeof(float));
  s.directions = allocate(count * 3, sizeof(float));
  return s;
}

void stream_free(stream *s) {
  free(s->origins);
  free(s->directions);
  memset(s, 0, sizeof(*s));
}

hits hits_new(const stream *s) {
  hits h = {0};
  if (s->any_hit) {
    h.blocked = allocate(s->count, 1);
    return h;
  }
  h.t = allocate(s->count, sizeof(float));
  h.triangle = allocate(s->count, sizeof(int32_t));
  h.u = allocate(s->count, sizeof(float));
  h.v = allocate(s->count, sizeof(float));
  return h;
}

void hits_free(hits *h) {
  free(h->t);
  free(h->triangle);
  free(h->u);
  free(h->v);
  free(h->blocked);
  memset(h, 0, sizeof(*h));
}

static void set_direction(stream *s, size_t ray, vector d) {
  s->directions[ray] = d.x;
  s->directions[s->count + ray] = d.y;
  s->directions[2 * s->count + ray] = d.z;
}

static void set_origin(stream *s, size_t ray, vector o) {
  s->origins[ray] = o.x;
  s->origins[s->count + ray] = o.y;
  s->origins[2 * s->count + ray] = o.z;
}

/* Squares within squares: the pixels of one size of square, then those of the next. */
typedef struct square_order {
  unsigned width, height;
  void (*visit)(void *user, unsigned x, unsigned y);
  void *user;
} square_order;

static void visit_square(const square_order *o, unsigned x0, unsigned y0, unsigned side) {
  static const unsigned smaller[33] = {[32] = 16, [16] = 4, [4] = 1};
  if (x0 >= o->width || y0 >= o->height)
    return;
  if (side == 1) {
    o->visit(o->user, x0, y0);
    return;
  }
  unsigned step = smaller[side];
  for (unsigned y = 0; y < side; y += step)
    for (unsigned x = 0; x < side; x += step)
      visit_square(o, x0 + x, y0 + y, step);
}

typedef struct pinhole {
  stream *stream;
  size_t next;
  vector forward, right, up; /* right and up reach the image's edge */
  unsigned width, height;
} pinhole;

static void add_pixel(void *user, unsigned x, unsigned y) {
  pinhole *p = user;
  float a = 2 * ((float)x + 0.5f) / (float)p->width - 1;
  float b = 2 * ((float)y + 0.5f) / (float)p->height - 1;
  vector d = add(p->forward, add(scale(p->right, a), scale(p->up, b)));
  set_direction(p->stream, p->next++, normalise(d));
}

stream rays_primary(const mesh *m, unsigned width, unsigned height) {
  stream s = stream_new("primary", (size_t)width * height, 1);
  const camera *c = &m->camera;
  s.origins[0] = c->eye.x;
  s.origins[1] = c->eye.y;
  s.origins[2] = c->eye.z;
  float tall = tanf(c->fov * 3.14159265f / 360);
  vector forward = normalise(subtract(c->target, c->eye));
  vector right = normalise(cross(forward, c->up));
  if (length(right) == 0)
    fail("the camera looks along its up vector, or at its own place");
  vector up = cross(right, forward);
  pinhole p = {
      &s,    0,     forward, scale(right, tall * (float)width / (float)height), scale(up, tall),
      width, height};
  square_order order = {width, height, add_pixel, &p};
  for (unsigned y = 0; y < height; y += 32)
    for (unsigned x = 0; x < width; x += 32)
      visit_square(&order, x, y, 32);
  return s;
}

static size_t count_hits(const stream *s, const hits *found) {
  size_t count = 0;
  for (size_t i = 0; i < s->count; i++)
    count += found->triangle[i] >= 0;
  return count;
}

/* A hit as the next ray needs it. */
typedef struct surface {
  vector point;     /* off the surface by 1e-5 of the scene's size, on the seen side */
  vector geometric; /* unit normal towards the viewer */
  vector smooth;    /* unit normal, not turned */
  vector incoming;
} surface;

static surface surface_at(const mesh *m, const stream *primary, const hits *found, size_t ray,
                          float offset) {
  size_t triangle = (size_t)found->triangle[ray];
  surface s;
  s.incoming = (vector){stream_direction(primary, ray, 0), stream_direction(primary, ray, 1),
                        stream_direction(primary, ray, 2)};
  vector eye = vector_from(primary->origins);
  vector a = mesh_vertex(m, triangle, 0);
  vector n =
      cross(subtract(mesh_vertex(m, triangle, 1), a), subtract(mesh_vertex(m, triangle, 2), a));
  s.geometric = normalise(n);
  if (dot(s.geometric, s.incoming) > 0)
    s.geometric = scale(s.geometric, -1);
  s.point = add(eye, scale(s.incoming, found->t[ray]));
  s.point = add(s.point, scale(s.geometric, offset));
  const uint32_t *corners = m->triangles + triangle * 3;
  float u = found->u[ray], v = found->v[ray];
  vector smooth = scale(vector_from(m->normals + (size_t)corners[0] * 3), 1 - u - v);
  smooth = add(smooth, scale(vector_from(m->normals + (size_t)corners[1] * 3), u));
  smooth = add(smooth, scale(vector_from(m->normals + (size_t)corners[2] * 3), v));
  s.smooth = normalise(smooth);
  return s;
}

static vector mirrored(vector d, vector n) {
  return subtract(d, scale(n, 2 * dot(d, n)));
}

static vector light_direction(const mesh *m, const surface *s) {
  return subtract(m->light, s->point);
}

/* Mirrors on the smooth normal, or on the geometric one where that would enter the surface. */
static vector mirror_direction(const mesh *m, const surface *s) {
  (void)m;
  vector d = mirrored(s->incoming, s->smooth);
  if (dot(d, s->geometric) > 0)
    return d;
  return mirrored(s->incoming, s->geometric);
}

/* One ray from each hit, in the order of the primary rays. */
static stream rays_onward(const char *kind, const mesh *m, const stream *primary, const hits *found,
                          vector (*direction)(const mesh *, const surface *)) {
  stream s = stream_new(kind, count_hits(primary, found), 0);
  float offset = 1e-5f * mesh_size(m);
  for (size_t ray = 0, next = 0; ray < primary->count; ray++) {
    if (found->triangle[ray] < 0)
      continue;
    surface at = surface_at(m, primary, found, ray, offset);
    set_origin(&s, next, at.point);
    set_direction(&s, next++, direction(m, &at));
  }
  return s;
}

stream rays_shadow(const mesh *m, const stream *primary, const hits *found) {
  stream s = rays_onward("shadow", m, primary, found, light_direction);
  s.any_hit = 1;
  s.t_max = 0.9999f;
  return s;
}

stream rays_mirror(const mesh *m, const stream *primary, const hits *found) {
  return rays_onward("mirror", m, primary, found, mirror_direction);
}

stream rays_random(const mesh *m, size_t count) {
  stream s = stream_new("random", count, 0);
  vector low, high;
  mesh_bounds(m, &low, &high);
  vector extent = subtract(high, low);
  random_state state = random_seed(3);
  for (size_t i = 0; i < count; i++) {
    float x = random_unit(&state), y = random_unit(&state), z = random_unit(&state);
    set_origin(&s, i, add(low, (vector){extent.x * x, extent.y * y, extent.z * z}));
    set_direction(&s, i, random_direction(&state));
  }
  return s;
}
