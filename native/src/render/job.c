/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* A render on a thread of its own, which can be asked, stopped and waited for. */

#define _POSIX_C_SOURCE 200809L

#include "render/render.h"

#include "base/memory.h"

#include <pthread.h>

struct whittle_job {
  const whittle_scene *scene;
  whittle_camera camera;
  whittle_settings settings;
  whittle_image image;
  whittle_run_state state;
  whittle_render_stats stats;
  whittle_error error;
  whittle_status status;
  atomic_int ended;
  pthread_t thread;
  bool joined;
};

static void *run(void *argument) {
  whittle_job *job = argument;
  job->status = whittle_render_run(job->scene, &job->camera, &job->settings, &job->image, NULL,
                                   &job->stats, &job->state, &job->error);
  atomic_store(&job->ended, 1);
  return NULL;
}

whittle_status whittle_job_start(const whittle_scene *scene, const whittle_camera *camera,
                                 const whittle_settings *settings, const whittle_image *image,
                                 whittle_job **job, whittle_error *error) {
  whittle_job *new = whittle_allocate(1, sizeof *new);
  if (new == NULL)
    return whittle_out_of_memory(error, "a job");
  *new = (whittle_job){.scene = scene, .camera = *camera, .settings = *settings, .image = *image};
  new->settings.progress = (whittle_progress){0};
  if (pthread_create(&new->thread, NULL, run, new) != 0) {
    whittle_release(new);
    return whittle_out_of_memory(error, "a thread");
  }
  *job = new;
  return WHITTLE_OK;
}

double whittle_job_poll(const whittle_job *job, int *done) {
  if (done != NULL)
    *done = atomic_load(&job->ended);
  const double total = (double)job->state.total;
  const double units = (double)atomic_load_explicit(&job->state.done, memory_order_relaxed);
  if (total > 0.0)
    return units < total ? units / total : 1.0;
  return atomic_load(&job->ended) ? 1.0 : 0.0;
}

void whittle_job_cancel(whittle_job *job) {
  atomic_store(&job->state.cancelled, 1);
}

whittle_status whittle_job_wait(whittle_job *job, whittle_render_stats *stats,
                                whittle_error *error) {
  if (!job->joined)
    pthread_join(job->thread, NULL);
  job->joined = true;
  if (stats != NULL && job->status == WHITTLE_OK)
    *stats = job->stats;
  if (error != NULL)
    *error = job->error;
  return job->status;
}

void whittle_job_destroy(whittle_job *job) {
  if (job == NULL)
    return;
  whittle_job_cancel(job);
  whittle_job_wait(job, NULL, NULL);
  whittle_release(job);
}
