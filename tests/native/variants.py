# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the module with one safeguard of the exact test taken out, to show that tests notice."""

import os
import subprocess
import sysconfig
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

NATIVE = Path(__file__).parents[2] / "native"
FLAGS = ("-std=c11", "-O1", "-fPIC", "-ffp-contract=off", "-fno-math-errno", "-D_GNU_SOURCE", "-w")
KERNEL_FLAGS = {
    "kernel_sse42": ("-msse4.2", "-mpopcnt"),
    "kernel_avx2": ("-mavx2", "-mfma", "-mbmi", "-mbmi2", "-mlzcnt", "-mpopcnt"),
}
SKIPPED = "kernel_avx512"  #: takes long to compile; the variants run on AVX2 or SSE4.2


def compile_to(folder: Path, source: Path, *more: str) -> Path:
    """The object file of one source of the core or the module."""
    target = folder / f"{source.parent.name}_{source.stem}.o"
    places = [NATIVE / "include", NATIVE / "src", Path(sysconfig.get_path("include"))]
    include = [f"-I{place}" for place in places]
    flags = [*FLAGS, *KERNEL_FLAGS.get(source.stem, ()), *more]
    subprocess.run(["cc", *flags, *include, "-c", str(source), "-o", str(target)], check=True)
    return target


def without(switches: list[str], folder: Path) -> dict[str, Path]:
    """A folder with a whittle_core for each of the switches, such as WHITTLE_BREAK_TIE; "" is
    the module as it is."""
    sources = [s for s in [*NATIVE.glob("src/*/*.c"), *NATIVE.glob("python/*.c")]]
    sources = [s for s in sources if s.stem != SKIPPED]
    stand_in = folder / "no_avx512.c"
    stand_in.write_text(
        '#include "kernel/kernel.h"\nconst kernel_table whittle_kernel_avx512 = {0};\n'
    )
    kernels = [s for s in sources if s.stem in KERNEL_FLAGS]
    shared = [s for s in sources if s not in kernels] + [stand_in]
    made = {}
    for switch in switches:
        made[switch] = folder / (switch.lower() or "as_it_is")
        made[switch].mkdir()
    jobs = [(folder, s, "-DPy_LIMITED_API=0x030B0000") for s in shared]
    jobs += [(made[w], s, *([f"-D{w}"] if w else [])) for w in switches for s in kernels]
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        objects = list(pool.map(lambda job: compile_to(*job), jobs))
    common = objects[: len(shared)]
    for place in made.values():
        own = [o for o in objects if o.parent == place]
        target = place / "whittle_core.abi3.so"
        link = ["cc", "-shared", *map(str, common + own), "-o", str(target), "-lm", "-lpthread"]
        subprocess.run(link, check=True)
    return made
