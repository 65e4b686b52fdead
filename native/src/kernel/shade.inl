/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Whitted shading: what a hit emits, which rays it sends on, and how it answers light. */

/* Whitted: An Improved Illumination Model for Shaded Display, CACM 1980, with Fresnel weights. */

#define INVERSE_PI 0x1.45f306p-2f

/* Reflectance of a dielectric boundary for cosine c and the cosine of refraction t (Fresnel). */
static inline float fresnel(float c, float t, float eta) {
  const float parallel = (eta * c - t) / (eta * c + t);
  const float perpendicular = (c - eta * t) / (c + eta * t);
  return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

/* A material seen at one angle. */
typedef struct response {
  vector reflect, transmit, diffuse;
  float eta;   /* index of refraction behind the surface over that before it */
  float cos_t; /* of the refracted ray; 0 at total reflection */
} response;

static inline response respond(const whittle_material *m, float c, bool outside) {
  response r;
  const float ior = m->ior > 0.0f ? m->ior : 1.5f;
  const bool opaque = !(vec_most(vec_from(m->transmission)) > 0.0f);
  r.eta = outside || opaque ? ior : 1.0f / ior;
  const float sine2 = (1.0f - c * c) / (r.eta * r.eta);
  const bool total = sine2 >= 1.0f;
  r.cos_t = total ? 0.0f : s_sqrt(1.0f - s_max(sine2, 0.0f));
  const float f = total ? 1.0f : fresnel(c, r.cos_t, r.eta);
  const float ramp = s_max(1.0f - c, 0.0f);
  const float schlick = m->metal_weight * (((ramp * ramp) * (ramp * ramp)) * ramp);
  const vector specular = vec_scale(vec_from(m->specular), f);
  const vector metal = vec_scale(vec_from(m->metal), m->metal_weight - schlick);
  r.reflect = vec_add(vec_add(vec_from(m->mirror), vec_add(metal, vec(schlick, schlick, schlick))),
                      specular);
  r.transmit = vec_scale(vec_from(m->transmission), 1.0f - f);
  /* A dielectric coat takes from the diffuse light below it what it reflects, outside and in. */
  const vector rest = vec_sub(vec(1.0f, 1.0f, 1.0f), specular);
  r.diffuse = vec_mul(vec_from(m->diffuse), rest);
  return r;
}

/* The mirrored direction, kept above the geometric surface. */
static inline vector mirrored(const surface *s) {
  const vector view = vec_from(s->view), normal = vec_from(s->normal), flat = vec_from(s->geometric);
  const vector d = vec_sub(vec_scale(normal, 2.0f * vec_dot(normal, view)), view);
  if (vec_dot(d, flat) > 0.0f)
    return d;
  return vec_sub(vec_scale(flat, 2.0f * vec_dot(flat, view)), view);
}

/* The refracted direction by Snell's law, kept below the geometric surface. */
static inline vector refracted(const surface *s, const response *r) {
  const vector view = vec_from(s->view), normal = vec_from(s->normal), flat = vec_from(s->geometric);
  const float ratio = 1.0f / r->eta;
  const vector along = vec_scale(normal, ratio * vec_dot(normal, view) - r->cos_t);
  const vector d = vec_sub(along, vec_scale(view, ratio));
  if (vec_dot(d, flat) < 0.0f)
    return d;
  const float c = vec_dot(flat, view);
  const float sine2 = (1.0f - c * c) * (ratio * ratio);
  const float cos_t = sine2 < 1.0f ? s_sqrt(1.0f - s_max(sine2, 0.0f)) : 0.0f;
  return vec_sub(vec_scale(flat, ratio * c - cos_t), vec_scale(view, ratio));
}

static inline void add_light(tile_worker *w, uint32_t slot, vector light) {
  w->sample[0][slot] += light.x;
  w->sample[1][slot] += light.y;
  w->sample[2][slot] += light.z;
}

/* Sends a ray on from a surface, if its weight is worth it. */
static inline bool spawn(const tile_context *context, tile_worker *w, ray_batch *batch,
                         const surface *s, vector direction, float side, vector weight) {
  const float most = vec_most(weight);
  if (!(most > 0.0f))
    return true;
  if (batch == NULL || most < context->settings.cutoff) {
    w->stats.secondary_rays_left_out++;
    w->stats.dropped_weight += most;
    return true;
  }
  const uint32_t i = batch->rays.count;
  if (!ray_batch_reserve(batch, i + 1))
    return false;
  float origin[3], d[3], share[3];
  surface_origin(s, side, origin);
  vec_to(direction, d);
  vec_to(weight, share);
  for (int axis = 0; axis < 3; axis++) {
    batch->rays.origin[axis][i] = origin[axis];
    batch->rays.direction[axis][i] = d[axis];
    batch->weight[axis][i] = share[axis];
  }
  batch->rays.t_min[i] = 0.0f;
  batch->rays.t[i] = __builtin_inff();
  batch->rays.skip[i] = s->record;
  batch->slot[i] = s->slot;
  batch->rays.count = i + 1;
  return true;
}

/* One hit: its own light into the sample, its secondary rays into the next generation, and what
 * lights need into the surfaces. `needs` is a constant in each kernel. */
static inline __attribute__((always_inline)) bool
shade_hit(const tile_context *context, tile_worker *w, surface *s, bool outside, ray_batch *reflection,
          ray_batch *refraction, const uint32_t needs) {
  const whittle_scene *scene = context->scene;
  const triangle_record *triangle = &scene->triangles[s->record];
  const mesh *m = &scene->meshes[scene->instances[triangle->instance].mesh];
  const uint32_t index = m->materials ? m->materials[triangle->triangle] : 0;
  const whittle_material *material = &scene->materials[index];
  const vector weight = vec_from(s->weight);
  const float c = s_min(vec_dot(vec_from(s->normal), vec_from(s->view)), 1.0f);
  const response r = respond(material, c, outside);
  const bool rough = (needs & WHITTLE_NEED_HIGHLIGHT) && material->roughness > 0.0f;

  vector light = vec_from(material->emission);
  light = vec_add(light, vec_mul(r.diffuse, vec_from(scene->world.ambient)));
  if (rough)
    light = vec_add(light, vec_mul(r.reflect, vec_from(scene->world.color)));
  add_light(w, s->slot, vec_mul(light, weight));

  vec_to(vec_scale(r.diffuse, INVERSE_PI), s->diffuse);
  vec_to(r.reflect, s->highlight);
  s->alpha = rough ? material->roughness * material->roughness : 0.0f;
  bool room = true;
  if ((needs & WHITTLE_NEED_MIRROR) && !rough)
    room = spawn(context, w, reflection, s, mirrored(s), 1.0f, vec_mul(weight, r.reflect));
  if ((needs & WHITTLE_NEED_GLASS) && r.cos_t > 0.0f)
    room = room && spawn(context, w, refraction, s, refracted(s, &r), -1.0f,
                         vec_mul(weight, r.transmit));
  return room;
}

/* The GGX highlight of a rough surface towards the view for light from `to_light` (Walter et al.,
 * Microfacet Models for Refraction, EGSR 2007), times the cosine at the surface. */
static inline float highlight(const surface *s, vector to_light, float cos_light) {
  const vector normal = vec_from(s->normal), view = vec_from(s->view);
  const vector half = vec_unit(vec_add(view, to_light));
  const float a2 = s->alpha * s->alpha;
  const float h = s_min(vec_dot(normal, half), 1.0f), c = vec_dot(normal, view);
  const float base = (h * h) * (a2 - 1.0f) + 1.0f;
  const float spread = a2 * INVERSE_PI / (base * base);
  const float mask_light = cos_light + s_sqrt(a2 + (1.0f - a2) * (cos_light * cos_light));
  const float mask_view = c + s_sqrt(a2 + (1.0f - a2) * (c * c));
  return spread * cos_light / (mask_light * mask_view);
}

/* The light that a surface would send to the pixel from one light, if nothing is in between, and
 * the shadow ray that asks. False where the light cannot reach or counts nothing. */
static inline bool light_arrives(const surface *s, const light_record *l, vector *light,
                                 vector *to_light, float origin[3]) {
  surface_origin(s, 1.0f, origin);
  float falloff = 1.0f;
  *to_light = vec_from(l->place);
  vector direction = *to_light;
  if (l->kind == WHITTLE_POINT) {
    *to_light = vec_sub(*to_light, vec_from(origin));
    const float distance2 = vec_dot(*to_light, *to_light);
    if (!(distance2 > 0.0f))
      return false;
    falloff = 1.0f / distance2;
    direction = vec_unit(*to_light);
  }
  const float cosine = vec_dot(vec_from(s->normal), direction);
  if (!(cosine > 0.0f) || !(vec_dot(vec_from(s->geometric), direction) > 0.0f))
    return false;
  vector answer = vec_scale(vec_from(s->diffuse), cosine);
  if (s->alpha > 0.0f)
    answer = vec_add(answer, vec_scale(vec_from(s->highlight), highlight(s, direction, cosine)));
  const vector arriving = vec_scale(vec_from(l->intensity), falloff);
  *light = vec_mul(vec_mul(answer, arriving), vec_from(s->weight));
  return vec_most(*light) > 0.0f && vec_most(*light) < __builtin_inff();
}
