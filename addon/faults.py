# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What went wrong, in words for the person who renders."""

import traceback

from . import native


class RenderError(RuntimeError):
    """Something that the engine cannot render; the message says what to change."""


def explained(error: BaseException) -> str:
    """A sentence for an error; one that nobody foresaw is printed with its place too."""
    text = str(error) or type(error).__name__
    if isinstance(error, MemoryError):
        return f"Out of memory: {text}"
    if not isinstance(error, native.NativeError | RenderError | ValueError):
        traceback.print_exception(error)
    return text
