/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* What the readers of mesh files share. */

#ifndef BENCH_FILE_H
#define BENCH_FILE_H

#include "mesh.h"

/* The whole file with a zero behind it. Free it. */
char *file_read(const char *path, size_t *bytes);

/* `count` finite numbers of a line of text, or the end of the program: `what` needs them. */
void file_numbers(const char *path, size_t line, const char *text, float *numbers, int count,
                  const char *what);

/* Two comments are understood, so that a file can bring its view: "camera: eye target up fov" (3 +
 * 3 + 3 + 1 numbers, vertical degrees) and "light: x y z"; others are nothing. */
void file_comment(const char *path, size_t line, const char *text, mesh *m);

#endif
