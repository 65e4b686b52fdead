/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Everything that is compiled once for each instruction set; define WHITTLE_KERNEL as its table. */

#define _POSIX_C_SOURCE 200809L

#include "base/clock.h"
#include "kernel/box.h"
#include "kernel/frustum.h"
#include "kernel/hash.h"
#include "kernel/order.h"
#include "kernel/simd_bytes.h"
#include "kernel/tile.h"
#include "kernel/vector.h"

#include <stddef.h>

#include "kernel/chunk.inl"

#include "kernel/trace.inl"

#include "kernel/surface.inl"

#include "kernel/shade.inl"

#include "kernel/measure.inl"

#include "kernel/tile.inl"

const kernel_table WHITTLE_KERNEL = {
    .lanes = V_LANES,
    .load = kernel_load,
    .give = kernel_give,
    .give_blocked = kernel_give_blocked,
    .closest = kernel_closest,
    .any = kernel_any,
    .render_tile = kernel_render_tile,
};
