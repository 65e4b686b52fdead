# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""See what rays cost, in the 3D viewport."""

from . import operators, overlay, panels, preset_menu, probe_operator, properties, source

PARTS = (properties, source, operators, probe_operator, preset_menu, panels, overlay)


def register() -> None:
    for part in PARTS:
        part.register()


def unregister() -> None:
    for part in reversed(PARTS):
        part.unregister()
