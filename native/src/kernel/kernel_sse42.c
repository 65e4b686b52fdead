/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The kernels for SSE4.2, four lanes: every x86-64 machine since 2008. */

#define WHITTLE_KERNEL whittle_kernel_sse42
#include "kernel/kernel.inl"
