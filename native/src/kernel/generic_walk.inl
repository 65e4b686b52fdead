/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Packets of rays that share no more than their class on their way down the tree with eight
 * children: reflected, refracted and shadow rays that no point sees, and rays of a point where a
 * pixel holds so many triangles that seeing them from there does not pay. */

/* Rays of a class that make a packet: those of a list, or with list NULL first .. first + count. */
typedef struct generic_job {
  const uint32_t *list;
  uint32_t first, count, class;
} generic_job;

#define GENERIC_JOBS (2 * WHITTLE_MAX_PACKET / GENERIC_RAYS)
typedef struct generic_jobs {
  uint32_t count;
  generic_job job[GENERIC_JOBS];
} generic_jobs;

/* A packet on its way. Nothing on the stack is too deep, or without rays, for its top. */
typedef struct generic_walk {
  generic_packet packet;
  uint32_t count, height;
  bool borrows;
  uint32_t list[GENERIC_RAYS];
  generic_entry stack[WIDE_STACK];
} generic_walk;

/* While one packet's next node comes from memory, others go on: so many at once, if the scene is
 * too large for the caches. */
#define GENERIC_TURNS 4
#define GENERIC_FAR (1u << 21) /* triangles */

#define GENERIC_LATELY 4096 /* rays */

/* Whether anything is left to do; then it is on top of the stack. */
static inline bool generic_settle(generic_walk *w) {
  const generic_packet *p = &w->packet;
  for (; w->height > 0; w->height--) {
    generic_entry *top = &w->stack[w->height - 1];
    top->active &= p->alive;
    if (top->active == 0 || top->front > p->whole.deepest)
      continue;
    if ((top->active & (top->active - 1)) != 0)
      return true;
    const uint32_t i = (uint32_t)__builtin_ctz(top->active);
    if (top->front <= generic_depth(p, i, p->rays.t[i]) * (1.0f + FRUSTUM_SLACK))
      return true;
  }
  return false;
}

/* Visits a node or a leaf; false if it was the last. */
static inline __attribute__((always_inline)) bool generic_step(const trace_context *context,
                                                               generic_walk *w, const bool any) {
  const generic_entry entry = w->stack[--w->height];
  const bool few = __builtin_popcount(entry.active) <= GENERIC_FEW;
  generic_packet *p = &w->packet;
  const v_frustum f = frustum_everywhere(&p->whole);
  if (wide_is_leaf(entry.child)) {
    context->memory->leaves += (uint32_t)__builtin_popcount(entry.active);
    if (few)
      generic_few_leaf(context, p, entry.child, entry.active, any);
    else
      generic_leaf(context, p, &f, entry.child, entry.active, any);
    return generic_settle(w);
  }
  const wide_node *node = &context->scene->wide[entry.child.first];
  generic_children children;
  if (few)
    generic_few_open(p, node, entry, &children);
  else
    generic_open(p, &f, node, entry, &children);
  w->height = generic_push(context->scene, node, &children, w->stack, w->height);
  return generic_settle(w);
}

/* Without `resume` the rays have not hit anything yet. */
static void generic_begin(generic_walk *w, ray_stream *rays, const generic_job *job, bool any,
                          bool resume) {
  generic_packet *p = &w->packet;
  w->count = job->count;
  w->borrows = job->list == NULL && job->count == GENERIC_RAYS && job->first % V_LANES == 0;
  if (w->borrows) {
    generic_borrow(p, rays, job->first);
  } else {
    for (uint32_t i = 0; i < job->count; i++)
      w->list[i] = job->list ? job->list[i] : job->first + i;
    generic_gather(p, rays, w->list, job->count, resume);
  }
  generic_prepare(p, job->count, job->class, any, resume);
  w->stack[0] = (generic_entry){{0, WIDE_NODE}, 0.0f, p->alive};
  w->height = p->alive != 0;
}

/* Counts rays, and forgets what is long ago. */
static void generic_count(packet_memory *memory, const generic_jobs *jobs) {
  if (memory->rays >= GENERIC_LATELY)
    memory->rays /= 2, memory->leaves /= 2;
  for (uint32_t i = 0; i < jobs->count; i++)
    memory->rays += jobs->job[i].count;
}

static inline __attribute__((always_inline)) void generic_go(const trace_context *context,
                                                             ray_stream *rays,
                                                             const generic_jobs *jobs,
                                                             const bool any, bool resume) {
  const uint32_t turns = context->scene->triangle_count < GENERIC_FAR ? 1 : GENERIC_TURNS;
  generic_walk walks[GENERIC_TURNS], *going[GENERIC_TURNS];
  uint32_t count = 0, next = 0;
  for (; count < turns && next < jobs->count; count++) {
    going[count] = &walks[count];
    generic_begin(going[count], rays, &jobs->job[next++], any, resume);
  }
  for (uint32_t k = 0; count > 0; k = k + 1 < count ? k + 1 : 0) {
    generic_walk *w = going[k];
    if (w->height > 0 && generic_step(context, w, any))
      continue;
    if (!w->borrows)
      generic_scatter(&w->packet, rays, w->list, w->count);
    if (next < jobs->count)
      generic_begin(w, rays, &jobs->job[next++], any, resume);
    else
      going[k] = going[--count];
  }
}

static __attribute__((noinline)) void generic_go_any(const trace_context *context, ray_stream *rays,
                                                     const generic_jobs *jobs, bool resume) {
  generic_go(context, rays, jobs, true, resume);
}

static __attribute__((noinline)) void generic_go_closest(const trace_context *context,
                                                         ray_stream *rays, const generic_jobs *jobs,
                                                         bool resume) {
  generic_go(context, rays, jobs, false, resume);
}

static void generic_trace(const trace_context *context, ray_stream *rays, const generic_jobs *jobs,
                          bool any, bool resume) {
  generic_count(context->memory, jobs);
  any ? generic_go_any(context, rays, jobs, resume)
      : generic_go_closest(context, rays, jobs, resume);
}

/* Cuts rays of a class into packets. */
static void generic_add(generic_jobs *jobs, const uint32_t *list, uint32_t first, uint32_t count,
                        uint32_t class) {
  for (uint32_t k = 0; k < count; k += GENERIC_RAYS) {
    const uint32_t here = count - k < GENERIC_RAYS ? count - k : GENERIC_RAYS;
    jobs->job[jobs->count++] = (generic_job){list ? list + k : NULL, first + k, here, class};
  }
}
