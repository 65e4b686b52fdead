/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Included before every source: binds to the symbols of glibc 2.28, whichever newer glibc builds.
 *
 * glibc 2.34 moved the thread functions into libc.so.6 under new versions and kept the old ones;
 * naming those lets one binary run on both. The module still asks for libpthread.so.0, which holds
 * them before 2.34 and is an empty shell since. */

#pragma once

#include <features.h>

#if defined(__GLIBC__) && defined(__x86_64__)
#define WHITTLE_BIND(name, version) __asm__(".symver " #name ", " #name "@GLIBC_" #version)
WHITTLE_BIND(pthread_create, 2.2.5);
WHITTLE_BIND(pthread_join, 2.2.5);
WHITTLE_BIND(pthread_detach, 2.2.5);
WHITTLE_BIND(pthread_once, 2.2.5);
WHITTLE_BIND(pthread_mutex_trylock, 2.2.5);
WHITTLE_BIND(pthread_attr_setstacksize, 2.2.5);
WHITTLE_BIND(pthread_condattr_setclock, 2.3.3);
WHITTLE_BIND(pthread_getaffinity_np, 2.3.4);
WHITTLE_BIND(sem_init, 2.2.5);
WHITTLE_BIND(sem_post, 2.2.5);
WHITTLE_BIND(sem_wait, 2.2.5);
WHITTLE_BIND(sem_destroy, 2.2.5);
#undef WHITTLE_BIND
/* Since 2.38 strtol and sscanf would become other functions. */
#undef __GLIBC_USE_C2X_STRTOL
#undef __GLIBC_USE_C23_STRTOL
#define __GLIBC_USE_C2X_STRTOL 0
#define __GLIBC_USE_C23_STRTOL 0
#endif
