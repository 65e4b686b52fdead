/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Choosing the instruction set by cpuid and xgetbv, or by WHITTLE_ISA. */

#include "base/cpu.h"
#include "base/error.h"

#include <cpuid.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

static const char *const NAMES[WHITTLE_LEVELS] = {"sse4.2", "avx2", "avx512"};

#define BIT(n) (1u << (n))

/* Which register files the system saves on a switch (XCR0). */
static unsigned saved_state(void) {
  unsigned low, high;
  __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
  return low;
}

/* The highest level that can run, or -1. */
static int detect(void) {
  const unsigned sse = BIT(20) | BIT(23);                        /* SSE4.2, POPCNT */
  const unsigned avx = BIT(12) | BIT(27) | BIT(28);              /* FMA, OSXSAVE, AVX */
  const unsigned avx2 = BIT(3) | BIT(5) | BIT(8);                /* BMI1, AVX2, BMI2 */
  const unsigned avx512 = BIT(16) | BIT(17) | BIT(30) | BIT(31); /* F, DQ, BW, VL */
  const unsigned lzcnt = BIT(5);
  const unsigned saved_avx = BIT(1) | BIT(2);             /* XMM, YMM */
  const unsigned saved_avx512 = BIT(5) | BIT(6) | BIT(7); /* opmask, ZMM low and high */
  unsigned a, b, c, d;
  if (!__get_cpuid(1, &a, &b, &c, &d) || (c & sse) != sse)
    return -1;
  if ((c & avx) != avx)
    return WHITTLE_SSE42;
  const unsigned saved = saved_state();
  if ((saved & saved_avx) != saved_avx || !__get_cpuid_count(7, 0, &a, &b, &c, &d) ||
      (b & avx2) != avx2)
    return WHITTLE_SSE42;
  const unsigned leaf_7 = b;
  if (!__get_cpuid(0x80000001, &a, &b, &c, &d) || !(c & lzcnt))
    return WHITTLE_SSE42;
  if ((saved & saved_avx512) != saved_avx512 || (leaf_7 & avx512) != avx512)
    return WHITTLE_AVX2;
  return WHITTLE_AVX512;
}

static int named(const char *name) {
  for (int level = 0; level < WHITTLE_LEVELS; level++)
    if (strcmp(name, NAMES[level]) == 0)
      return level;
  return -1;
}

static int choose(const char *wish, whittle_error *error) {
  const int highest = detect();
  if (highest < 0) {
    whittle_fail(error, WHITTLE_UNSUPPORTED, "", "This CPU lacks SSE4.2, which Whittle needs.");
    return -1;
  }
  if (!wish || !*wish)
    return highest;
  const int level = named(wish);
  if (level < 0)
    whittle_fail(error, WHITTLE_UNSUPPORTED, "WHITTLE_ISA",
                 "WHITTLE_ISA is \"%.32s\": set it to sse4.2, avx2 or avx512, or unset it.", wish);
  else if (level > highest)
    whittle_fail(error, WHITTLE_UNSUPPORTED, "WHITTLE_ISA",
                 "WHITTLE_ISA is \"%s\", but this CPU or system runs at most %s.", wish,
                 NAMES[highest]);
  return level > highest ? -1 : level;
}

int whittle_cpu_level(whittle_error *error) {
  static atomic_int decided = 0; /* level + 1; two threads that decide at once decide the same */
  const int before = atomic_load_explicit(&decided, memory_order_relaxed);
  if (before > 0)
    return before - 1;
  const int level = choose(getenv("WHITTLE_ISA"), error);
  if (level >= 0)
    atomic_store_explicit(&decided, level + 1, memory_order_relaxed);
  return level;
}

const char *whittle_isa(whittle_error *error) {
  const int level = whittle_cpu_level(error);
  return level < 0 ? NULL : NAMES[level];
}

const char *const *whittle_isas(void) {
  /* One list for each highest level, so that nothing is written at run time. */
  static const char *const lists[WHITTLE_LEVELS + 1][WHITTLE_LEVELS + 1] = {
      {NULL},
      {"sse4.2", NULL},
      {"sse4.2", "avx2", NULL},
      {"sse4.2", "avx2", "avx512", NULL},
  };
  return lists[detect() + 1];
}
