/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Whose triangles lie under each node: one owner's, or those of several. */

#pragma once

#include "whittle.h"

/* Fills owners[i] for every node of a tree from labels[i], the owner of each triangle in leaf
 * order: the label that all triangles under the node have, or `shared` where they differ. */
void whittle_owners(const whittle_node *nodes, size_t count, const uint32_t *labels,
                    uint32_t shared, uint32_t *owners);
