# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The naive variants of naive.c and naive_build.c, compiled when first asked for."""

import ctypes
import functools
import hashlib
import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

WOOP, WOOP_FMA, MOLLER, MOLLER_DET, MOLLER_LOOSE, PLUECKER = range(6)
NO_BOX, UNPADDED, FUSED, FMIN_FMAX, COMPARE_SORT, ENTRY_IN_FRONT, FIRST_SIGNS, PADDED = range(8)

OUTCOME = ("largest_leaf", "depth", "nodes", "bad_bins", "bad_costs")


@functools.cache
def library() -> ctypes.CDLL:
    """Compiles into the temporary folder, under a name made of the sources' contents."""
    here = Path(__file__).parent
    sources = [here / "naive.c", here / "naive_build.c"]
    digest = hashlib.sha256(b"".join(s.read_bytes() for s in sources)).hexdigest()[:16]
    path = Path(tempfile.gettempdir()) / f"whittle-naive-{os.getuid()}-{digest}.so"
    if not path.exists():
        part = path.with_suffix(f".{os.getpid()}")
        flags = ["-std=c11", "-O2", "-ffp-contract=off", "-shared", "-fPIC"]
        subprocess.run(["cc", *flags, *map(str, sources), "-o", str(part), "-lm"], check=True)
        part.replace(path)
    loaded = ctypes.CDLL(str(path))
    for name in ("naive_box_losses", "naive_edge_asymmetry", "naive_frustum_culls", "naive_tiles"):
        getattr(loaded, name).restype = ctypes.c_int64
    return loaded


def _pointer(array: NDArray) -> ctypes.c_void_p:
    assert array.flags.c_contiguous
    return ctypes.c_void_p(array.ctypes.data)


def _floats(array: NDArray) -> NDArray[np.float32]:
    return np.ascontiguousarray(array, np.float32)


def trace(
    corners: NDArray,
    origins: NDArray,
    directions: NDArray,
    test: int,
    box: int = NO_BOX,
    *,
    group: int = 1,
    lowest: bool = True,
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Nearest t (inf: miss) and triangle (-1) of each ray, by brute force in plain float."""
    v, o, d = _floats(corners), _floats(origins), _floats(directions)
    t, found = np.empty(len(o), np.float32), np.empty(len(o), np.int32)
    short = library().naive_trace(
        test,
        box,
        group,
        int(lowest),
        _pointer(v),
        ctypes.c_int64(len(v)),
        _pointer(o),
        _pointer(d),
        ctypes.c_int64(len(o)),
        _pointer(t),
        _pointer(found),
    )
    if short:
        raise MemoryError("the naive tracer ran out of memory")
    return t, found


def pairs(
    corners: NDArray, origins: NDArray, directions: NDArray, test: int
) -> NDArray[np.float32]:
    """t of ray i and triangle i without any box; infinity where they miss."""
    v, o, d = _floats(corners), _floats(origins), _floats(directions)
    t = np.empty(len(v), np.float32)
    rows = ctypes.c_int64(len(v))
    library().naive_pairs(test, _pointer(v), _pointer(o), _pointer(d), rows, _pointer(t))
    return t


def tiles(width: int, height: int, tile: int) -> int:
    """Pixels that a tile loop without bounds writes outside the image's memory."""
    buffer = np.zeros((width + tile) * (height + tile) + tile, np.uint8)
    numbers = [ctypes.c_int64(n) for n in (width, height, tile)]
    return library().naive_tiles(*numbers, _pointer(buffer), ctypes.c_int64(len(buffer)))


def box_losses(corners: NDArray, origins: NDArray, directions: NDArray, test: int, box: int):
    """(hits lost by the box, hits) of triangle i and ray i, one pair a row."""
    v, o, d = _floats(corners), _floats(origins), _floats(directions)
    hits = ctypes.c_int64()
    rows = ctypes.c_int64(len(v))
    lost = library().naive_box_losses(
        test, box, _pointer(v), _pointer(o), _pointer(d), rows, ctypes.byref(hits)
    )
    return lost, hits.value


def edge_asymmetry(a: NDArray, b: NDArray, fused: bool) -> int:
    """Pairs of points (k, 2) whose edge functions are not each other's negation."""
    a, b = _floats(a), _floats(b)
    return library().naive_edge_asymmetry(
        int(fused), _pointer(a), _pointer(b), ctypes.c_int64(len(a))
    )


def frustum_culls(origin: NDArray, directions: NDArray, corner_rays: NDArray, boxes: NDArray):
    """(boxes culled although a ray of the packet hits them, boxes hit); boxes are (k, 6)."""
    o, d, b = _floats(origin), _floats(directions), _floats(boxes)
    corner = np.ascontiguousarray(corner_rays, np.int32)
    hit = ctypes.c_int64()
    culled = library().naive_frustum_culls(
        _pointer(o),
        _pointer(d),
        ctypes.c_int64(len(d)),
        _pointer(corner),
        _pointer(b),
        ctypes.c_int64(len(b)),
        ctypes.byref(hit),
    )
    return culled, hit.value


def build(corners: NDArray, midpoint: bool = False) -> dict[str, int]:
    """What the naive builder makes of the triangles, by the names of OUTCOME."""
    v = _floats(corners)
    out = (ctypes.c_int64 * len(OUTCOME))()
    if library().naive_build(_pointer(v), ctypes.c_int64(len(v)), int(midpoint), out):
        raise MemoryError("the naive builder ran out of memory")
    return dict(zip(OUTCOME, out, strict=True))
