/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The exact test's last step for packets that begin at one point: what is the same for all rays is
 * computed once for the triangles of a block, with the operations of triangle.inl in their order.
 */

/* Of each triangle, in the order of the sheared space. */
typedef struct block_faces {
  float normal[3][VIEW_ROOM];
  float above[VIEW_ROOM];                            /* normal . (v0 - origin) */
  float to_near[3][VIEW_ROOM], to_far[3][VIEW_ROOM]; /* sides of the padded box */
} block_faces;

#define LARGER(a, b) (((a) & ((a) > (b))) | ((b) & ~((a) > (b))))

/* whittle_plane's normals of four triangles; `a` has the first vertices' rows for each axis. */
static inline void four_normals(const float *const a[3], uint32_t size, uint32_t at,
                                block_faces *faces) {
  four_doubles e1[3], e2[3], n[3], scale;
  four_longs bits[3];
  for (int k = 0; k < 3; k++) {
    four_floats v0, v1, v2;
    memcpy(&v0, a[k] + at, sizeof v0);
    memcpy(&v1, a[k] + 3 * size + at, sizeof v1);
    memcpy(&v2, a[k] + 6 * size + at, sizeof v2);
    const four_doubles from = WIDENED(v0);
    e1[k] = WIDENED(v1) - from;
    e2[k] = WIDENED(v2) - from;
  }
  n[0] = e1[1] * e2[2] - e1[2] * e2[1];
  n[1] = e1[2] * e2[0] - e1[0] * e2[2];
  n[2] = e1[0] * e2[1] - e1[1] * e2[0];
  /* whittle_to_unit, by the exponent of the largest. */
  for (int k = 0; k < 3; k++)
    bits[k] = (four_longs)n[k] & INT64_MAX;
  const four_longs two = LARGER(bits[0], bits[1]), most = LARGER(two, bits[2]) >> 52;
  const four_longs inverse = (2046 - most) - ((most == 0) & 1023);
  scale = (four_doubles)(inverse << 52);
  for (int k = 0; k < 3; k++) {
    const four_floats normal = NARROWED(n[k] * scale);
    memcpy(&faces->normal[k][at], &normal, sizeof normal);
  }
}

static inline void face_normals(const packet *p, const float *rows, uint32_t size,
                                block_faces *faces) {
  const float *const a[3] = {rows + (uint32_t)p->order[0] * size,
                             rows + (uint32_t)p->order[1] * size,
                             rows + (uint32_t)p->order[2] * size};
  for (uint32_t at = 0; at < size; at += FOUR)
    four_normals(a, size, at, faces);
}

/* The sides of each triangle's box that the rays meet first and last, as v_slab grows them. */
static inline void face_boxes(const packet *p, const block_view *view, block_faces *faces) {
  for (uint32_t at = 0; at < WHITTLE_BLOCK; at += V_LANES) {
    v_float low[3], high[3], reach = v_set(0.0f);
    for (int k = 0; k < 3; k++) {
      const v_float a = v_load(&view->vertex[k][at]), b = v_load(&view->vertex[3 + k][at]);
      const v_float c = v_load(&view->vertex[6 + k][at]);
      low[k] = v_min(v_min(a, b), c), high[k] = v_max(v_max(a, b), c);
      reach = v_max(v_max(v_set(0.0f) - low[k], high[k]), reach);
    }
    const v_float room = reach * v_set(WHITTLE_BOX_PAD);
    for (int k = 0; k < 3; k++) {
      const v_float to_low = low[k] - room, to_high = high[k] + room;
      const bool negative = p->negative[p->order[k]];
      v_store(&faces->to_near[k][at], negative ? to_high : to_low);
      v_store(&faces->to_far[k][at], negative ? to_low : to_high);
    }
  }
}

static inline void face_heights(const block_view *view, block_faces *faces) {
  for (uint32_t at = 0; at < WHITTLE_BLOCK; at += V_LANES) {
    const v_float nx = v_load(&faces->normal[0][at]), ny = v_load(&faces->normal[1][at]);
    const v_float nz = v_load(&faces->normal[2][at]);
    v_store(&faces->above[at],
            (nx * v_load(&view->vertex[0][at]) + ny * v_load(&view->vertex[1][at])) +
                nz * v_load(&view->vertex[2][at]));
  }
}

/* Where a packet keeps what decides, as pointers that the compiler can hold on to. */
typedef struct face_lanes {
  const float *inverse[3], *shear_x, *shear_y, *t_min, *length;
  float *t, *u, *v, *determinant, *deepest;
  uint32_t *record, *skip;
} face_lanes;

static inline face_lanes face_lanes_of(packet *p) {
  const uint32_t x = (uint32_t)p->order[0], y = (uint32_t)p->order[1], z = (uint32_t)p->order[2];
  return (face_lanes){{p->inverse[x], p->inverse[y], p->inverse[z]},
                      p->shear_x,
                      p->shear_y,
                      p->t_min,
                      p->direction[z],
                      p->t,
                      p->u,
                      p->v,
                      p->determinant,
                      p->groups.deepest,
                      p->record,
                      p->skip};
}

/* The distances at which a group's rays meet triangle i's plane, and the inside of its box. */
static inline v_float face_distance(const face_lanes *l, uint32_t at, const block_faces *faces,
                                    uint32_t i, v_float *near, v_float *far) {
  v_float inverse[3];
  *near = v_set(-__builtin_inff()), *far = v_set(__builtin_inff());
  for (int k = 0; k < 3; k++) {
    inverse[k] = v_load(l->inverse[k] + at);
    *near = v_max(v_set(faces->to_near[k][i]) * inverse[k], *near);
    *far = v_min(v_set(faces->to_far[k][i]) * inverse[k], *far);
  }
  const v_float along = (v_set(faces->normal[0][i]) * v_load(l->shear_x + at) +
                         v_set(faces->normal[1][i]) * v_load(l->shear_y + at)) +
                        v_set(faces->normal[2][i]);
  return v_set(faces->above[i]) / along * inverse[2];
}

/* The nearest hits of a group; their weights wait for finish_weights. */
static inline void record_nearest(packet *p, const face_lanes *l, uint32_t at, v_mask hit,
                                  uint32_t record, v_float t, const v_edges *edges,
                                  v_float determinant) {
  const v_float nearest = v_select(hit, t, v_load(l->t + at));
  v_storeu(l->record + at, v_selectu(hit, v_setu(record), v_loadu(l->record + at)));
  v_store(l->t + at, nearest);
  v_store(l->u + at, v_select(hit, edges->v, v_load(l->u + at)));
  v_store(l->v + at, v_select(hit, edges->w, v_load(l->v + at)));
  v_store(l->determinant + at, v_select(hit, determinant, v_load(l->determinant + at)));
  record_deepest(p, at, deepest_of(nearest, v_load(l->length + at)));
}

/* group_decide for rays of one origin. */
static inline __attribute__((always_inline)) bool
face_decide(const trace_context *context, packet *p, const face_lanes *l, uint32_t at,
            const block_faces *faces, uint32_t i, const v_edges *edges, v_mask lanes,
            uint32_t record, const bool any) {
  lanes = v_andnot(lanes, v_equ(v_loadu(l->skip + at), v_setu(record)));
  const v_float determinant = (edges->u + edges->v) + edges->w;
  v_float near, far, t;
  v_mask tied;
  const v_float distance = face_distance(l, at, faces, i, &near, &far);
  v_mask hit = v_settle(lanes, determinant, distance, near, far, v_load(l->t_min + at),
                        v_load(l->t + at), &t, &tied, context->own_box_misses);
  hit = settle_ties(context, p, at, hit, tied, record);
  if (!v_any(hit))
    return false;
  whittle_prefetch(&context->scene->triangles.ids[record]); /* to be asked for when all is done */
  if (any)
    record_blocked(p, at, hit, record);
  else
    record_nearest(p, l, at, hit, record, t, edges, determinant);
  return true;
}
