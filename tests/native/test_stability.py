# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The stability table in short: every case with fewer rays, on every instruction set."""

from collections.abc import Callable, Iterator

import isa
import pytest
from stability_cases import CASES, run_whittle

RAYS = 20_000


@pytest.fixture(scope="module", params=isa.ISAS)
def run(request: pytest.FixtureRequest) -> Iterator[Callable]:
    """Calls functions in a process that uses one instruction set."""
    with isa.process(request.param) as call:
        yield call


@pytest.mark.parametrize("number", CASES)
def test_case_holds(run: Callable, number: str) -> None:
    result = run(run_whittle, number, RAYS)
    assert result.tried > 0
    assert result.failures == 0, f"{CASES[number].builds}: {result}"


@pytest.mark.parametrize("number", CASES)
def test_case_is_sharp(number: str) -> None:
    case = CASES[number]
    result = case.naive(RAYS)
    assert case.sharp(result), f"{case.culprit} passes too often: {result}"


def test_table_is_whole() -> None:
    wanted = [*range(1, 7), *range(8, 17), *range(18, 21), *range(27, 41)]
    assert [int(number) for number in CASES] == wanted
