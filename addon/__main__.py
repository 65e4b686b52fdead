# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""``python -m addon``: the command line where Blender is a Python module."""

import sys

from . import batch, register

register()
sys.exit(batch.main(sys.argv[1:]))
