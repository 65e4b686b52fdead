/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Picks the kernels of the instruction set in use. */

#include "base/cpu.h"
#include "kernel/kernel.h"

const kernel_table *whittle_kernels(whittle_error *error) {
  static const kernel_table *const tables[WHITTLE_LEVELS] = {
      [WHITTLE_SSE42] = &whittle_kernel_sse42,
      [WHITTLE_AVX2] = &whittle_kernel_avx2,
      [WHITTLE_AVX512] = &whittle_kernel_avx512,
  };
  const int level = whittle_cpu_level(error);
  return level < 0 ? NULL : tables[level];
}
