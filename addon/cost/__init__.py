# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Who pays for the rays: rows by object and material, their hints, files and budgets. No bpy."""

from .budgets import Budget, BudgetError, Verdict
from .collect import collect
from .hints import Hint
from .measured import Measured, Names
from .rows import KINDS, Row, make_rows

__all__ = [
    "KINDS",
    "Budget",
    "BudgetError",
    "Hint",
    "Measured",
    "Names",
    "Row",
    "Verdict",
    "collect",
    "make_rows",
]
