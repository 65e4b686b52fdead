/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The kernels for AVX-512 (F, BW, DQ, VL), sixteen lanes. */

#define WHITTLE_KERNEL whittle_kernel_avx512
#include "kernel/kernel.inl"
