# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of the viewport's overlays share: a built scene, views, heatmaps, probes."""

import time

import bpy

SIZE = (96, 64)
KINDS = ("primary", "shadow", "reflection", "refraction")


def ready(shared):
    """Reads and builds what the viewport shows."""
    shared.read(bpy.context.evaluated_depsgraph_get())
    end = time.monotonic() + 60
    while shared.building and not shared.poll():
        assert time.monotonic() < end
        time.sleep(0.002)
    assert not shared.error and shared.scene is not None


def look(scene, size=SIZE, **changes):
    """The view of the scene's camera."""
    from addon.inspect.view import View

    camera = scene.camera
    for name, value in changes.items():
        setattr(camera.data, name, value)
    bpy.context.view_layer.update()
    window = camera.calc_matrix_camera(bpy.context.evaluated_depsgraph_get(), x=size[0], y=size[1])
    view = camera.matrix_world.normalized().inverted()
    flat = [tuple(value for row in matrix for value in row) for matrix in (view, window)]
    return View(*flat, size, (camera.data.clip_start, camera.data.clip_end))


def wanted(scene, shared, view, **choice):
    from addon.inspect import properties
    from addon.inspect.heat import Want
    from addon.inspect.metrics import Choice

    settings = tuple(sorted(properties.core_settings(scene).items()))
    return Want(view, Choice(**choice), settings, shared.generation)


def probed(scene, shared, pixel=(48, 32), size=SIZE):
    from addon.inspect import probe, properties

    return probe.take(shared, look(scene, size).camera(), properties.core_settings(scene), pixel)


def finish(heat, shared, seconds=60):
    """Steps until nothing is left to do; the divisors of the pictures on the way."""
    divisors, end = [], time.monotonic() + seconds
    while heat.busy:
        assert time.monotonic() < end
        if heat.step(shared.scene):
            assert not heat.error, heat.error
            divisors.append(heat.picture.divisor)
        time.sleep(0.002)
    return divisors
