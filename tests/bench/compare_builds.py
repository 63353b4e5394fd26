#!/usr/bin/env python3
"""Two builds of Tessera beside each other: the time that each takes to trace the same scenes.

  tests/bench/compare_builds.py BEFORE AFTER [SCENE...] [--data DIR] [--turns 5]
      [--most-samples 16] [--json FILE]

BEFORE and AFTER are programs. They render in turns, with one thread, all scenes unless some are named
by parts of their names: the pictures of docs/gallery.md, the scenes of `bench error`, the models of
beside_cycles.py and, where DIR has them, each `crt/*.crt` and a Stanford bunny, `obj/*bunny*.obj`, on a
floor under two point lights at 1920x1080. Long pictures are made with fewer samples (--most-samples).

A figure is processor seconds of tracing: of the program's, the share that tracing has of the wall
time in its own statistics. Each row has the medians, and the median of the ratios of the turns; below
1, AFTER is faster. `same` says whether the linear pictures are equal or, of `bench error`, the errors.
"""
import argparse
import json
import math
import pathlib
import re
import shlex
import shutil
import statistics
import subprocess
import sys
import tempfile

import beside_cycles
from timed_render import cpu_seconds

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUNNY = """\
settings { width: 1920 height: 1080 integrator { kind: "whitted" } }
cameras { world_from_camera { steps { look_at { eye { x: -0.03 y: 0.16 z: 0.25 } target { x: -0.017 y: 0.1 } } } } }
includes { file: "bunny.obj" }
materials { name: "floor" classic { diffuse { value { r: .6 g: .6 b: .6 } } } }
nodes { shape { materials: "floor" rectangle { corner { x: -1 y: 0.033 z: 1 } edge_u { x: 2 } edge_v { z: -2 } } } }
nodes { light { point { position { x: -1 y: 1.5 z: 1 } } } }
nodes { light { point { position { x: 1 y: 1 z: .5 } } } }
"""


class Scene:
    """A scene file and the options that render it."""

    def __init__(self, name, path, *options):
        self.name, self.path, self.options = name, path, list(options)

    def measure(self, program, folder):
        """Processor seconds of tracing, and the digest of the linear picture."""
        statistics_file = folder / "statistics.json"
        began = cpu_seconds()
        subprocess.run([program, "render", self.path, "--workers", "0", "--threads", "1", "--quiet",
                        "-o", folder / "picture.png", "--stats", statistics_file, *self.options],
                       check=True, cwd=ROOT)
        used = cpu_seconds() - began
        told = json.loads(statistics_file.read_text())
        return used * told["seconds"]["trace"] / told["seconds"]["total"], told["pixels_sha256"]


class ErrorScene:
    """A scene of `bench error`, by its own clock."""

    def __init__(self, name):
        self.name = f"bench error {name}"
        self.scene = name

    def measure(self, program, folder):
        rows = folder / "rows.json"
        subprocess.run([program, "bench", "error", self.scene, "--methods", "owen", "--samples", "16-16",
                        "--seeds", "4", "--threads", "1", "--cpu-time", "--budget", "0", "--json", rows],
                       check=True, capture_output=True)
        row, = [row for row in json.loads(rows.read_text())["rows"] if row["samples"] == 16]
        return row["seconds"], row["rmse"]


def gallery(most_samples):
    for line in (ROOT / "docs/gallery.md").read_text().splitlines():
        if not line.startswith("tessera render "):
            continue
        path, *options = shlex.split(line)[2:]
        if "--spp" in options:
            at = options.index("--spp") + 1
            options[at] = str(min(int(options[at]), most_samples))
        yield Scene(f"{pathlib.Path(path).name} {' '.join(options)}".strip(), ROOT / path, *options)


def error_scenes(program):
    told = subprocess.run([program, "bench", "error", "--help"], check=True, capture_output=True,
                          text=True).stdout
    names = re.search(r"SCENE TEXT \.\.\.\s+(.*?), or files", told, re.DOTALL)[1]
    return map(ErrorScene, re.split(r",\s+", names))


def models(folder):
    beside_cycles.write_model(folder / "model.obj")
    beside_cycles.write_floor(folder / "floor.png")
    beside_cycles.write_sky(folder / "sky.hdr")
    for kind in beside_cycles.KINDS:
        path = folder / f"{kind}.tessera"
        beside_cycles.write_scene(path, kind)
        yield Scene(f"knotted tube: {kind}", path, "--spp", "4", "--size", "512x512")


def files_of(data, folder):
    for path in sorted(data.glob("crt/*.crt")):
        yield Scene(path.name, path, "--spp", "1")
    for path in sorted(data.glob("obj/*bunny*.obj"))[:1]:
        shutil.copy(path, folder / "bunny.obj")
        (folder / "bunny.tessera").write_text(BUNNY)
        yield Scene("bunny", folder / "bunny.tessera", "--spp", "1")


def compare(scene, before, after, turns, folder):
    """A row of the table."""
    times, bits = {before: [], after: []}, {}
    for turn in range(turns):
        for program in (before, after) if turn % 2 == 0 else (after, before):
            seconds, bits[program] = scene.measure(program, folder)
            times[program].append(seconds)
    ratios = [b / a for a, b in zip(times[before], times[after])]
    return {"scene": scene.name, "before": statistics.median(times[before]),
            "after": statistics.median(times[after]), "ratio": statistics.median(ratios),
            "least": min(ratios), "most": max(ratios), "same": bits[before] == bits[after]}


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before")
    parser.add_argument("after")
    parser.add_argument("scenes", nargs="*", metavar="SCENE")
    parser.add_argument("--data", type=pathlib.Path)
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--most-samples", type=int, default=16)
    parser.add_argument("--json", type=pathlib.Path)
    options = parser.parse_args()
    programs = []
    for program in (options.before, options.after):
        found = shutil.which(program)
        if not found:
            parser.error(f"there is no program '{program}'")
        programs.append(str(pathlib.Path(found).resolve()))
    if programs[0] == programs[1]:
        parser.error("both are the same program; expected two")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        scenes = [*gallery(options.most_samples), *error_scenes(programs[0]), *models(folder),
                  *(files_of(options.data.resolve(), folder) if options.data else ())]
        if options.scenes:
            scenes = [each for each in scenes if any(part in each.name for part in options.scenes)]
        if not scenes:
            parser.error("no scene has such a name")
        print("| scene | before, s | after, s | after / before | of all turns | same |\n"
              "| --- | --- | --- | --- | --- | --- |")
        rows = []
        for scene in scenes:
            row = compare(scene, *programs, options.turns, folder)
            rows.append(row)
            print(f"| {row['scene']} | {row['before']:.3f} | {row['after']:.3f} | {row['ratio']:.3f} "
                  f"| {row['least']:.2f} to {row['most']:.2f} "
                  f"| {'yes' if row['same'] else 'no'} |", flush=True)
    mean = math.exp(statistics.fmean(math.log(row["ratio"]) for row in rows))
    slowest = max(rows, key=lambda row: row["ratio"])
    print(f"\nGeometric mean {mean:.3f}; slowest {slowest['scene']}, {slowest['ratio']:.3f}",
          file=sys.stderr)
    if options.json:
        options.json.write_text(json.dumps({"rows": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main()
