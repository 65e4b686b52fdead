/* SPDX-FileCopyrightText: 2026 The Whittle Authors
 * SPDX-License-Identifier: GPL-3.0-or-later */
/* Instances: where a mesh stands, and what follows from its transform. */

#pragma once

#include "scene/scene.h"

/* Sets the transform, normal matrix and side; the rest of the instance stays. */
whittle_status whittle_instance_place(instance *place, const double transform[16],
                                      whittle_error *error);
