# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How large boxes look in a picture."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

CORNERS = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)], dtype=bool)


def covered(
    camera: dict[str, Any], low: NDArray[np.float64], high: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Pixels of the rectangle around each box in the picture, (n,).

    `camera`: as Scene.render takes it; `low`, `high`: corners (n, 3) of the boxes in world space.
    What hangs over the picture's edge counts, but a box outside the picture covers 0 pixels, and
    one that reaches behind the camera the whole picture.
    """
    size = np.array([camera["width"], camera["height"]], dtype=np.float64)
    corners = np.where(CORNERS, np.asarray(high)[:, None], np.asarray(low)[:, None])
    to_clip = np.asarray(camera["projection"]) @ np.linalg.inv(np.asarray(camera["to_world"]))
    clip = corners @ to_clip[:, :3].T + to_clip[:, 3]
    depth = clip[..., 3]
    with np.errstate(divide="ignore", invalid="ignore"):
        place = (clip[..., :2] / depth[..., None] + 1.0) / 2.0 * size
    near, far = place.min(axis=1), place.max(axis=1)
    seen = ((far > 0) & (near < size)).all(axis=1)
    area = np.where(seen, (far - near).prod(axis=1), 0.0)
    area = np.where((depth > 0).all(axis=1), area, size.prod())
    return np.where((depth > 0).any(axis=1), area, 0.0)
