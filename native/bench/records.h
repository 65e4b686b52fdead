/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Records of the measurements: one JSON object a line on standard output. */

#ifndef BENCH_RECORDS_H
#define BENCH_RECORDS_H

#include <stddef.h>

void record_begin(void);
void record_text(const char *name, const char *value);
void record_count(const char *name, unsigned long long value);
void record_number(const char *name, double value); /* null if not finite */
void record_open(const char *name);                 /* an object inside, until record_close */
void record_close(void);
void record_end(void); /* ends the line and flushes it */

#endif
