/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Wall time, and how fast the processor runs. */

#ifndef BENCH_CLOCK_H
#define BENCH_CLOCK_H

double clock_seconds(void);

/* Cycles a second of this core now, in GHz, by timing additions of which each needs the last: one
 * a cycle on every x86-64 processor. Takes about 5 ms. */
double clock_gigahertz(void);

#endif
