# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The native module, imported when it is first needed."""

import importlib
import importlib.metadata
import importlib.util
from types import ModuleType

VERSION = "0.1.0"
MODULE = "whittle_core"


class NativeError(RuntimeError):
    """The native module cannot be used; the message names the file and the reason."""


_problem: str | None = None
_checked = False


def load() -> ModuleType:
    """The native module; NativeError if it cannot be loaded or is of another version."""
    global _problem, _checked
    _checked = True
    try:
        module = importlib.import_module(MODULE)
    except Exception as error:
        _problem = f"{_file()} could not be loaded: {type(error).__name__}: {error}"
        raise NativeError(_problem) from error
    if module.__version__ != VERSION:
        _problem = _mismatch(module.__version__)
        raise NativeError(_problem)
    _problem = None
    return module


def _mismatch(loaded: str) -> str:
    """Why a library of another version is loaded, and what to do."""
    try:
        installed = importlib.metadata.version(MODULE)
    except importlib.metadata.PackageNotFoundError:
        installed = None
    if installed == VERSION:
        return (
            f"Whittle was updated to {VERSION} while version {loaded} of its library was in use: "
            "the new library takes effect at the next start of Blender"
        )
    return f"{_file()} has version {loaded} and the add-on {VERSION}: restart Blender"


def problem() -> str | None:
    """Why the native module cannot be used, for the panels; tried once, then as load() left it."""
    if not _checked:
        try:
            load()
        except NativeError as error:
            return str(error)
    return _problem


def _file() -> str:
    """The file that the import finds; finding it runs none of its code."""
    spec = importlib.util.find_spec(MODULE)
    if spec is None or spec.origin is None:
        return f"Module {MODULE} (not installed: install the extension's zip again)"
    return spec.origin
