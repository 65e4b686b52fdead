# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds and runs the benchmark against Embree, prints its tables and writes its records."""

from __future__ import annotations

import argparse
import importlib.util
import json
import math
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "bench"
DEMO = BUILD / "demo.obj"
BUNNY = ROOT.parent / "shared" / "scenes" / "stanford-bunny.obj"
RECORDS = BUILD / "records.json"

BUSY = 0.5  # a load before the run that is worth a word

Record = dict[str, Any]


def find_embree() -> Path:
    """The Embree 4 library that the embreex wheel carries. FileNotFoundError if there is none."""
    spec = importlib.util.find_spec("embreex")
    if spec is None or spec.origin is None:
        raise FileNotFoundError("Embree is missing: pip install embreex, or pass --embree LIBRARY")
    folder = Path(spec.origin).parent.parent / "embreex.libs"
    libraries = sorted(folder.glob("libembree4*.so*"))
    if not libraries:
        raise FileNotFoundError(f"{folder} holds no libembree4: pass --embree LIBRARY")
    return libraries[0]


def run_quietly(command: list[str]) -> None:
    """Run to the end; CalledProcessError, and all it printed, if it fails."""
    done = subprocess.run(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )
    if done.returncode != 0:
        sys.stderr.write(done.stdout)
        raise subprocess.CalledProcessError(done.returncode, command)


def build_program() -> Path:
    """Configure and build the benchmark program beside the core; gives its path."""
    places = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    cmake = shutil.which("cmake", path=places)
    if cmake is None:
        raise FileNotFoundError("CMake is missing: pip install cmake")
    BUILD.mkdir(parents=True, exist_ok=True)
    options = ["-DCMAKE_BUILD_TYPE=Release", "-DWHITTLE_BENCH=ON", "-DWHITTLE_PYTHON=OFF"]
    run_quietly([cmake, "-S", str(ROOT / "native"), "-B", str(BUILD), *options])
    run_quietly([cmake, "--build", str(BUILD), "--target", "whittle_bench", "--parallel"])
    return BUILD / "bench" / "whittle_bench"


def view_comments(view: dict[str, Any]) -> str:
    """An exported scene's camera and strongest light, as comments that the program reads."""
    matrix, projection = view["to_world"], view["projection"]
    eye = [row[3] for row in matrix[:3]]
    target = [row[3] - row[2] for row in matrix[:3]]
    up = [row[1] for row in matrix[:3]]
    fov = math.degrees(2 * math.atan(1 / projection[1][1]))
    lines = ["# camera: " + " ".join(f"{x:.9g}" for x in [*eye, *target, *up, fov])]
    if view["lights"]:
        light = max(view["lights"], key=lambda item: item["power"])
        lines.append("# light: " + " ".join(f"{x:.9g}" for x in light["position"]))
    return "\n".join(lines) + "\n"


def export_demo() -> Path:
    """Write the demo scene's triangles and its view into one .obj file. Needs bpy."""
    run_quietly([sys.executable, str(ROOT / "docs" / "make" / "export_obj.py"), str(DEMO)])
    with DEMO.open("a") as file:
        file.write(view_comments(json.loads(DEMO.with_suffix(".json").read_text())))
    return DEMO


def default_scenes() -> list[str]:
    """The demo scene, the bunny where it is there, and generated hills."""
    scenes = ["terrain:100000"]
    if BUNNY.is_file():
        scenes.insert(0, str(BUNNY))
    if importlib.util.find_spec("bpy") is None:
        print("No bpy here: the demo scene is left out, generated spheres stand in.", flush=True)
        return ["spheres", *scenes]
    print("Exporting the demo scene ...", flush=True)
    return [str(export_demo()), *scenes]


def processor_name() -> str:
    """The processor's model, as the system tells it."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else "unknown"


def measure(program: Path, arguments: list[str]) -> Iterator[Record]:
    """Run the program; each record as it comes. CalledProcessError if it fails in the end."""
    command = [str(program), *arguments]
    machine = {"processor": processor_name(), "load": round(os.getloadavg()[0], 2)}
    if machine["load"] > BUSY:
        print(f"Warning: the load is {machine['load']} before the run; figures suffer from it.")
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            yield json.loads(line) | machine
    if process.returncode != 0:
        raise subprocess.CalledProcessError(process.returncode, command)


HEADER = (
    "kind     threads  Whittle   Embree  mode         ratio  spread |  single  ratio |"
    " cycles a ray |   rays  mismatches"
)


def table_row(record: Record) -> str:
    """A record as a line of the table."""
    single = record.get("embree_modes", {}).get("1")
    cells = [
        f"{record['kind']:8}{record['threads']:8}{record['whittle']:9.2f}{record['embree']:9.2f}",
        f"  {record['embree_mode']:11}{record['ratio']:6.2f}{record['spread']:7.0%} |",
        f"{single:8.2f}{record['ratio_single']:7.2f} |" if single else f"{'|':>17}",
    ]
    if "whittle_cycles" in record:
        cells.append(f"{record['whittle_cycles']:6.0f}{record['embree_cycles']:7.0f} |")
    else:
        cells.append(f"{'|':>15}")
    if record["rays"]:
        cells.append(f"{record['rays']:8}{record['mismatches']:9}")
    return "".join(cells)


def print_records(records: Iterator[Record]) -> list[Record]:
    """Print each scene's table as its records come in; gives all of them."""
    seen: list[Record] = []
    for record in records:
        if not seen or seen[-1]["scene"] != record["scene"]:
            print(f"\n{record['scene']}: {record['triangles']} triangles, {record['isa']}")
            print("(Mrays/s; build: Mtriangles/s; medians of interleaved rounds)")
            print(HEADER)
        print(table_row(record), flush=True)
        seen.append(record)
    return seen


def parse_arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--scenes",
        nargs="+",
        metavar="SCENE",
        help="FILE.obj, spheres, terrain:N, slivers:N; with +ground behind: on a large square",
    )
    parser.add_argument("--json", type=Path, default=RECORDS, help="where the records go")
    parser.add_argument("--embree", type=Path, help="the Embree 4 library")
    parser.add_argument("--page", action="store_true", help="redraw docs/benchmarks.md")
    parser.add_argument("--quality", help="of Embree's build: low, medium, high, robust")
    parser.add_argument("--kinds", help="of records, with commas between; all unless told")
    parser.add_argument("--size", help="of the image: WIDTHxHEIGHT, 1280x800 unless told")
    parser.add_argument("--rounds", help="of each measurement, 7 unless told")
    parser.add_argument("--threads", help="of all, the processors at hand unless told")
    return parser.parse_args()


def run(arguments: argparse.Namespace) -> None:
    """Measure and write. Without scenes of the caller's the page in docs/ is redrawn too."""
    library = arguments.embree or find_embree()
    program = build_program()
    options = ["--embree", str(library)]
    for name in ("quality", "kinds", "size", "rounds", "threads"):
        if getattr(arguments, name):
            options += [f"--{name}", getattr(arguments, name)]
    scenes = arguments.scenes or default_scenes()
    records = print_records(measure(program, [*options, *scenes]))
    arguments.json.parent.mkdir(parents=True, exist_ok=True)
    arguments.json.write_text(json.dumps(records, indent=1) + "\n")
    print(f"\nRecords: {arguments.json}")
    if arguments.page or not arguments.scenes:
        page = ROOT / "docs" / "make" / "benchmarks.py"
        subprocess.run([sys.executable, str(page), str(arguments.json)], check=True)


def main() -> int:
    """Exit code 1 and a sentence on what cannot be measured."""
    try:
        run(parse_arguments())
    except (FileNotFoundError, subprocess.CalledProcessError) as error:
        print(f"bench: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
