/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Whether two tracers found the same. */

#ifndef BENCH_COMPARE_H
#define BENCH_COMPARE_H

#include "rays.h"

/* Rays of the stream that hit. */
size_t compare_count_hits(const stream *s, const hits *h);

/* Rays that hit for one and miss for the other, or whose t differ by more than 1e-4 of it. */
size_t compare_mismatches(const stream *s, const hits *a, const hits *b);

/* Whether all results are the same bits. */
int compare_identical(const stream *s, const hits *a, const hits *b);

#endif
