/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* The benchmark's command line: Whittle and Embree, the same meshes, the same rays. */

#include "clock.h"
#include "contest.h"
#include "fail.h"
#include "records.h"
#include "scenes.h"
#include "whittle.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static unsigned parse_count(const char *option, const char *text, unsigned most) {
  char *end;
  unsigned long value = strtoul(text, &end, 10);
  if (*text == '\0' || *end != '\0' || value < 1 || value > most)
    fail("%s must be a number from 1 to %u, not %s", option, most, text);
  return (unsigned)value;
}

static void parse_size(settings *s, const char *text) {
  char rest;
  if (sscanf(text, "%ux%u%c", &s->width, &s->height, &rest) != 2 || s->width < 1 || s->height < 1 ||
      s->width > 16384 || s->height > 16384)
    fail("--size must be WIDTHxHEIGHT, each from 1 to 16384, not %s", text);
}

static void parse_kinds(settings *s, const char *text) {
  static const char *const known[] = {"build", "primary", "shadow", "mirror", "random"};
  for (const char *p = text, *next; p; p = next) {
    size_t length = strcspn(p, ",");
    int found = 0;
    for (int i = 0; i < 5; i++)
      found |= strlen(known[i]) == length && strncmp(p, known[i], length) == 0;
    if (!found)
      fail("--kinds is a list of build, primary, shadow, mirror, random, not %s", text);
    next = p[length] ? p + length + 1 : NULL;
  }
  s->kinds = text;
}

static void parse_builds(settings *s, const char *text) {
  if (strcmp(text, "one") != 0 && strcmp(text, "all") != 0)
    fail("--builds is one or all, not %s", text);
  s->one_build = strcmp(text, "one") == 0;
}

static void parse_option(settings *s, const char *option, const char *value) {
  if (!value)
    fail("%s needs a value", option);
  if (strcmp(option, "--embree") == 0)
    s->library = value;
  else if (strcmp(option, "--quality") == 0)
    s->quality = value;
  else if (strcmp(option, "--builds") == 0)
    parse_builds(s, value);
  else if (strcmp(option, "--isa") == 0)
    s->isa = value;
  else if (strcmp(option, "--kinds") == 0)
    parse_kinds(s, value);
  else if (strcmp(option, "--size") == 0)
    parse_size(s, value);
  else if (strcmp(option, "--rounds") == 0)
    s->rounds = parse_count(option, value, 1000);
  else if (strcmp(option, "--threads") == 0)
    s->threads = parse_count(option, value, 1024);
  else
    fail("there is no option %s", option);
}

int main(int argc, char **argv) {
  settings s = {.quality = "medium",
                .width = 1280,
                .height = 800,
                .rounds = 5,
                .threads = whittle_default_threads()};
  if (argc == 2 && strcmp(argv[1], "--clock") == 0) {
    record_begin();
    record_number("gigahertz", clock_gigahertz());
    record_end();
    return 0;
  }
  int i = 1;
  for (; i < argc && strncmp(argv[i], "--", 2) == 0; i += 2)
    parse_option(&s, argv[i], argv[i + 1]);
  if (i >= argc || !s.library)
    fail("usage: %s --embree LIBRARY [--quality Q] [--builds one|all] [--isa I] [--kinds K,...] "
         "[--size WxH] [--rounds N] [--threads N] SCENE...\nor: %s --clock\nwhere SCENE is one of "
         "%s",
         argv[0], argv[0], scenes_help);
  if (s.isa)
    setenv("WHITTLE_ISA", s.isa, 1);
  for (int first = i; i < argc; i++) {
    fprintf(stderr, "bench: scene %d of %d, %s\n", i - first + 1, argc - first, argv[i]);
    contest_run(&s, argv[i]);
  }
  return 0;
}
