/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Whitted shading: what hits emit, which rays they send on, and how they answer light. */

/* Whitted: An Improved Illumination Model for Shaded Display, CACM 1980, with Fresnel weights. */

#define INVERSE_PI 0x1.45f306p-2f

/* Materials of a lane group, transposed: a row for each number of whittle_material. */
typedef struct material_block {
  float row[sizeof(whittle_material) / sizeof(float)][V_LANES] __attribute__((aligned(64)));
} material_block;

#define MATERIAL_ROW(field) (offsetof(whittle_material, field) / sizeof(float))

static inline const whittle_material *material_of(const whittle_scene *scene, uint32_t record) {
  const triangle_id id = scene->triangles.ids[record];
  const mesh *m = &scene->meshes[scene->instances[id.instance].mesh];
  return &scene->materials[m->materials ? m->materials[id.triangle] : 0];
}

static inline void gather_materials(const whittle_scene *scene, const uint32_t *records,
                                    uint32_t lanes, material_block *block) {
  const uint32_t rows = sizeof(whittle_material) / sizeof(float);
  const whittle_material *each[V_LANES];
  bool same = true;
  each[0] = material_of(scene, records[0]);
  for (uint32_t lane = 1; lane < V_LANES; lane++) {
    const bool again = lane >= lanes || records[lane] == records[lane - 1];
    each[lane] = again ? each[lane - 1] : material_of(scene, records[lane]);
    same = same && each[lane] == each[0];
  }
  for (uint32_t lane = 0; lane < (same ? 1 : V_LANES); lane++) {
    float numbers[sizeof(whittle_material) / sizeof(float)];
    memcpy(numbers, each[lane], sizeof numbers);
    fill_column(block->row, rows, lane, same, numbers, 1);
  }
}

/* Reflectance of a dielectric boundary for cosine c, cosine of refraction t (Fresnel). */
static inline v_float fresnel(v_float c, v_float t, v_float eta) {
  const v_float parallel = (eta * c - t) / (eta * c + t);
  const v_float perpendicular = (c - eta * t) / (c + eta * t);
  return v_set(0.5f) * (parallel * parallel + perpendicular * perpendicular);
}

/* Materials seen at one angle. */
typedef struct response {
  v_vector reflect, transmit, diffuse;
  v_float eta;   /* index of refraction behind the surface over that before it */
  v_float cos_t; /* of the refracted ray; 0 at total reflection */
} response;

static inline response respond(material_block *m, v_float c, v_mask outside) {
  const v_float nothing = v_set(0.0f), one = v_set(1.0f);
  response r;
  const v_vector transmission = vec_rows(m->row + MATERIAL_ROW(transmission));
  const v_float given = v_load(m->row[MATERIAL_ROW(ior)]);
  const v_float ior = v_select(v_lt(nothing, given), given, v_set(1.5f));
  const v_mask inside = v_andnot(v_lt(nothing, vec_most(transmission)), outside);
  r.eta = v_select(inside, one / ior, ior);
  const v_float sine2 = (one - c * c) / (r.eta * r.eta);
  const v_mask total = v_le(one, sine2);
  r.cos_t = v_select(total, nothing, v_sqrt(v_max(one - v_max(sine2, nothing), nothing)));
  const v_float f = v_select(total, one, fresnel(c, r.cos_t, r.eta));
  const v_float ramp = v_max(one - c, nothing);
  const v_float metal_weight = v_load(m->row[MATERIAL_ROW(metal_weight)]);
  const v_float schlick = metal_weight * (((ramp * ramp) * (ramp * ramp)) * ramp);
  const v_vector tint = vec_rows(m->row + MATERIAL_ROW(specular)), specular = vec_scale(tint, f);
  const v_vector metal = vec_scale(vec_rows(m->row + MATERIAL_ROW(metal)), metal_weight - schlick);
  r.reflect = vec_add(vec_add(vec_rows(m->row + MATERIAL_ROW(mirror)),
                              vec_add(metal, vec(schlick, schlick, schlick))),
                      specular);
  r.transmit = vec_scale(transmission, one - f);
  /* A dielectric coat takes from the diffuse light below it what it reflects. */
  const v_float rest = v_select(v_lt(nothing, vec_most(tint)), one - f, one);
  r.diffuse = vec_scale(vec_rows(m->row + MATERIAL_ROW(diffuse)), rest);
  return r;
}

static inline v_vector mirror_about(v_vector view, v_vector normal) {
  return vec_sub(vec_scale(normal, v_set(2.0f) * vec_dot(normal, view)), view);
}

/* Mirrored directions, kept above the geometric surface. */
static inline v_vector mirrored(v_vector view, v_vector normal, v_vector flat) {
  const v_vector d = mirror_about(view, normal);
  return vec_select(v_lt(v_set(0.0f), vec_dot(d, flat)), d, mirror_about(view, flat));
}

/* Refracted directions by Snell's law, kept below the geometric surface. */
static inline v_vector refracted(v_vector view, v_vector normal, v_vector flat, const response *r) {
  const v_float nothing = v_set(0.0f), one = v_set(1.0f), ratio = one / r->eta;
  const v_vector back = vec_scale(view, ratio);
  const v_vector d = vec_sub(vec_scale(normal, ratio * vec_dot(normal, view) - r->cos_t), back);
  const v_mask below = v_lt(vec_dot(d, flat), nothing);
  if (v_bits(below) == (1u << V_LANES) - 1)
    return d;
  const v_float c = vec_dot(flat, view);
  const v_float sine2 = (one - c * c) * (ratio * ratio);
  const v_float cos_t = v_sqrt(v_max(one - v_max(sine2, nothing), nothing));
  return vec_select(below, d, vec_sub(vec_scale(flat, ratio * c - cos_t), back));
}

/* Adds light to the samples of the lanes of `set`, at once where each has the slot after the one
 * before; else lane by lane, because two may belong to one. Adding 0 changes no sample: none is
 * -0. */
static inline void add_light(tile_worker *w, const uint32_t *slots, uint32_t set, v_vector light) {
  const uint32_t every = (uint32_t)((1ull << V_LANES) - 1), first = slots[0];
  const v_float lights[3] = {light.x, light.y, light.z};
  if (v_bits(v_equ(v_loadu(slots), v_from(first))) == every) {
    for (int channel = 0; channel < 3; channel++) {
      float *sample = w->sample[channel] + first;
      const v_float more = v_select(v_from_bits(set), lights[channel], v_set(0.0f));
      v_store(sample, v_load(sample) + more);
    }
    return;
  }
  float value[3][V_LANES] __attribute__((aligned(64)));
  for (int channel = 0; channel < 3; channel++)
    v_store(value[channel], lights[channel]);
  for (; set; set &= set - 1) {
    const uint32_t lane = (uint32_t)__builtin_ctz(set), slot = slots[lane];
    for (int channel = 0; channel < 3; channel++)
      w->sample[channel][slot] += value[channel][lane];
  }
}

/* Who sends the rays that are about to be appended; not inlined, because hardly anyone asks. */
static __attribute__((cold)) void note_parents(ray_batch *batch, uint32_t set,
                                               const surface_batch *s, uint32_t at) {
  for (uint32_t n = batch->rays.count; set; set &= set - 1)
    batch->parent[n++] = s->first_ray + s->ray[at + (uint32_t)__builtin_ctz(set)];
}

/* Appends rays from the surfaces at `at`, those of the lanes of `set`, to a batch, in order. */
static inline bool append_rays(ray_batch *batch, uint32_t set, const surface_batch *s, uint32_t at,
                               v_vector origin, v_vector direction, v_vector weight, float t_max) {
  ray_stream *rays = &batch->rays;
  const uint32_t n = rays->count;
  if (set == 0)
    return true;
  if (!ray_batch_reserve(batch, n + V_LANES))
    return false;
  if (batch->logged)
    note_parents(batch, set, s, at);
  const v_vector from[3] = {origin, direction, weight};
  float *const *const to[3] = {rays->origin, rays->direction, batch->weight};
  for (int i = 0; i < 3; i++) {
    v_store_packed(to[i][0] + n, from[i].x, set);
    v_store_packed(to[i][1] + n, from[i].y, set);
    v_store_packed(to[i][2] + n, from[i].z, set);
  }
  v_store(rays->t_min + n, v_set(0.0f)), v_store(rays->t + n, v_set(t_max));
  v_storeu_packed(rays->skip + n, v_loadu(s->record + at), set);
  v_storeu_packed(batch->slot + n, v_loadu(s->slot + at), set);
  rays->count = n + (uint32_t)__builtin_popcount(set);
  return true;
}

/* Sends rays on from the lanes of `lanes` whose weight is worth it; batch NULL: deep enough. */
static inline __attribute__((always_inline)) bool spawn(const tile_context *context, tile_worker *w,
                                                        ray_batch *batch, uint32_t at,
                                                        uint32_t lanes, v_vector direction,
                                                        float side, v_vector weight) {
  const surface_batch *s = &w->surfaces;
  const v_float most = vec_most(weight);
  lanes &= v_bits(v_lt(v_set(0.0f), most));
  const uint32_t worth =
      batch == NULL ? 0 : lanes & ~v_bits(v_lt(most, v_set(context->settings.cutoff)));
  float dropped[V_LANES] __attribute__((aligned(64)));
  v_store(dropped, most);
  for (uint32_t set = lanes & ~worth; set; set &= set - 1) {
    w->stats.secondary_rays_left_out++;
    w->stats.dropped_weight += dropped[__builtin_ctz(set)];
  }
  return worth == 0 || append_rays(batch, worth, s, at, surface_origins(s, at, side), direction,
                                   weight, __builtin_inff());
}

/* A group of hits: their own light into the sample, their secondary rays into the next generation,
 * and into the surfaces what lights will ask. `needs` is a constant in each kernel. */
static inline __attribute__((always_inline)) bool
shade_group(const tile_context *context, tile_worker *w, uint32_t at, uint32_t count,
            v_mask outside, ray_batch *reflection, ray_batch *refraction, const uint32_t needs) {
  const whittle_scene *scene = context->scene;
  surface_batch *s = &w->surfaces;
  const uint32_t lanes = (uint32_t)((1ull << count) - 1);
  material_block m;
  gather_materials(scene, s->record + at, count, &m);
  const v_vector view = vec_load(s->view, at), normal = vec_load(s->normal, at);
  const v_vector flat = vec_load(s->geometric, at), weight = vec_load(s->weight, at);
  const v_float nothing = v_set(0.0f);
  const response r = respond(&m, v_min(vec_dot(normal, view), v_set(1.0f)), outside);
  const v_float roughness = v_load(m.row[MATERIAL_ROW(roughness)]);
  const v_mask rough = v_lt(nothing, roughness);

  v_vector light = vec_rows(m.row + MATERIAL_ROW(emission));
  light = vec_add(light, vec_mul(r.diffuse, vec_set(scene->world.ambient)));
  if (needs & WHITTLE_NEED_HIGHLIGHT) {
    const v_vector around = vec_mul(r.reflect, vec_set(scene->world.color));
    light = vec_add(light, vec_select(rough, around, vec(nothing, nothing, nothing)));
    vec_store(s->highlight, at, r.reflect);
    v_store(s->alpha + at, v_select(rough, roughness * roughness, nothing));
  }
  add_light(w, s->slot + at, lanes, vec_mul(light, weight));
  const v_vector diffuse = vec_scale(r.diffuse, v_set(INVERSE_PI));
  vec_store(s->diffuse, at, diffuse);
  /* What neither scatters nor shines sends 0 of any light, or no number: neither counts. */
  uint32_t dark = v_bits(v_eq(vec_most(vec_abs(diffuse)), nothing));
  if (needs & WHITTLE_NEED_HIGHLIGHT)
    dark &= ~v_bits(rough);
  if ((lanes & ~dark) != 0) {
    s->lit[s->lit_groups++] = at;
    vec_store(s->origin, at, surface_origins(s, at, 1.0f));
  }

  bool room = true;
  if (needs & WHITTLE_NEED_MIRROR)
    room = spawn(context, w, reflection, at, lanes & ~v_bits(rough), mirrored(view, normal, flat),
                 1.0f, vec_mul(weight, r.reflect));
  if (needs & WHITTLE_NEED_GLASS)
    room = room && spawn(context, w, refraction, at, lanes & v_bits(v_lt(nothing, r.cos_t)),
                         refracted(view, normal, flat, &r), -1.0f, vec_mul(weight, r.transmit));
  return room;
}

/* GGX highlights towards the view for light from `to_light` (Walter et al., Microfacet Models for
 * Refraction, EGSR 2007), times the cosine at the surface. */
static inline v_float highlights(v_vector view, v_vector normal, v_float alpha, v_vector to_light,
                                 v_float cos_light) {
  const v_float one = v_set(1.0f);
  const v_vector half = vec_unit(vec_add(view, to_light), normal);
  const v_float a2 = alpha * alpha;
  const v_float h = v_min(vec_dot(normal, half), one), c = vec_dot(normal, view);
  const v_float base = (h * h) * (a2 - one) + one;
  const v_float spread = a2 * v_set(INVERSE_PI) / (base * base);
  const v_float mask_light = cos_light + v_sqrt(a2 + (one - a2) * (cos_light * cos_light));
  const v_float mask_view = c + v_sqrt(a2 + (one - a2) * (c * c));
  return spread * cos_light / (mask_light * mask_view);
}

/* The light that surfaces would send to the pixel from one light, if nothing is in between, and
 * the shadow rays that ask. Gives the lanes where the light arrives and counts. */
static inline uint32_t light_arrives(const tile_context *context, const surface_batch *s,
                                     uint32_t at, const light_record *l, v_vector origin,
                                     v_vector *light, v_vector *to_light) {
  const v_float nothing = v_set(0.0f);
  const v_vector normal = vec_load(s->normal, at), flat = vec_load(s->geometric, at);
  v_float falloff = v_set(1.0f);
  *to_light = vec_set(l->place);
  v_vector direction = *to_light;
  if (l->kind == WHITTLE_POINT) {
    *to_light = vec_sub(*to_light, origin);
    direction = vec_unit(*to_light, vec_scale(flat, v_set(-1.0f)));
    falloff = v_set(1.0f) / vec_dot(*to_light, *to_light);
  }
  const v_float cosine = vec_dot(normal, direction);
  const v_mask facing = v_and(v_lt(nothing, cosine), v_lt(nothing, vec_dot(flat, direction)));
  v_vector answer = vec_scale(vec_load(s->diffuse, at), cosine);
  if (context->needs & WHITTLE_NEED_HIGHLIGHT) {
    const v_float alpha = v_load(s->alpha + at);
    const v_float shine = highlights(vec_load(s->view, at), normal, alpha, direction, cosine);
    const v_float kept = v_select(v_lt(nothing, alpha), shine, nothing);
    answer = vec_add(answer, vec_scale(vec_load(s->highlight, at), kept));
  }
  const v_vector arriving = vec_scale(vec_set(l->intensity), falloff);
  *light = vec_mul(vec_mul(answer, arriving), vec_load(s->weight, at));
  const v_float most = vec_most(*light);
  const v_mask counts = v_and(v_lt(nothing, most), v_lt(most, v_set(__builtin_inff())));
  return v_bits(v_and(facing, counts));
}
