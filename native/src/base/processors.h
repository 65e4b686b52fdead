/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* How many processors this process may use. */

#pragma once

#include <stdint.h>

/* Whole processors of the container's quota, by the cgroup files (version 2 or 1) that `groups`
 * ("/proc/self/cgroup") names below `root` ("/sys/fs/cgroup"): at least 1, UINT32_MAX: no quota. */
uint32_t whittle_quota_processors(const char *groups, const char *root);
