/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What a .ply file says of itself before its data. */

#ifndef BENCH_PLY_HEADER_H
#define BENCH_PLY_HEADER_H

#include "mesh.h"

typedef enum ply_format { PLY_ASCII, PLY_LITTLE, PLY_BIG } ply_format;

typedef enum ply_type {
  PLY_INT8,
  PLY_UINT8,
  PLY_INT16,
  PLY_UINT16,
  PLY_INT32,
  PLY_UINT32,
  PLY_FLOAT,
  PLY_DOUBLE,
} ply_type;

enum { PLY_NAME = 32, PLY_ELEMENTS = 16, PLY_PROPERTIES = 64 };

typedef struct ply_property {
  char name[PLY_NAME];
  int is_list;
  ply_type type, count_type; /* count_type: of lists */
} ply_property;

typedef struct ply_element {
  char name[PLY_NAME];
  size_t count, property_count;
  ply_property properties[PLY_PROPERTIES];
} ply_element;

typedef struct ply_header {
  ply_format format;
  size_t bytes; /* of the header; the data follows */
  size_t element_count;
  ply_element elements[PLY_ELEMENTS];
} ply_header;

/* Reads the header of a file's text; comments may bring the mesh's view (see file_comment). Fails
 * with the line's number on what it does not understand. */
void ply_read_header(ply_header *h, const char *path, const char *text, mesh *m);

/* The element of that name, or NULL. */
const ply_element *ply_find_element(const ply_header *h, const char *name);

#endif
