/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Names and sizes of the passes. */

#include "whittle.h"

static const struct {
  const char *name;
  uint32_t channels;
} table[WHITTLE_PASS_COUNT] = {
    [WHITTLE_PASS_COMBINED] = {"combined", 4},
    [WHITTLE_PASS_DEPTH] = {"depth", 1},
    [WHITTLE_PASS_POSITION] = {"position", 3},
    [WHITTLE_PASS_NORMAL] = {"normal", 3},
    [WHITTLE_PASS_OBJECT_INDEX] = {"object_index", 1},
    [WHITTLE_PASS_NODES] = {"nodes", 1},
    [WHITTLE_PASS_NODES_PRIMARY] = {"nodes_primary", 1},
    [WHITTLE_PASS_NODES_SHADOW] = {"nodes_shadow", 1},
    [WHITTLE_PASS_NODES_REFLECTION] = {"nodes_reflection", 1},
    [WHITTLE_PASS_NODES_REFRACTION] = {"nodes_refraction", 1},
    [WHITTLE_PASS_TRIANGLES] = {"triangles", 1},
    [WHITTLE_PASS_TRIANGLES_PRIMARY] = {"triangles_primary", 1},
    [WHITTLE_PASS_TRIANGLES_SHADOW] = {"triangles_shadow", 1},
    [WHITTLE_PASS_TRIANGLES_REFLECTION] = {"triangles_reflection", 1},
    [WHITTLE_PASS_TRIANGLES_REFRACTION] = {"triangles_refraction", 1},
    [WHITTLE_PASS_LEAF_DEPTH] = {"leaf_depth", 1},
    [WHITTLE_PASS_COHERENCE] = {"coherence", 1},
    [WHITTLE_PASS_SECONDS] = {"seconds", 1},
};

const char *whittle_pass_name(whittle_pass pass) {
  return (uint32_t)pass < WHITTLE_PASS_COUNT ? table[pass].name : NULL;
}

uint32_t whittle_pass_channels(whittle_pass pass) {
  return (uint32_t)pass < WHITTLE_PASS_COUNT ? table[pass].channels : 0;
}
