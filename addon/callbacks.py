# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Callbacks of properties that name a function instead of holding it.

Blender 4 never lets go of a property's callbacks. Through the globals of their module they would
keep Blender itself alive when Python ends. As a Python module, Blender 4.2 crashed at its end
because of them; that 4.5 sometimes waited there for ever is thought to have the same cause. What is
made here holds two strings, in a module that does not know Blender.
"""

from collections.abc import Callable
from importlib import import_module
from typing import Any


def late(module: str, name: str) -> Callable[[Any, Any], Any]:
    """For ``update``, ``set`` and ``items``, which take the owner and one thing more."""

    def call(owner: Any, other: Any) -> Any:
        return getattr(import_module(module), name)(owner, other)

    return call


def late_get(module: str, name: str) -> Callable[[Any], Any]:
    """For ``get``, which takes the owner."""

    def call(owner: Any) -> Any:
        return getattr(import_module(module), name)(owner)

    return call
