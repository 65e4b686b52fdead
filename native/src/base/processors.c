/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Processors online, allowed by affinity, and paid for by a container's quota. */

#include "base/processors.h"
#include "base/memory.h"
#include "whittle.h"

#include <errno.h>
#include <sched.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { LONGEST_PATH = 1024, LONGEST_NAME = 32 };

static uint32_t whole(double quota, double period) {
  if (!(quota > 0.0) || !(period > 0.0) || quota / period >= UINT32_MAX)
    return UINT32_MAX;
  const uint32_t processors = (uint32_t)(quota / period);
  return processors ? processors : 1;
}

/* Reads a file with one number: -1 if it cannot be had. */
static double read_number(const char *folder, const char *name) {
  char path[LONGEST_PATH + LONGEST_NAME];
  double number = -1.0;
  snprintf(path, sizeof path, "%s/%s", folder, name);
  FILE *file = fopen(path, "r");
  if (!file)
    return -1.0;
  if (fscanf(file, "%lf", &number) != 1)
    number = -1.0;
  fclose(file);
  return number;
}

/* Version 2: "cpu.max" holds the quota, or "max", and the period. */
static uint32_t quota_v2(const char *folder) {
  char path[LONGEST_PATH + LONGEST_NAME];
  double quota = -1.0, period = -1.0;
  snprintf(path, sizeof path, "%s/cpu.max", folder);
  FILE *file = fopen(path, "r");
  if (!file)
    return UINT32_MAX;
  const int read = fscanf(file, "%lf %lf", &quota, &period);
  fclose(file);
  return read == 2 ? whole(quota, period) : UINT32_MAX;
}

static uint32_t quota_v1(const char *folder) {
  return whole(read_number(folder, "cpu.cfs_quota_us"), read_number(folder, "cpu.cfs_period_us"));
}

/* The least quota from the group's own folder up to `mount`: each level limits those below. In a
 * container the group's path may be the host's; then only the mount itself is found. */
static uint32_t least_quota(const char *mount, const char *group,
                            uint32_t (*quota)(const char *folder)) {
  char folder[LONGEST_PATH];
  const size_t shortest = strlen(mount);
  snprintf(folder, sizeof folder, "%s%s", mount, group);
  uint32_t least = UINT32_MAX;
  for (;;) {
    const uint32_t here = quota(folder);
    least = here < least ? here : least;
    char *slash = strrchr(folder, '/');
    if (strlen(folder) <= shortest || !slash)
      return least;
    *slash = '\0';
    if (strlen(folder) < shortest)
      return least;
  }
}

/* Whether a comma-separated list of controllers has "cpu". */
static int has_cpu(const char *list) {
  for (const char *item = list; item; item = strchr(item, ',') ? strchr(item, ',') + 1 : NULL)
    if (strncmp(item, "cpu", 3) == 0 && (item[3] == ',' || item[3] == '\0'))
      return 1;
  return 0;
}

uint32_t whittle_quota_processors(const char *groups, const char *root) {
  char line[LONGEST_PATH], mount[LONGEST_PATH];
  uint32_t least = UINT32_MAX;
  FILE *file = fopen(groups, "r");
  if (!file)
    return least;
  while (fgets(line, sizeof line, file)) {
    line[strcspn(line, "\n")] = '\0';
    char *controllers = strchr(line, ':');
    char *group = controllers ? strchr(controllers + 1, ':') : NULL;
    if (!group)
      continue;
    controllers++;
    *group++ = '\0';
    uint32_t here = UINT32_MAX;
    if (*controllers == '\0') {
      here = least_quota(root, group, quota_v2);
    } else if (has_cpu(controllers)) {
      snprintf(mount, sizeof mount, "%.511s/%.511s", root, controllers);
      here = least_quota(mount, group, quota_v1);
      snprintf(mount, sizeof mount, "%.511s/cpu", root);
      const uint32_t alias = least_quota(mount, group, quota_v1);
      here = alias < here ? alias : here;
    }
    least = here < least ? here : least;
  }
  fclose(file);
  return least;
}

/* Processors in this process's affinity mask, or 0 if it cannot be had. The kernel refuses a mask
 * that is shorter than its own. */
static uint32_t allowed_processors(void) {
  for (size_t processors = 1024; processors <= 1 << 20; processors *= 2) {
    const size_t size = processors / 8;
    cpu_set_t *set = whittle_allocate(size, 1);
    if (!set)
      return 0;
    const int got = sched_getaffinity(0, size, set);
    const int count = got == 0 ? CPU_COUNT_S(size, set) : 0;
    const int again = got != 0 && errno == EINVAL;
    whittle_release(set);
    if (!again)
      return (uint32_t)count;
  }
  return 0;
}

uint32_t whittle_default_threads(void) {
  const long online = sysconf(_SC_NPROCESSORS_ONLN);
  uint32_t least = online > 0 ? (uint32_t)online : 1;
  const uint32_t allowed = allowed_processors();
  if (allowed && allowed < least)
    least = allowed;
  const uint32_t paid = whittle_quota_processors("/proc/self/cgroup", "/sys/fs/cgroup");
  return paid < least ? paid : least;
}
