# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How the lecture's packets of rays went, as shares of what they did."""

from collections.abc import Mapping
from typing import Any


def shares(stats: Mapping[str, Any]) -> dict[str, Any] | None:
    """Of the statistics of a render, as Scene.render gives them; None: no packet was counted.

    coherence: of the rays of the packets that entered a node, how many entered it too;
    node_lane_use, triangle_lane_use: of the vector lanes that nodes and triangles were tested with,
    how many worked for a ray that the test was for (None: there was no test); decided: by which of
    the three tests nodes were decided; lanes: of a vector."""
    if not stats["packets"]:
        return None
    decided = {how: stats[f"decided_{how}"] for how in ("first", "frustum", "brute_force")}
    total = sum(decided.values())
    return {
        "packets": stats["packets"],
        "coherence": _share(stats["active_rays"], stats["visited_rays"]),
        "lanes": stats["lanes"],
        "node_lane_use": _share(stats["node_lanes_used"], stats["node_lanes"]),
        "triangle_lane_use": _share(stats["triangle_lanes_used"], stats["triangle_lanes"]),
        "decided": {how: _share(count, total) for how, count in decided.items()},
    }


def _share(part: int, whole: int) -> float | None:
    return part / whole if whole else None
