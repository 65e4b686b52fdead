# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads pictures: multilayer EXR files of old and new Blenders, and any other format."""

from pathlib import Path

import numpy as np
import OpenImageIO as oiio


def read(path: Path) -> dict[str, np.ndarray]:
    """Channels by their full name, in a multilayer EXR "Layer.Pass.Channel", as (h, w) with row 0
    at the bottom."""
    file = oiio.ImageInput.open(str(path))
    assert file is not None, oiio.geterror()
    channels = {}
    part = 0
    while file.seek_subimage(part, 0):
        spec = file.spec()
        pixels = file.read_image(part, 0, 0, spec.nchannels, oiio.FLOAT)
        pixels = np.asarray(pixels).reshape(spec.height, spec.width, spec.nchannels)
        for index, name in enumerate(spec.channelnames):
            channels[name] = pixels[::-1, :, index]
        part += 1
    file.close()
    return channels


def same(first: Path, second: Path) -> bool:
    """Whether two files hold the same pixels; their metadata tells times and never agrees."""
    one, other = read(first), read(second)
    return one.keys() == other.keys() and all(np.array_equal(one[c], other[c]) for c in one)


def layer(path: Path, name: str = "ViewLayer") -> dict[str, np.ndarray]:
    """Passes of a view layer, as (h, w) or (h, w, channels) in the order RGBA or XYZ."""
    found: dict[str, dict[str, np.ndarray]] = {}
    for channel, pixels in read(path).items():
        parts = channel.split(".")
        if parts[0] == name:
            found.setdefault(".".join(parts[1:-1]), {})[parts[-1]] = pixels
    order = "RGBAXYZV"
    passes = {}
    for key, channels in found.items():
        stack = np.stack([channels[c] for c in sorted(channels, key=order.index)], axis=-1)
        passes[key] = stack[..., 0] if stack.shape[-1] == 1 else stack
    return passes
