# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading Blender's multilayer EXR files as arrays."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO as oiio
from numpy.typing import NDArray

#: The order in which a pass's channels are given, whatever order the file stores.
CHANNELS = "RGBAXYZWV"


def read(path: Path | str) -> dict[str, NDArray[np.float32]]:
    """Every pass as float32 (h, w, c), row 0 at the bottom, by its name without the view layer.

    Blender 4 writes one part with all channels, Blender 5 a part for each pass; both name a channel
    ``Layer.Pass.C``. Raises OSError if the file cannot be read, ValueError if it has two layers.
    """
    planes: dict[str, dict[str, NDArray[np.float32]]] = {}
    layers: set[str] = set()
    for names, pixels in _parts(path):
        for index, name in enumerate(names):
            layer, found, rest = name.partition(".")
            if not found:
                continue
            pass_name, _, channel = rest.rpartition(".")
            layers.add(layer)
            planes.setdefault(pass_name, {})[channel] = pixels[::-1, :, index]
    if len(layers) > 1:
        raise ValueError(f"{path} has the view layers {sorted(layers)}; one is expected")
    return {name: _stack(channels) for name, channels in planes.items()}


def _stack(channels: dict[str, NDArray[np.float32]]) -> NDArray[np.float32]:
    order = sorted(channels, key=CHANNELS.find)
    return np.ascontiguousarray(np.stack([channels[key] for key in order], axis=-1))


def _parts(path: Path | str):
    file = oiio.ImageInput.open(str(path))
    if file is None:
        raise OSError(f"{path} cannot be read: {oiio.geterror()}")
    try:
        part = 0
        while file.seek_subimage(part, 0):
            names = list(file.spec().channelnames)
            yield names, file.read_image(part, 0, 0, len(names), "float32")
            part += 1
    finally:
        file.close()
