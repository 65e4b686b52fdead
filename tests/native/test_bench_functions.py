# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark's own functions: hits compared, rays in order, quantiles, rounds."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest
from bench_tools import Hits, Mesh, Stream


def hits_of(t: list[float]) -> tuple[Hits, list[np.ndarray]]:
    """Hits at these t, and the arrays that must outlive them."""
    times = np.array(t, np.float32)
    arrays = [times, np.where(np.isinf(times), -1, 7).astype(np.int32)]
    arrays += [np.zeros_like(times), np.zeros_like(times)]
    return Hits(*[a.ctypes.data for a in arrays], None), arrays


def test_mismatches_are_counted(functions: ctypes.CDLL) -> None:
    infinity = float("inf")
    ours = [1.0, 1.0, 1.0, infinity, infinity, 100.0, 100.0, float("nan")]
    theirs = [1.0, 1.00009, 1.00012, infinity, 5.0, infinity, 100.009, 1.0]
    first, keep = hits_of(ours)
    second, keep_too = hits_of(theirs)
    assert keep and keep_too
    stream = Stream(kind=b"primary", count=len(ours))
    arguments = [ctypes.byref(x) for x in (stream, first, second)]
    # 1.00012 is too far, two differ in whether they hit, and nan equals nothing.
    assert functions.compare_mismatches(*arguments) == 4
    assert functions.compare_count_hits(arguments[0], arguments[1]) == 6
    assert functions.compare_identical(*arguments) == 0
    assert functions.compare_identical(arguments[0], arguments[1], arguments[1]) == 1


def test_blocked_rays_are_compared(functions: ctypes.CDLL) -> None:
    ours, theirs = np.array([0, 1, 1, 0], np.uint8), np.array([0, 1, 0, 1], np.uint8)
    stream = Stream(kind=b"shadow", count=4, any_hit=1)
    hits = [Hits(None, None, None, None, a.ctypes.data) for a in (ours, theirs)]
    assert functions.compare_mismatches(*[ctypes.byref(x) for x in (stream, *hits)]) == 2


@pytest.mark.parametrize("size", [(64, 32), (40, 24), (37, 41)])
def test_neighbours_in_the_stream_are_neighbours_in_the_image(
    functions: ctypes.CDLL, size: tuple[int, int]
) -> None:
    width, height = size
    mesh = Mesh(camera=(0, 0, 0, 0, 0, -1, 0, 1, 0, 90))
    stream = functions.rays_primary(ctypes.byref(mesh), width, height)
    assert stream.count == width * height
    floats = ctypes.cast(stream.directions, ctypes.POINTER(ctypes.c_float))
    d = np.ctypeslib.as_array(floats, (3, stream.count)).astype(float)
    x = (d[0] / -d[2] * height / width + 1) * width / 2 - 0.5
    y = (d[1] / -d[2] + 1) * height / 2 - 0.5
    pixels = np.rint([x, y]).astype(int)
    assert np.abs(pixels - [x, y]).max() < 1e-3
    assert len(np.unique(pixels[0] + width * pixels[1])) == stream.count
    assert pixels.min() == 0 and (pixels.max(axis=1) == [width - 1, height - 1]).all()
    # Away from the border a block of rays is a block of pixels: 4 x 4, 16 x 16.
    for side in (4, 16):
        if width % side == 0 and height % side == 0:
            blocks = (pixels // side).reshape(2, -1, side * side)
            assert (blocks == blocks[:, :, :1]).all()


def test_quantiles_match_numpy(functions: ctypes.CDLL) -> None:
    generator = np.random.default_rng(5)
    for count in (1, 2, 5, 8):
        values = generator.random(count) + 1
        pointer = values.ctypes.data_as(ctypes.c_void_p)
        quarter, median, three = np.quantile(values, [0.25, 0.5, 0.75])
        found = functions.measure_quantile(pointer, ctypes.c_size_t(count), ctypes.c_double(0.25))
        assert found == pytest.approx(quarter, rel=1e-12)
        spread = functions.measure_spread(pointer, ctypes.c_size_t(count))
        assert spread == pytest.approx((three - quarter) / median, rel=1e-12)


def test_rounds_are_interleaved(functions: ctypes.CDLL) -> None:
    run_type = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_void_p)

    class Contender(ctypes.Structure):
        _fields_ = [("run", run_type), ("user", ctypes.c_void_p), ("seconds", ctypes.c_void_p)]

    log: list[int] = []
    durations = {1: 0.5, 2: 0.004}  # the second is repeated: three times fill 10 ms

    @run_type
    def run(user: int) -> float:
        log.append(user)
        return durations[user]

    seconds = np.zeros((2, 3))
    pair = (Contender * 2)(*[Contender(run, i + 1, seconds[i].ctypes.data) for i in range(2)])
    functions.measure_rounds(pair, ctypes.c_size_t(2), ctypes.c_size_t(3))
    second = [2, 2, 2]
    assert log == [1, 2, 1, *second, *second, 1, 1, *second]
    assert seconds == pytest.approx(np.array([[0.5] * 3, [0.004] * 3]))


def test_the_atrium_surrounds_the_camera(functions: ctypes.CDLL) -> None:
    mesh = functions.scenes_load(b"atrium", ctypes.c_float(1.6))
    floats = ctypes.cast(mesh.positions, ctypes.POINTER(ctypes.c_float))
    positions = np.ctypeslib.as_array(floats, (mesh.vertex_count, 3))
    eye = np.array(mesh.camera[:3])
    assert (positions.min(axis=0) < eye).all() and (eye < positions.max(axis=0)).all()
