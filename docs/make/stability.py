# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""`make stability`: runs every stability case in full and writes docs/stability.md."""

import argparse
import platform
import sys
import time
from contextlib import ExitStack
from importlib.metadata import version
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "native"))

import agreement  # noqa: E402
import aim  # noqa: E402
import isa  # noqa: E402
import whittle_core  # noqa: E402
from differences import CLASSES, EDGE, EDGE_EMBREE  # noqa: E402
from stability_cases import CASES, run_whittle  # noqa: E402
from stability_tools import Case, Result  # noqa: E402

INTRODUCTION = """\
# Stability

Extreme cases, each against an answer that is known: most often that of the oracle, which tests
every triangle against every ray in double precision by another formula than the kernels', without
a tree.
A case counts what went wrong; where it holds that is 0. So that a case cannot pass by being blunt,
a naive variant in `tests/native/naive.c` or `naive_build.c` is put to it as well: it must fail at
least 1,000 times a million, or, where no rate exists, show the fault that is named.

Made by `make stability` on {machine}, Python {python}, embreex {embreex}, in {seconds:.0f} s. The
short form of the same cases is part of `make test`.

"""

CLOSING = """\

- Rays: what each instruction set was tried with. Embree is asked through embreex, single rays, by
  default and with its robust flag; a dash stands where the question cannot be put to it. It
  promises no watertightness without that flag, so its column shows how hard a case is, not a fault.
- Differences from the oracle count as failures unless they are explained: the ray passes within
  {edge:.0f} roundings (2^-24 of the farthest vertex' distance) of an edge that one of the two sees
  on its other side, or t lies within the bound that those roundings allow at that angle
  (`tests/native/differences.py`).
- Naive: failures per million, or the fault where there is no rate.

## Agreement with the oracle

Whittle ({isa}) and Embree (single rays, default) against the oracle on the same rays from outside
and inside closed meshes, every difference by its class: *grazing t*, the same triangle with t off
by more than 16 roundings but within its bound; *tie*, another triangle at the same t within the
bounds, as at shared edges; *silhouette*, a hit that one of them sees and the other misses, within
{edge:.0f} roundings of an edge for Whittle and {embree:.0f} for Embree; the rest is unexplained.

"""


def show(result: Result) -> str:
    return f"{result.failures:,}" if result.failures else "0"


def naive_cell(case: Case, result: Result) -> str:
    seen = f"{result.per_million:,.0f} / M" if case.rate else result.note
    return f"{case.culprit}: {seen}"


def embree_cell(case: Case, rays: int) -> str:
    if case.embree is None:
        return "-"
    found = [case.embree(rays, robust) for robust in (False, True)]
    return " / ".join(f"{round(f.per_million):,}" for f in found)


def run_case(case: Case, rays: int, runs: dict) -> tuple[list[str], bool]:
    """The cells of one row, and whether all is as it must be."""
    results = [run(run_whittle, case.number, rays) for run in runs.values()]
    naive = case.naive(rays)
    good = case.sharp(naive) and all(r.failures == 0 and r.tried > 0 for r in results)
    note = f" ({results[-1].note})" if results[-1].note else ""
    cells = [case.number, case.builds, case.holds + note, f"{results[-1].tried:,}"]
    cells += [show(r) for r in results]
    return [*cells, embree_cell(case, rays), naive_cell(case, naive)], good


def run_cases(cases: list[Case], rays: int, runs: dict) -> tuple[list[list[str]], list[str]]:
    """All rows, and the numbers of the cases that fail."""
    rows, bad = [], []
    for case in cases:
        began = time.monotonic()
        cells, good = run_case(case, rays, runs)
        rows.append(cells)
        bad += [] if good else [case.number]
        word = "ok  " if good else "BAD "
        print(f"{word} {time.monotonic() - began:6.1f} s  {' | '.join(cells)}", flush=True)
    return rows, bad


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rays", type=int, default=1_000_000, help="rays of each case")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "stability.md")
    parser.add_argument("cases", nargs="*", help="numbers of cases; all if none is given")
    options = parser.parse_args()
    unknown = set(options.cases) - set(CASES)
    if unknown:
        parser.error(f"there is no case {', '.join(sorted(unknown))}; there are {', '.join(CASES)}")

    start = time.monotonic()
    with ExitStack() as stack:
        runs = {name: stack.enter_context(isa.process(name)) for name in isa.ISAS}
        chosen = [case for case in CASES.values() if case.number in (options.cases or CASES)]
        rows, bad = run_cases(chosen, options.rays, runs)
    heads = ["case", "what it builds", "what must hold", "rays"]
    heads += [f"Whittle {name}: failures" for name in isa.ISAS]
    heads += ["Embree default / robust: failures per million", "naive"]
    if options.cases:
        print("Some cases only: the page stays as it is.")
        return finish(bad)
    table = markdown([heads, ["---"] * len(heads), *rows])
    others, unexplained = agreement_table(options.rays)
    bad += ["agreement"] if unexplained else []
    text = INTRODUCTION.format(
        machine=f"{processor()} ({platform.system()})",
        python=platform.python_version(),
        embreex=version("embreex"),
        seconds=time.monotonic() - start,
    )
    closing = CLOSING.format(edge=EDGE, embree=EDGE_EMBREE, isa=whittle_core.isa())
    options.out.write_text(text + "\n".join(table) + "\n" + closing + "\n".join(others) + "\n")
    print(f"Wrote {options.out}")
    return finish(bad)


def finish(bad: list[str]) -> int:
    """Says what failed; the exit code."""
    if bad:
        print(f"These do not hold or are not sharp: {', '.join(bad)}", file=sys.stderr)
    return 1 if bad else 0


def agreement_table(rays: int) -> tuple[list[str], int]:
    """Lines of the second table, and how many differences it leaves unexplained."""
    heads = ["mesh", "rays at", "tracer", "rays", *(name.replace("_", " ") for name in CLASSES)]
    rows, unexplained = [], 0
    for name, make in agreement.SMALL.items():
        for kind in aim.KINDS:
            for tracer, counts in agreement.against_oracle(make(), kind, rays).items():
                unexplained += counts["unexplained"]
                cells = [name, kind, tracer, f"{rays:,}", *(f"{counts[c]:,}" for c in CLASSES)]
                rows.append(cells)
                print(" | ".join(cells), flush=True)
    return markdown([heads, ["---"] * len(heads), *rows]), unexplained


def markdown(rows: list[list[str]]) -> list[str]:
    return ["| " + " | ".join(row) + " |" for row in rows]


def processor() -> str:
    """The CPU's name."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


if __name__ == "__main__":
    sys.exit(main())
