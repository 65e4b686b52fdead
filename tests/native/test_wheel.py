# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The built file: what it asks of the system, what it shows, and that one serves all."""

import importlib.metadata
import re
import tomllib
from pathlib import Path

import pytest
import whittle_core
from elftools.elf.elffile import ELFFile

ROOT = Path(__file__).parents[2]
NAME = "cp311-abi3-manylinux_2_28_x86_64"


@pytest.fixture(scope="module")
def module():
    with open(whittle_core.__file__, "rb") as file:
        yield ELFFile(file)


def symbols(module: ELFFile, defined: bool) -> list[str]:
    found = module.get_section_by_name(".dynsym").iter_symbols()
    return [s.name for s in found if s.name and (s["st_shndx"] != "SHN_UNDEF") == defined]


def test_no_symbol_is_newer_than_glibc_2_28(module):
    needed = {
        version.name
        for _, versions in module.get_section_by_name(".gnu.version_r").iter_versions()
        for version in versions
    }
    assert "GLIBC_2.2.5" in needed
    glibc = [re.fullmatch(r"GLIBC_(\d+)\.(\d+)(?:\.\d+)?", name) for name in needed]
    assert all(glibc), f"versions of another library: {needed}"
    assert max(tuple(map(int, match.groups())) for match in glibc) <= (2, 28)


def test_only_the_init_function_is_exported(module):
    assert symbols(module, defined=True) == ["PyInit_whittle_core"]


def test_only_the_c_library_is_needed(module):
    tags = module.get_section_by_name(".dynamic").iter_tags()
    needed = {tag.needed for tag in tags if tag.entry.d_tag == "DT_NEEDED"}
    assert needed <= {"libc.so.6", "libm.so.6", "libpthread.so.0", "ld-linux-x86-64.so.2"}


def test_no_function_of_libm_decides_a_bit(module):
    exact = {"sqrt", "floor", "ldexp", "frexp", "fmax", "fmin"}
    exact |= {f"{name}f" for name in exact}
    libm = Path("/lib/x86_64-linux-gnu/libm.so.6")
    if not libm.is_file():
        pytest.skip("no libm where Debian has it, to read its names from")
    with libm.open("rb") as file:
        known = set(symbols(ELFFile(file), defined=True))
    assert set(symbols(module, defined=False)) & known <= exact


def test_the_wheel_serves_every_python_from_3_11_on():
    wheel = importlib.metadata.distribution("whittle_core").read_text("WHEEL")
    assert f"Tag: {NAME}\n" in wheel
    assert Path(whittle_core.__file__).name == "whittle_core.abi3.so"


def test_one_version_everywhere():
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    assert whittle_core.__version__ == importlib.metadata.version("whittle_core")
    assert manifest["version"] == whittle_core.__version__
    assert manifest["wheels"] == [f"./wheels/whittle_core-{whittle_core.__version__}-{NAME}.whl"]
