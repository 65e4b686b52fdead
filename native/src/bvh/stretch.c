/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Who makes shared boxes large: each node without one label's triangles, found in a single walk.
 *
 * A face of a box lies where the farthest triangle reaches. Going up the tree with the farthest
 * and, among the triangles of other labels, the next one for each face is enough to say what the
 * box would be if any one label had no triangles there. */

#include "bvh/measure.h"
#include "bvh/quality.h"

#include <math.h>

/* How far outwards on one side of a box; lower sides are negated, so that more is farther. */
typedef struct face {
  float far, next;
  uint32_t far_label, next_label; /* never the same but at first */
} face;

typedef struct reach {
  face faces[6]; /* -x, -y, -z, x, y, z */
  uint32_t owner;
} reach;

typedef struct walk {
  const whittle_judged *tree;
  const uint32_t *labels;
  uint32_t *owners;
  whittle_label_share *shares;
  double shared_area;
} walk;

static void offer(face *f, float value, uint32_t label) {
  if (label == f->far_label) {
    f->far = value > f->far ? value : f->far;
  } else if (value > f->far) {
    f->next = f->far;
    f->next_label = f->far_label;
    f->far = value;
    f->far_label = label;
  } else if (value > f->next) {
    f->next = value;
    f->next_label = label;
  }
}

static double half_area(const float out[6]) {
  const float lo[3] = {-out[0], -out[1], -out[2]};
  return whittle_half_area(lo, out + 3);
}

/* The area that a shared node would lose without the label. */
static double area_without(const reach *r, uint32_t label) {
  float out[6];
  for (int i = 0; i < 6; i++)
    out[i] = r->faces[i].far_label == label ? r->faces[i].next : r->faces[i].far;
  return half_area(out);
}

static void charge(walk *w, const reach *r, const whittle_node *node) {
  const double area = whittle_node_area(node);
  w->shared_area += area;
  for (int i = 0; i < 6; i++) {
    const uint32_t label = r->faces[i].far_label;
    int known = 0;
    for (int k = 0; k < i; k++)
      known |= r->faces[k].far_label == label;
    if (!known)
      w->shares[label].stretch += area - area_without(r, label);
  }
}

static reach reach_of_leaf(const walk *w, const whittle_node *node) {
  reach r = {.owner = w->labels[node->left_first]};
  for (int i = 0; i < 6; i++)
    r.faces[i] = (face){-INFINITY, -INFINITY, WHITTLE_SHARED, WHITTLE_SHARED};
  for (uint32_t t = node->left_first; t < node->left_first + node->count; t++) {
    const float *at = w->tree->vertices + 9 * (size_t)t;
    for (int i = 0; i < 9; i++) {
      offer(&r.faces[i % 3], -at[i], w->labels[t]);
      offer(&r.faces[3 + i % 3], at[i], w->labels[t]);
    }
    if (w->labels[t] != r.owner)
      r.owner = WHITTLE_SHARED;
  }
  return r;
}

static void join(reach *into, const reach *other) {
  for (int i = 0; i < 6; i++) {
    const face *f = &other->faces[i];
    offer(&into->faces[i], f->far, f->far_label);
    if (f->next_label != WHITTLE_SHARED)
      offer(&into->faces[i], f->next, f->next_label);
  }
  if (into->owner != other->owner)
    into->owner = WHITTLE_SHARED;
}

static void visit(walk *w, uint32_t index, reach *r) {
  const whittle_node *node = &w->tree->nodes[index];
  if (node->count) {
    *r = reach_of_leaf(w, node);
  } else {
    reach right;
    visit(w, node->left_first, r);
    visit(w, node->left_first + 1, &right);
    join(r, &right);
  }
  if (w->owners)
    w->owners[index] = r->owner;
  if (r->owner == WHITTLE_SHARED)
    charge(w, r, node);
  else
    w->shares[r->owner].nodes++;
}

void whittle_judge_labels(const whittle_judged *tree, const uint32_t *labels, uint32_t *owners,
                          whittle_label_share *shares, size_t label_count) {
  if (tree->node_count == 0)
    return;
  walk w = {.tree = tree, .labels = labels, .owners = owners, .shares = shares};
  reach root;
  visit(&w, 0, &root);
  for (size_t i = 0; w.shared_area > 0.0 && i < label_count; i++)
    shares[i].stretch /= w.shared_area;
}
