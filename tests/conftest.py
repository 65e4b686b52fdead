# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What every test stands on: the installed core, the same numbers each time, and hard limits."""

import faulthandler

import hypothesis

# A hang or a crash in native code shows every thread's stack instead of nothing.
faulthandler.enable()

# Examples follow from the code alone, and a loaded machine is no failure.
hypothesis.settings.register_profile("whittle", derandomize=True, deadline=None)
hypothesis.settings.load_profile("whittle")
