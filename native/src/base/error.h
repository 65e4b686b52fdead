/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* How every function of the core says what went wrong. */

#pragma once

#include "whittle.h"

/* Fills `error` (which may be NULL) with a printf-like sentence and returns `status`. */
whittle_status whittle_fail(whittle_error *error, whittle_status status, const char *argument,
                            const char *format, ...) __attribute__((format(printf, 4, 5)));

whittle_status whittle_out_of_memory(whittle_error *error, const char *what);
