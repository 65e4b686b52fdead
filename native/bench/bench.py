# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds and runs the benchmark against Embree, prints its tables and writes its records."""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "bench"
MAKE = ROOT / "docs" / "make"
SHARED = ROOT.parent / "shared" / "scenes"
FILES = ("stanford-bunny.obj", "ogre.obj")
RECORDS = BUILD / "records.json"

sys.path.insert(0, str(MAKE))
import bench_summary  # noqa: E402

PARTS = ("scenes", "growth", "frame")
GROWTH = [f"terrain:{count}" for count in (10**4, 32000, 10**5, 320000, 10**6, 3200000, 10**7)]
GROWTH_OPTIONS = ["--kinds", "build,primary", "--builds", "one", "--rounds", "3"]

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


def export(scene: Path | None, path: Path) -> Path:
    """Write a .blend file's triangles and view, or the demo's, into one .ply file. Needs bpy."""
    command = [sys.executable, str(MAKE / "export_ply.py"), str(path)]
    run_quietly([*command, "--scene", str(scene)] if scene else command)
    return path


def has_blender() -> bool:
    """Whether this Python has Blender."""
    return importlib.util.find_spec("bpy") is not None


def default_scenes() -> list[str]:
    """The demo scene, the meshes at hand, and generated scenes of many kinds."""
    scenes = [str(path) for path in (SHARED / name for name in FILES) if path.is_file()]
    scenes += ["stadium", "stadium-near", "atrium", "terrain:10000", "terrain:100000"]
    scenes += ["terrain:1000000", "slivers:20000+ground"]
    if not has_blender():
        print("No bpy here: the demo scene is left out, generated spheres stand in.", flush=True)
        return ["spheres", *scenes]
    print("Exporting the demo scene ...", flush=True)
    return [str(export(None, BUILD / "demo.ply")), *scenes]


def as_meshes(scenes: list[str], folder: Path) -> list[str]:
    """The scenes, those in .blend files exported into the folder under their own names."""
    meshes = []
    for scene in scenes:
        name, plus, ground = scene.partition("+ground")
        if not name.endswith(".blend"):
            meshes.append(scene)
            continue
        if not has_blender():
            raise FileNotFoundError(f"{name} needs bpy, which this Python has not")
        print(f"Exporting {name} ...", flush=True)
        ply = export(Path(name), folder / f"{Path(name).stem}.ply")
        meshes.append(f"{ply}{plus}{ground}")
    return meshes


def processor_name() -> str:
    """The processor's model, as the system tells it."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else "unknown"


def caches() -> dict[str, int]:
    """Bytes of the caches of data that a core sees, by level ("L2"); {} where none are told."""
    found = {}
    for folder in sorted(Path("/sys/devices/system/cpu/cpu0/cache").glob("index*")):
        if (folder / "type").read_text().strip() == "Instruction":
            continue
        size = (folder / "size").read_text().strip()
        unit = {"K": 2**10, "M": 2**20}[size[-1]]
        found["L" + (folder / "level").read_text().strip()] = int(size[:-1]) * unit
    return found


def machine() -> dict[str, Any]:
    """The processor and how busy it is with other work; a word if that spoils the figures."""
    load = round(os.getloadavg()[0], 2)
    if load > BUSY:
        print(f"Warning: the load is {load} before the run; figures suffer from it.", flush=True)
    return {"processor": processor_name(), "load": load, "caches": caches()}


def measure(program: Path, arguments: list[str]) -> Iterator[Record]:
    """Run the program; each record as it comes. CalledProcessError if it fails in the end."""
    command = [str(program), *arguments]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            yield json.loads(line)
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


def print_summary(records: list[Record]) -> None:
    """Ratios over all scenes."""
    print("\nWhittle over Embree's best mode, over all scenes:")
    print("kind     threads  scenes  geometric mean   least   most")
    for row in bench_summary.summary(records):
        print(
            f"{row.kind:8}{row.threads:8}{row.scenes:8}{row.mean:16.2f}{row.least:8.2f}"
            f"{row.most:7.2f}  least in {row.where}"
        )


def print_frame(found: dict[str, Any]) -> None:
    """Whole frames and the reading of a large mesh."""
    for frame in found["frames"]:
        ours, theirs = (bench_summary.medians(frame["seconds"][e]) for e in ("whittle", "cycles"))
        print(f"\n{found['scene']}, {frame['samples']} samples a pixel, s: Whittle, Cycles, ratio")
        for phase in ("trace", "total"):
            ratio = theirs[phase] / ours[phase]
            print(f"{phase:8}{ours[phase]:9.3f}{theirs[phase]:9.3f}{ratio:7.2f}")
        print(f"{bench_summary.cycles_a_ray(frame, 'trace'):.0f} core cycles a ray while tracing")
        gain = bench_summary.thread_gain(frame)
        print(f"{frame['threads']} threads trace {gain:.2f} times as fast as one")
    for row in found["reading"]:
        read = bench_summary.medians(row["seconds"])
        ratio = read["whittle"] / read["cycles"]
        print(f"reading {row['triangles']} triangles, {row['corners']} corners a face:", end=" ")
        print(f"{read['whittle']:.3f} s, Cycles {read['cycles']:.3f} s, {ratio:.2f} of its time")


def parse_arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--scenes",
        nargs="+",
        metavar="SCENE",
        help="FILE.obj, .ply or .blend, stadium, stadium-near, atrium, spheres, terrain:N, "
        "slivers:N; with +ground behind: on a large square",
    )
    parser.add_argument(
        "--parts",
        type=lambda text: text.split(","),
        help="scenes, growth, frame, with commas between; all unless told or given scenes",
    )
    parser.add_argument("--json", type=Path, default=RECORDS, help="where the records go")
    parser.add_argument("--embree", type=Path, help="the Embree 4 library")
    parser.add_argument("--page", action="store_true", help="redraw docs/benchmarks.md")
    parser.add_argument("--quality", help="of Embree's build: low, medium, high, robust")
    parser.add_argument("--builds", help="of Embree's that are traced: one, or all")
    parser.add_argument("--isa", help="that both are restricted to: sse4.2, avx2, avx512")
    parser.add_argument("--kinds", help="of records, with commas between; all unless told")
    parser.add_argument("--size", help="of the image: WIDTHxHEIGHT, 1280x800 unless told")
    parser.add_argument("--rounds", help="of each measurement, 5 unless told")
    parser.add_argument("--threads", help="of all, the processors at hand unless told")
    arguments = parser.parse_args()
    if arguments.parts is None:
        arguments.parts = ["scenes"] if arguments.scenes else list(PARTS)
    for part in arguments.parts:
        if part not in PARTS:
            parser.error(f"--parts is a list of {', '.join(PARTS)}, not {part}")
    return arguments


def measure_frame(program: Path, isa: str | None) -> dict[str, Any]:
    """Whole frames against Cycles. Needs bpy."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "frame.json"
        command = [sys.executable, str(MAKE / "frame.py"), str(path), "--program", str(program)]
        environment = os.environ | ({"WHITTLE_ISA": isa} if isa else {})
        subprocess.run(command, stdout=subprocess.DEVNULL, check=True, env=environment)
        return json.loads(path.read_text())


def run_parts(arguments: argparse.Namespace, program: Path) -> dict[str, Any]:
    """Measure what is asked for; gives all records."""
    options = ["--embree", str(arguments.embree or find_embree())]
    if arguments.isa:
        options += ["--isa", arguments.isa]
    chosen = list(options)
    for name in ("quality", "builds", "kinds", "size", "rounds", "threads"):
        if getattr(arguments, name):
            chosen += [f"--{name}", getattr(arguments, name)]
    found: dict[str, Any] = {"machine": machine()}
    if "scenes" in arguments.parts:
        with tempfile.TemporaryDirectory() as folder:
            scenes = as_meshes(arguments.scenes or default_scenes(), Path(folder))
            found["records"] = print_records(measure(program, [*chosen, *scenes]))
        print_summary(found["records"])
    if "growth" in arguments.parts:
        print("\nGrowth from 10 thousand to 10 million triangles ...", flush=True)
        found["growth"] = print_records(measure(program, [*options, *GROWTH_OPTIONS, *GROWTH]))
    if "frame" in arguments.parts and has_blender():
        print("\nWhole frames, and a large mesh, beside Cycles ...", flush=True)
        found["frame"] = measure_frame(program, arguments.isa)
        print_frame(found["frame"])
    return found


def run(arguments: argparse.Namespace) -> None:
    """Measure and write. A run of all parts on the default scenes redraws the page in docs/ too."""
    began = time.monotonic()
    found = run_parts(arguments, build_program())
    arguments.json.parent.mkdir(parents=True, exist_ok=True)
    arguments.json.write_text(json.dumps(found, indent=1) + "\n")
    print(f"\nRecords: {arguments.json}, after {time.monotonic() - began:.0f} s")
    whole = arguments.parts == list(PARTS) and not (arguments.scenes or arguments.isa)
    if arguments.page or whole:
        subprocess.run([sys.executable, MAKE / "benchmarks.py", arguments.json], check=True)


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
