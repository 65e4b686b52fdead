# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Error against run time, settings that change no bit, and what leaving out saves."""

from __future__ import annotations

import argparse
import csv
import statistics
import sys
from dataclasses import dataclass
from pathlib import Path

import bpy
import capture
import error
import leaving_out
import report_page
import same_bits
import studio

PERCENT, ROUNDS = 25, 3  # unless asked for otherwise


@dataclass
class Report:
    """Everything that the page is written from."""

    scene: str
    command: str  # that makes this report again
    size: tuple[int, int]
    machine: str
    blender: str
    isa: str
    threads: int
    rounds: int
    triangles: int
    reference: error.Reference
    errors: list[error.Row]
    identities: list[same_bits.Row]
    needs: list[leaving_out.Row]

    def failures(self) -> list[str]:
        """Settings that changed a bit, by name; none if all is well."""
        first = self.identities[0].digest
        bad = [f"{row.setting} {row.value}" for row in self.identities if row.digest != first]
        return bad + [f"kernel without {row.need}" for row in self.needs if not row.same]


def measure(path: Path | None, percent: int, rounds: int) -> Report:
    """Render and time everything, at a percentage of the scene's resolution."""
    machine = studio.machine()
    studio.register()
    scene = studio.open_scene(path)
    scene.render.resolution_percentage = percent
    exports, builds = [], []
    for _ in range(rounds):
        shot = capture.shot(scene)
        exports.append(shot.seconds)
        core_scene = shot.scene()
        built = core_scene.build()
        builds.append(built["seconds"])
    fixed = statistics.median(exports), statistics.median(builds)
    reference = error.make_reference(core_scene, shot)
    errors = list(error.sweep(core_scene, shot, reference, fixed, rounds))
    del core_scene
    identities = list(same_bits.run(shot))
    identities += same_bits.run_isas(shot.core, path, percent)
    return Report(
        scene=studio.name_of(path),
        command=_command(path, percent, rounds),
        size=(shot.camera["width"], shot.camera["height"]),
        machine=machine,
        blender=bpy.app.version_string,
        isa=shot.core.isa(),
        threads=shot.core.default_threads(),
        rounds=rounds,
        triangles=built["triangles"],
        reference=reference,
        errors=errors,
        identities=identities,
        needs=list(leaving_out.run(shot, rounds)),
    )


def _command(path: Path | None, percent: int, rounds: int) -> str:
    scene = f' SCENE="{path}"' if path else ""
    usual = (percent, rounds) == (PERCENT, ROUNDS)
    return f"make report{scene}" + (
        "" if usual else f' ARGS="--percent {percent} --rounds {rounds}"'
    )


def write_csv(rows: list[error.Row], path: Path) -> None:
    """A line for each setting; times in seconds, errors in linear light."""
    names = list(error.Row.__dataclass_fields__)
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*names, "seconds"])
        writer.writerows([*(getattr(row, name) for name in names), row.seconds] for row in rows)


def main() -> int:
    """Exit codes: 0 written and every bit as it must be; 1 not so, and stderr says what."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", type=Path, help="a .blend file; default: the demo scene")
    parser.add_argument("--percent", type=int, default=PERCENT, help="of the scene's resolution")
    parser.add_argument("--rounds", type=int, default=ROUNDS, help="renders to take the median of")
    parser.add_argument(
        "--out", type=Path, help="the page's folder; default: docs for the demo, out for a .blend"
    )
    arguments = parser.parse_args()
    out = arguments.out or studio.ROOT / ("out" if arguments.scene else "docs")
    try:
        found = measure(arguments.scene, arguments.percent, arguments.rounds)
    except (RuntimeError, ValueError, OSError) as problem:
        print(f"whittle: {str(problem).strip()}", file=sys.stderr)
        return 1
    (out / "pictures").mkdir(parents=True, exist_ok=True)
    write_csv(found.errors, out / "error-and-time.csv")
    report_page.draw(found, out / "pictures" / "error-and-time.png")
    page = report_page.page(found)
    (out / "error-and-time.md").write_text(page, encoding="utf-8")
    print(page)
    for failure in found.failures():
        print(f"whittle: {failure} changed the picture's bits", file=sys.stderr)
    return 1 if found.failures() else 0


if __name__ == "__main__":
    sys.exit(main())
