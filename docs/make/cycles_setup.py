# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles set up to draw what Whittle draws: sharp light, sharp mirrors, no light between things."""

from __future__ import annotations

import bpy


def use(scene: bpy.types.Scene, samples: int, bounces: int) -> None:
    """Render with Cycles: point-sharp, mirror and glass paths only, a pixel's box as its filter.

    Everything that trades truth for less noise is off: clamping, light thresholds, blurred
    glossiness, adaptive sampling and denoising.
    """
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples, cycles.seed = samples, 0
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.diffuse_bounces = cycles.volume_bounces = 0
    cycles.max_bounces = cycles.glossy_bounces = cycles.transmission_bounces = bounces
    cycles.transparent_max_bounces = bounces
    cycles.caustics_reflective = cycles.caustics_refractive = False
    cycles.blur_glossy = cycles.light_sampling_threshold = 0.0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.pixel_filter_type = "BOX"


def pin_to_centres(scene: bpy.types.Scene, width: float = 0.01) -> None:
    """Let every sample pass within ``width`` pixels of its pixel's centre."""
    scene.cycles.pixel_filter_type = "BLACKMAN_HARRIS"
    scene.cycles.filter_width = width
