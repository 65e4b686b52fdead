# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours from low to high: perceptual maps as 33 evenly spaced stops, straight between them."""

import numpy as np
from numpy.typing import NDArray

# sRGB, two hexadecimal digits a channel. The first three are matplotlib's, released as CC0; Turbo
# is Anton Mikhailov's, (c) 2019 Google LLC, released under Apache-2.0: sampled here at 33 places.
STOPS = {
    "VIRIDIS": (
        "440154470d6048186a482374472d7b4537814240863e49893b528b375b8d33638d2f6b8e2c728e297a8e"
        "26828e23898e21918c1f988b1fa08822a78528ae8032b67a3fbc734ec36b5ec96270cf5784d44b98d83e"
        "addc30c2df23d8e219ece51bfde725"
    ),
    "INFERNO": (
        "0000040403120b0724150b37210c4a2f0a5b3d09654a0c6b57106e64156e71196e7d1e6d8a226a972766"
        "a32c61b0315bbc3754c73e4cd24644db503be45a31eb6628f1731df68013f98e09fb9d07fcac11fbbc21"
        "f9cb35f5db4cf2ea69f3f68afcffa4"
    ),
    "CIVIDIS": (
        "00224e00285b002e6a0533711a386f273e6e32436d3b496c434e6c4b546c535a6d5a5f6e61656f686a71"
        "6f70737676767d7c788482798c8878938e789b9476a39a74aba072b4a76fbcae6cc4b468cdbb63d5c25e"
        "dec958e7d150f0d846f9e03afee838"
    ),
    "TURBO": (
        "30123b392a734040a24456c7466be34680f64294ff37a8fa28bceb1ccdd818ddc21fe9af32f2984ef97d"
        "6dfe628bff4ba4fc3cb9f635cdec34dfdf37eecf3af8be39fdac34fe962bfb7e21f46617eb500edf3f08"
        "d02f05be2102a91601920b017a0403"
    ),
    "GREY": "000000ffffff",
}

# Blue for less, grey for the same, red for more.
DIFFERENCE = {"DIFFERENCE": "0b3c8c2f6fc47fb0e6d9d9d9f0a07dcf4a2c8c1508"}

ITEMS = (
    ("VIRIDIS", "Viridis", "Dark blue to yellow, even to the eye"),
    ("TURBO", "Turbo", "Blue through green to red: strong contrasts, not even to the eye"),
    ("GREY", "Grey", "Black to white"),
    ("INFERNO", "Inferno", "Black through red to pale yellow, even to the eye"),
    ("CIVIDIS", "Cividis", "Blue to yellow, the same with most colour blindness"),
)
"""The maps for a property of Blender's: identifier, name, description."""


def apply(name: str, values: NDArray[np.floating]) -> NDArray[np.float32]:
    """Colours (..., 3), sRGB in [0, 1], of values; those outside [0, 1] take the end's colour."""
    colors = stops(name)
    position = np.clip(values, 0.0, 1.0) * (len(colors) - 1)
    low = np.minimum(position.astype(np.intp), len(colors) - 2)
    share = (position - low)[..., np.newaxis]
    return ((1.0 - share) * colors[low] + share * colors[low + 1]).astype(np.float32)


def stops(name: str) -> NDArray[np.float64]:
    """The colours (n, 3) between which a map goes straight, sRGB in [0, 1]."""
    return (
        np.frombuffer(bytes.fromhex((STOPS | DIFFERENCE)[name]), dtype=np.uint8).reshape(-1, 3)
        / 255
    )
