# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a process of isa.py does first: choose, before anything imports whittle_core."""

import os
import sys


def prepare(isa: str, folder: str | None) -> None:
    """Asks for an instruction set and, with `folder`, for the whittle_core that lies there."""
    os.environ["WHITTLE_ISA"] = isa
    if folder:
        sys.path.insert(0, folder)


def loaded() -> tuple[str, str]:
    """The instruction set in use and the file of the module."""
    import whittle_core

    return whittle_core.isa(), whittle_core.__file__
