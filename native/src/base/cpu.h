/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What this CPU and system can run. */

#pragma once

#include "whittle.h"

typedef enum whittle_level {
  WHITTLE_SSE42,
  WHITTLE_AVX2,
  WHITTLE_AVX512,
  WHITTLE_LEVELS
} whittle_level;

/* Highest level by cpuid and xgetbv, or what WHITTLE_ISA asks for; -1 and an error if that cannot
 * be had. Decided once, safe from any thread. */
int whittle_cpu_level(whittle_error *error);
