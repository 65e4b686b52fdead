/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Filling the error that the caller handed in. */

#include "base/error.h"

#include <stdarg.h>
#include <stdio.h>

whittle_status whittle_fail(whittle_error *error, whittle_status status, const char *argument,
                            const char *format, ...) {
  if (!error)
    return status;
  error->status = status;
  snprintf(error->argument, sizeof error->argument, "%s", argument ? argument : "");
  va_list values;
  va_start(values, format);
  vsnprintf(error->message, sizeof error->message, format, values);
  va_end(values);
  return status;
}

whittle_status whittle_out_of_memory(whittle_error *error, const char *what) {
  return whittle_fail(error, WHITTLE_OUT_OF_MEMORY, "", "Not enough memory for %s.", what);
}
