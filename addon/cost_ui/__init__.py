# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Who pays for the rays, in Blender's window: table of cost, quality of the tree, Compare."""

from . import baseline, operators, panels, preset_menu, properties, table

PARTS = (properties, operators, baseline, preset_menu, panels, table)


def register() -> None:
    for part in PARTS:
        part.register()


def unregister() -> None:
    for part in reversed(PARTS):
        part.unregister()
