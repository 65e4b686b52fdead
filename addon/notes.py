# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a render did otherwise than asked, each said once."""

from collections.abc import Iterable

LONGEST_LIST = 12


class Notes:
    """Lines for the person who renders, in the order in which they came up."""

    def __init__(self) -> None:
        self._lines: dict[str, None] = {}

    def add(self, line: str) -> None:
        """Keeps a sentence, unless it was said before."""
        self._lines.setdefault(line)

    def lines(self) -> list[str]:
        return list(self._lines)


def listed(names: Iterable[str]) -> str:
    """Names joined by commas, the first dozen and how many more."""
    unique = list(dict.fromkeys(names))
    shown = ", ".join(unique[:LONGEST_LIST])
    more = len(unique) - LONGEST_LIST
    return f"{shown} and {more} more" if more > 0 else shown


def plural(count: int, noun: str) -> str:
    """The count with its noun: 1 mesh, 2 objects."""
    if count == 1:
        return f"1 {noun}"
    return f"{count:,} {noun}es" if noun.endswith("sh") else f"{count:,} {noun}s"
