/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* From flattened instances to a tree that can be traced. */

#include "scene/grow.h"
#include "base/memory.h"

#include <string.h>

enum { GRAIN = 256 }; /* wide nodes */

uint64_t whittle_grow_units(uint64_t triangles) {
  return whittle_flat_units(triangles) + whittle_bvh_units(triangles);
}

whittle_status whittle_grow(whittle_team *team, flat_scene *flat,
                            const whittle_bvh_options *options, grown_tree *grown,
                            whittle_error *error) {
  memset(grown, 0, sizeof *grown);
  const whittle_status status = whittle_bvh_build(
      team, flat->fragments, flat->spare, (uint32_t)flat->count, options, &grown->bvh, error);
  if (status != WHITTLE_OK)
    return status;
  grown->triangle_count = (size_t)flat->count;
  return whittle_triangles_reserve(&grown->triangles, grown->triangle_count)
             ? WHITTLE_OK
             : whittle_out_of_memory(error, "the triangles of the tree");
}

static void place_leaves(void *context, uint64_t begin, uint64_t end) {
  grown_tree *grown = context;
  whittle_triangles_place(&grown->triangles, grown->wide + begin, (uint32_t)(end - begin));
}

whittle_status whittle_grow_wide(whittle_team *team, grown_tree *grown, whittle_error *error) {
  grown->wide =
      whittle_bvh_widen(team, grown->bvh.nodes, grown->bvh.node_count, &grown->wide_count, error);
  if (!grown->wide)
    return WHITTLE_OUT_OF_MEMORY;
  whittle_team_for(team, grown->wide_count, GRAIN, place_leaves, grown);
  return WHITTLE_OK;
}

void whittle_grown_free(grown_tree *grown) {
  whittle_release(grown->bvh.block);
  whittle_release(grown->wide);
  whittle_triangles_release(&grown->triangles);
  memset(grown, 0, sizeof *grown);
}
