/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The floating-point environment in which all results are made, and its return. */

#pragma once

#include <xmmintrin.h>

/* Round to nearest, denormals kept, no traps: a host may have set anything (MXCSR is by thread). */
static inline unsigned whittle_float_mode_enter(void) {
  const unsigned before = _mm_getcsr();
  _mm_setcsr(0x1f80);
  return before;
}

static inline void whittle_float_mode_leave(unsigned before) {
  _mm_setcsr(before);
}
