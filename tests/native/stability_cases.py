# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""All stability cases in order, for the short form of the tests and for the page of docs."""

import stability_boxes
import stability_builds
import stability_packets
import stability_triangles
from stability_tools import Case, Result

CASES: dict[str, Case] = {
    case.number: case
    for module in (stability_triangles, stability_boxes, stability_packets, stability_builds)
    for case in module.CASES
}
CASES = dict(sorted(CASES.items(), key=lambda item: int(item[0])))


def run_whittle(number: str, rays: int) -> Result:
    """One case in this process's instruction set: picklable, for isa.process."""
    return CASES[number].whittle(rays)
