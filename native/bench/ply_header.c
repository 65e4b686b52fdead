/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Reading the header of .ply files line by line. */

#include "ply_header.h"

#include "fail.h"
#include "file.h"

#include <stdio.h>
#include <string.h>

enum { LINE = 512 };

static ply_type type_named(const char *path, size_t line, const char *name) {
  static const char *const names[][2] = {
      {"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},   {"ushort", "uint16"},
      {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"}, {"double", "float64"}};
  for (int i = 0; i < 8; i++)
    if (strcmp(name, names[i][0]) == 0 || strcmp(name, names[i][1]) == 0)
      return (ply_type)i;
  fail("%s, line %zu: there is no type %s", path, line, name);
}

static ply_format format_named(const char *path, size_t line, const char *name) {
  static const char *const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
  for (int i = 0; i < 3; i++)
    if (strcmp(name, names[i]) == 0)
      return (ply_format)i;
  fail("%s, line %zu: there is no format %s", path, line, name);
}

static void add_element(ply_header *h, const char *path, size_t line, const char *text) {
  ply_element *e = h->elements + h->element_count;
  if (h->element_count == PLY_ELEMENTS)
    fail("%s, line %zu: more than %d elements", path, line, PLY_ELEMENTS);
  if (sscanf(text, "element %31s %zu", e->name, &e->count) != 2)
    fail("%s, line %zu: an element needs a name and a count", path, line);
  h->element_count++;
}

static void add_property(ply_header *h, const char *path, size_t line, const char *text) {
  ply_element *e = h->elements + h->element_count - 1;
  if (h->element_count == 0 || e->property_count == PLY_PROPERTIES)
    fail("%s, line %zu: a property without an element, or the %dth", path, line,
         PLY_PROPERTIES + 1);
  ply_property *p = e->properties + e->property_count++;
  char type[PLY_NAME], count[PLY_NAME];
  if (sscanf(text, "property list %31s %31s %31s", count, type, p->name) == 3) {
    p->is_list = 1;
    p->count_type = type_named(path, line, count);
    if (p->count_type >= PLY_FLOAT)
      fail("%s, line %zu: a list is counted in whole numbers, not in %s", path, line, count);
  } else if (sscanf(text, "property %31s %31s", type, p->name) != 2)
    fail("%s, line %zu: a property needs a type and a name", path, line);
  p->type = type_named(path, line, type);
}

static int begins_with(const char *text, const char *word) {
  return strncmp(text, word, strlen(word)) == 0;
}

static void read_line(ply_header *h, const char *path, size_t line, const char *text, mesh *m) {
  char format[PLY_NAME];
  if (sscanf(text, "format %31s", format) == 1)
    h->format = format_named(path, line, format);
  else if (begins_with(text, "element "))
    add_element(h, path, line, text);
  else if (begins_with(text, "property "))
    add_property(h, path, line, text);
  else if (begins_with(text, "comment "))
    file_comment(path, line, text + strlen("comment "), m);
  else if (!begins_with(text, "obj_info") && !begins_with(text, "comment"))
    fail("%s, line %zu: what is \"%s\"?", path, line, text);
}

void ply_read_header(ply_header *h, const char *path, const char *text, mesh *m) {
  memset(h, 0, sizeof(*h));
  char line[LINE];
  const char *p = text;
  for (size_t number = 1;; number++) {
    size_t length = strcspn(p, "\n");
    if (p[length] == '\0' || length >= LINE)
      fail("%s, line %zu: the header does not end", path, number);
    memcpy(line, p, length);
    line[length] = '\0';
    line[strcspn(line, "\r")] = '\0';
    p += length + 1;
    if (number == 1 && strcmp(line, "ply") != 0)
      fail("%s is not a .ply file: it does not begin with ply", path);
    if (strcmp(line, "end_header") == 0)
      break;
    if (number > 1)
      read_line(h, path, number, line, m);
  }
  h->bytes = (size_t)(p - text);
}

const ply_element *ply_find_element(const ply_header *h, const char *name) {
  for (size_t i = 0; i < h->element_count; i++)
    if (strcmp(h->elements[i].name, name) == 0)
      return h->elements + i;
  return NULL;
}
