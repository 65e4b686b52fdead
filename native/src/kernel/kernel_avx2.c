/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The kernels for AVX2, eight lanes. */

#define WHITTLE_KERNEL whittle_kernel_avx2
#include "kernel/kernel.inl"
