/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Embree's packets of WIDTH rays; embree_trace.c includes this once for each width. */

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define NAMED(name) JOIN(name, WIDTH)

typedef struct NAMED(packet_) {
  float origin[3][WIDTH], t_near[WIDTH], direction[3][WIDTH], time[WIDTH], t_far[WIDTH];
  uint32_t mask[WIDTH], id[WIDTH], flags[WIDTH];
  float normal[3][WIDTH], u[WIDTH], v[WIDTH];
  uint32_t triangle[WIDTH], geometry[WIDTH], instance[EMBREE_INSTANCE_WORDS][WIDTH];
} __attribute__((aligned(64))) NAMED(packet_);

static void NAMED(fill_)(NAMED(packet_) * p, const stream *s, size_t first, size_t count) {
  for (int k = 0; k < 3; k++) {
    const float *origins = s->origins + (size_t)k * (s->one_origin ? 1 : s->count);
    for (size_t i = 0; i < count; i++)
      p->origin[k][i] = s->one_origin ? origins[0] : origins[first + i];
    memcpy(p->direction[k], s->directions + (size_t)k * s->count + first, count * sizeof(float));
  }
  for (size_t i = 0; i < WIDTH; i++) {
    p->t_far[i] = s->t_max;
    p->geometry[i] = EMBREE_NOTHING;
  }
}

static void NAMED(read_)(const NAMED(packet_) * p, const hits *h, size_t first, size_t count) {
  for (size_t i = 0; i < count; i++) {
    int missed = p->geometry[i] == EMBREE_NOTHING;
    h->t[first + i] = missed ? INFINITY : p->t_far[i];
    h->triangle[first + i] = missed ? -1 : (int32_t)p->triangle[i];
    h->u[first + i] = p->u[i];
    h->v[first + i] = p->v[i];
  }
}

static void NAMED(trace_)(const embree *e, embree_query *query, const stream *s, const hits *h,
                          size_t first, size_t count) {
  NAMED(packet_) packet;
  memset(&packet, 0, sizeof(packet));
  memset(packet.mask, 0xff, sizeof(packet.mask));
  int valid[WIDTH] __attribute__((aligned(64)));
  for (size_t i = 0; i < count; i += WIDTH) {
    size_t lanes = count - i < WIDTH ? count - i : WIDTH;
    if (i == 0 || lanes < WIDTH)
      for (size_t lane = 0; lane < WIDTH; lane++)
        valid[lane] = lane < lanes ? -1 : 0;
    /* Whole packets are the rule: a constant count lets the compiler unroll them. */
    if (lanes == WIDTH)
      NAMED(fill_)(&packet, s, first + i, WIDTH);
    else
      NAMED(fill_)(&packet, s, first + i, lanes);
    if (s->any_hit) {
      e->library.NAMED(any_)(valid, e->scene, &packet, query);
      for (size_t lane = 0; lane < lanes; lane++)
        h->blocked[first + i + lane] = packet.t_far[lane] < 0;
    } else {
      e->library.NAMED(closest_)(valid, e->scene, &packet, query);
      if (lanes == WIDTH)
        NAMED(read_)(&packet, h, first + i, WIDTH);
      else
        NAMED(read_)(&packet, h, first + i, lanes);
    }
  }
}

#undef NAMED
#undef JOIN
#undef JOIN_
