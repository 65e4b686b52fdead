# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the environment of the Python that runs it, with Blender and our wheel; prints its path.

Everything is done once: later runs find that nothing changed.
"""

from __future__ import annotations

import argparse
import contextlib
import fcntl
import hashlib
import os
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "build"
DIST = ROOT / "dist"
NATIVE = ROOT / "native"
RUNNING = f"{sys.version_info[0]}.{sys.version_info[1]}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--blender", help="a version of pyproject.toml's table, such as 4.2")
    blender = parser.parse_args().blender
    try:
        with locked():
            print(environment(blender))
    except EnvironmentFault as fault:
        print(f"whittle: {fault}", file=sys.stderr)
        return 1
    return 0


class EnvironmentFault(RuntimeError):
    """What stands in the way, and how to mend it."""


@contextlib.contextmanager
def locked() -> Iterator[None]:
    """Lets one run at a time change the environments."""
    BUILD.mkdir(exist_ok=True)
    with (BUILD / "environment.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def environment(wanted: str | None) -> Path:
    """The folder of the environment for this Python and that Blender, made if need be."""
    project = read_project()
    blenders = project["tool"]["whittle"]["blender"]
    version, package = choose_blender(blenders, wanted)
    folder = ROOT / venv_name(blenders, version)
    packages = [package, *project["dependency-groups"]["dev"]]
    install_packages(folder, version, packages)
    wheel, key = built_wheel(folder)
    install_wheel(folder, wheel, key)
    return folder


def read_project() -> dict:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def choose_blender(table: dict, wanted: str | None) -> tuple[str, str]:
    """Version and requirement of the Blender that was asked for or that goes with this Python."""
    fitting = [version for version, row in table.items() if row["python"] == RUNNING]
    version = wanted or "".join(fitting[:1])
    if version not in fitting:
        known = ", ".join(f"{version} for Python {row['python']}" for version, row in table.items())
        raise EnvironmentFault(f"Python {RUNNING} has no Blender {version} here; there is {known}")
    return version, table[version]["package"]


def venv_name(table: dict, version: str) -> str:
    first = next(v for v, row in table.items() if row["python"] == RUNNING)
    return ".venv-" + RUNNING + ("" if version == first else "-blender" + version)


# ---- Packages ------------------------------------------------------------------------------------


def install_packages(folder: Path, blender: str, packages: list[str]) -> None:
    key = digest([("packages", "\n".join([sys.base_prefix, *packages]).encode())])
    stamp = folder / "packages.key"
    if read_key(stamp) == key:
        return
    say(f"installing Blender {blender} for Python {RUNNING} into {folder.name}")
    shutil.rmtree(folder, ignore_errors=True)
    mend = f"no virtual environment: on Debian, apt-get install python{RUNNING}-venv"
    run([sys.executable, "-m", "venv", str(folder)], mend)
    mend = "the packages above could not be installed: is the package index within reach?"
    run(pip(folder, "install", *packages), mend)
    mend = (
        "Blender's module does not load: on Debian, apt-get install what .ci/environment.apt lists"
    )
    run([str(folder / "bin" / "python"), "-c", "import bpy"], mend)
    stamp.write_text(key)


# ---- The wheel -----------------------------------------------------------------------------------


def built_wheel(folder: Path) -> tuple[Path, str]:
    """The one wheel that every Python installs, rebuilt if anything in native/ changed."""
    key = digest((str(path.relative_to(NATIVE)), path.read_bytes()) for path in native_files())
    stamp = BUILD / "wheel.key"
    found = sorted(DIST.glob("whittle_core-*.whl"))
    if read_key(stamp) == key and len(found) == 1:
        return found[0], key
    fresh = build_wheel(folder)
    DIST.mkdir(exist_ok=True)
    for old in found:
        old.unlink()
    wheel = fresh.replace(DIST / fresh.name)
    stamp.write_text(key)
    return wheel, key


def build_wheel(folder: Path) -> Path:
    if not shutil.which(os.environ.get("CC", "cc")):
        raise EnvironmentFault(
            "no C compiler: install one (on Debian, apt-get install gcc libc6-dev) or name it in CC"
        )
    say("building the native module")
    fresh = BUILD / "wheel"
    shutil.rmtree(fresh, ignore_errors=True)
    options = ["--no-deps", "--no-build-isolation", "--wheel-dir", str(fresh)]
    options += ["-C", f"build-dir={BUILD / f'native-{RUNNING}'}"]
    if os.environ.get("CI"):
        options += ["-C", "cmake.define.WHITTLE_WERROR=ON"]
    run(pip(folder, "wheel", *options, str(NATIVE)), "the native module did not build")
    (wheel,) = fresh.glob("*.whl")
    return wheel


def native_files() -> list[Path]:
    """What the wheel is made of."""
    single = [NATIVE / name for name in ("CMakeLists.txt", "pyproject.toml", "README.md")]
    folders = [NATIVE / name for name in ("include", "src", "python")]
    found = (path for folder in folders for path in folder.rglob("*"))
    return sorted(single + [path for path in found if path.is_file()])


def install_wheel(folder: Path, wheel: Path, key: str) -> None:
    stamp = folder / "wheel.key"
    if read_key(stamp) == key:
        return
    command = pip(folder, "install", "--force-reinstall", "--no-deps", str(wheel))
    run(command, "the wheel could not be installed")
    stamp.write_text(key)


# ---- Small tools ---------------------------------------------------------------------------------


def digest(parts: Iterable[tuple[str, bytes]]) -> str:
    total = hashlib.sha256()
    for name, content in parts:
        total.update(f"{name} {len(content)}\n".encode() + content)
    return total.hexdigest()


def read_key(path: Path) -> str:
    return path.read_text() if path.is_file() else ""


def pip(folder: Path, command: str, *arguments: str) -> list[str]:
    python = str(folder / "bin" / "python")
    return [python, "-m", "pip", "--disable-pip-version-check", "--quiet", command, *arguments]


def say(text: str) -> None:
    print("whittle: " + text, file=sys.stderr, flush=True)


def run(command: list[str], fault: str) -> None:
    """Runs a command with its output on stderr, where it does not mix with our answer."""
    tools = str(Path(command[0]).parent)
    path = tools + os.pathsep + os.environ.get("PATH", os.defpath)
    variables = dict(os.environ, PATH=path, SOURCE_DATE_EPOCH="1767225600")
    if subprocess.run(command, stdout=sys.stderr, env=variables, check=False).returncode != 0:
        raise EnvironmentFault(fault)


if __name__ == "__main__":
    sys.exit(main())
