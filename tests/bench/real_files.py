#!/usr/bin/env python3
"""How the model files of a folder come out, with the default options alone.

  tests/bench/real_files.py TESSERA FOLDER... [--size 256x192] [--spp 4] [--pictures FOLDER] [--json FILE]

Each file below the folders is rendered by itself. The table has a line a format: how many files were
rendered and refused, in how many of the pictures something was warned of, no ray met a surface, or more
than 5 % of the pixels were brighter than white; the median and the longest processor seconds. Below it
stand, by name, the files that were refused, each with its reason, that took more than --seconds, that
ended otherwise, and the pictures that are empty without a word.
"""
import argparse
import collections
import json
import os
import pathlib
import re
import resource
import statistics
import subprocess
import tempfile

FORMATS = {".gltf": "glTF", ".glb": "GLB", ".x3d": "X3D", ".x3dv": "X3DV", ".x3dz": "X3D", ".wrl": "VRML",
           ".wrz": "VRML", ".obj": "OBJ", ".ply": "PLY", ".stl": "STL"}
CLIPPED = 5  # percent of the pixels, from which on a picture counts as burnt out


def render(program, file, picture, options):
    """What became of one file, as a dictionary."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        statistics_file = os.path.join(folder, "stats.json")
        command = [program, "render", file, "-o", picture or os.path.join(folder, "picture.png"), "--size",
                   options.size, "--spp", str(options.spp), "--workers", "0", "--stats", statistics_file]
        try:
            run = subprocess.run(command, capture_output=True, text=True, errors="replace",
                                 stdin=subprocess.DEVNULL, timeout=options.seconds)
            code, told = run.returncode, run.stderr
        except subprocess.TimeoutExpired:
            code, told = None, ""
        figures = {}
        if code == 0:
            with open(statistics_file, encoding="utf-8") as text:
                figures = json.load(text)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    clipped = re.search(r"([\d.]+) % of the picture is brighter than white", told)
    return {"file": file, "code": code, "warnings": re.findall(r"warning:? (.*)", told),
            "reason": next((line for line in told.splitlines() if "warning" not in line), "").strip(),
            "empty": figures.get("hits") == 0, "clipped": float(clipped.group(1)) if clipped else 0,
            "seconds": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime}


def table(results):
    """The lines, one a format."""
    by_format = collections.defaultdict(list)
    for result in results:
        by_format[FORMATS[pathlib.Path(result["file"]).suffix.lower()]].append(result)
    yield f"| {'format':6} | files | rendered | refused | warned | no hit | clipped | median s | longest s |"
    yield "| --- |" + " --- |" * 8
    for name, group in sorted(by_format.items()) + [("all", results)]:
        done = [result for result in group if result["code"] == 0]
        seconds = [result["seconds"] for result in done] or [0]
        counts = [len(group), len(done), sum(result["code"] == 1 for result in group),
                  sum(bool(result["warnings"]) for result in done), sum(result["empty"] for result in done),
                  sum(result["clipped"] > CLIPPED for result in done)]
        yield (f"| {name:6} | " + " | ".join(map(str, counts)) +
               f" | {statistics.median(seconds):.2f} | {max(seconds):.2f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--size", default="256x192")
    parser.add_argument("--spp", type=int, default=4)
    parser.add_argument("--seconds", type=float, default=60, help="after which a file is given up")
    parser.add_argument("--pictures", help="keep the pictures there")
    parser.add_argument("--json", help="write what became of each file there")
    options = parser.parse_args()
    files = sorted(str(path) for folder in options.folders for path in pathlib.Path(folder).rglob("*")
                   if path.suffix.lower() in FORMATS and path.is_file())
    results = []
    for number, file in enumerate(files):
        picture = None
        if options.pictures:
            os.makedirs(options.pictures, exist_ok=True)
            picture = os.path.join(options.pictures, f"{number:04d}_{pathlib.Path(file).name}.png")
        results.append(render(options.program, file, picture, options))
    print("\n".join(table(results)))
    for title, chosen in [
            ("refused", lambda r: r["code"] == 1),
            ("given up", lambda r: r["code"] is None),
            ("ended otherwise", lambda r: r["code"] not in (None, 0, 1)),
            ("empty without a word", lambda r: r["code"] == 0 and r["empty"] and not r["warnings"])]:
        for result in filter(chosen, results):
            print(f"{title}: {result['file']}: {result['reason']}")
    if options.json:
        pathlib.Path(options.json).write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
