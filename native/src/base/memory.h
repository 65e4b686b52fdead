/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Aligned memory with checked sizes. */

#pragma once

#include <stddef.h>

/* `count` elements of `size` bytes, aligned to 64, or NULL if that overflows or is not to be had.
 * Asking for 0 elements gives a pointer that may be released. */
void *whittle_allocate(size_t count, size_t size);

void whittle_release(void *memory); /* NULL is fine */
