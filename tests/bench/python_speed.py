#!/usr/bin/env python3
"""What the Python package costs beside the command line and numpy: rows P1 to P4 and P7 to P10.

Each row alternates two things and prints the median of each, their ratio and what is wanted.

    PYTHONPATH=build/release/python tests/bench/python_speed.py [--rounds 9] [--json FILE]

python_rays.py beside this measures ray queries.
"""
import argparse
import hashlib
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np

import tessera as ts

ROOT = pathlib.Path(__file__).parents[2]
KNOT = str(ROOT / "scenes" / "samples" / "knot.tessera")
SIZE = (480, 270)
TRIANGLES = 1_000_000


def seconds(work):
    """Wall-clock seconds of one call."""
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


class Table:
    """Rows of medians, measured by turns."""

    def __init__(self, rounds):
        self.rounds = rounds
        self.rows = []

    def row(self, name, ours, theirs, wanted):
        """Measures both, ours first, each once to warm up."""
        seconds(ours), seconds(theirs)
        pairs = [(seconds(ours), seconds(theirs)) for _ in range(self.rounds)]
        a, b = (statistics.median(column) for column in zip(*pairs))
        self.add(name, a, b, wanted)

    def add(self, name, ours, theirs, wanted):
        """One measured row."""
        ratio = ours / theirs if theirs else float("nan")
        self.rows.append({"row": name, "seconds": ours, "beside": theirs, "ratio": ratio,
                          "wanted": wanted})
        print(f"{name:<52} {ours * 1e3:9.2f} ms {theirs * 1e3:9.2f} ms  {ratio:6.2f}   {wanted}",
              flush=True)


def python(script):
    subprocess.run([sys.executable, "-c", script], check=True)


def command_line(folder):
    subprocess.run([ts.program(), "render", KNOT, "--size", f"{SIZE[0]}x{SIZE[1]}", "--quiet",
                    "-o", f"{folder}/x.png"], check=True)


def starting(table, folder):
    table.row("P1 import, over an empty Python", lambda: python("import tessera"),
              lambda: python("pass"), "difference <= 60 ms")
    whole = f"import tessera as t; t.render({KNOT!r}, size={SIZE}).save({folder + '/y.png'!r})"
    table.row("P2 a script that renders, over the command line", lambda: python(whole),
              lambda: command_line(folder), "difference <= 150 ms")
    table.row("P2 render() in a running Python", lambda: ts.render(KNOT, size=SIZE).save(
        folder + "/z.png"), lambda: command_line(folder), "difference <= 20 ms")
    with ts.LocalFarm() as farm:
        table.row("P3 with a kept LocalFarm", lambda: ts.render(KNOT, size=SIZE, farm=farm),
                  lambda: command_line(folder), "<= .6")
    ball = ts.Scene(width=16, height=16)
    ball.add(ts.Sphere(), ts.DirectionalLight((0, 0, -1)))
    with ts.Threads(1) as farm:
        table.row("P3 a sphere at 16x16 by kept Threads(1)", lambda: ball.render(farm=farm),
                  lambda: None, "<= 5 ms")


def grid(count):
    """A wavy square of that many triangles."""
    side = int((count / 2) ** .5)
    x, y = np.meshgrid(np.linspace(-1, 1, side + 1), np.linspace(-1, 1, side + 1))
    points = np.stack([x, y, .1 * np.sin(9 * x) * np.cos(7 * y)], axis=-1).reshape(-1, 3)
    i = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).reshape(-1)
    quads = np.stack([i, i + 1, i + side + 2, i, i + side + 2, i + side + 1], axis=-1)
    return points.astype(np.float32), quads.reshape(-1, 3).astype(np.uint32)


def first_tile(scene, farm):
    """Seconds until the first tile is done."""
    begin = time.perf_counter()
    with ts.render(scene, size=(64, 64), farm=farm, wait=False) as task:
        while task.progress.done == 0 and not task.done():
            time.sleep(.0005)
        return time.perf_counter() - begin


def changing(table):
    points, triangles = grid(TRIANGLES)
    ratios = []
    for _ in range(max(3, table.rounds // 3)):
        material = ts.Classic(diffuse=(.5, .5, .5))
        scene = ts.Scene()
        scene.add(ts.Mesh(points, triangles), material=material)
        scene.add(ts.DirectionalLight((0, 0, -1)))
        with ts.LocalFarm() as farm:
            first = first_tile(scene, farm)
            material.diffuse = (.9, .1, .1)
            ratios.append((first_tile(scene, farm), first))
    a, b = (statistics.median(column) for column in zip(*ratios))
    table.add("P4 first tile after a change of material, 10^6 triangles", a, b, "<= .3")


def arrays(table):
    points, triangles = grid(TRIANGLES)
    copies = np.empty_like(points), np.empty_like(triangles)

    def copy():
        np.copyto(copies[0], points), np.copyto(copies[1], triangles)

    def describe():
        scene = ts.Scene()
        scene.add(ts.Mesh(points, triangles))
        scene.digest

    wide, long = points.astype(np.float64), triangles.astype(np.int64)
    data = points.tobytes() + triangles.tobytes()
    table.row("P7 Mesh of 10^6 triangles, over two copies", lambda: ts.Mesh(points, triangles), copy,
              "<= 2")
    table.row("P7 to its digest, over blake2b", describe,
              lambda: hashlib.blake2b(data, digest_size=32).digest(), "<= 1.3")
    table.row("P7 from float64 and int64, over numpy's astype", lambda: ts.Mesh(wide, long),
              lambda: (wide.astype(np.float32), long.astype(np.uint32)), "")

    def objects():
        scene = ts.Scene()
        scene.add(*[ts.Sphere((i, 0, 0), .1) for i in range(100_000)])
        scene.digest

    def instances():
        moves = np.tile(np.eye(4)[:3], (100_000, 1, 1))
        moves[:, 0, 3] = np.arange(100_000)
        scene = ts.Scene()
        scene.instances(ts.Sphere(), moves)
        scene.digest

    table.row("P8 10^5 spheres as objects", objects, lambda: None, "<= 1 s")
    table.row("P8 as one call of instances", instances, lambda: None, "<= .15 s")


def pictures(table):
    image = ts.Image.from_array(np.ones((4320, 7680, 3), np.float32))
    table.row("P9 image.linear of 7680x4320", lambda: ts.Image._of(image._picture).linear,
              lambda: None, "<= .05 ms")


def counting(table):
    """How far a thread counts beside a render on the other core, over counting alone."""
    def count(until):
        n = 0
        while not until():
            n += 1
        return n

    def alone():
        end = time.perf_counter() + .5
        return count(lambda: time.perf_counter() > end)

    rates = []
    with ts.Threads(1) as farm:
        for _ in range(max(3, table.rounds // 3)):
            free = alone()
            with ts.render(KNOT, size=(4000, 3000), spp=64, farm=farm, wait=False):
                rates.append((free, alone()))
    a, b = (statistics.median(column) for column in zip(*rates))
    print(f"{'P10 a counting thread beside a render':<52} {b / a:6.2f}   >= .8")
    table.rows.append({"row": "P10", "ratio": b / a, "wanted": ">= .8"})


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--json")
    options = parser.parse_args()
    table = Table(options.rounds)
    with tempfile.TemporaryDirectory() as folder:
        starting(table, folder)
    changing(table)
    arrays(table)
    pictures(table)
    counting(table)
    if options.json:
        pathlib.Path(options.json).write_text(json.dumps({"rows": table.rows}, indent=2) + "\n")


if __name__ == "__main__":
    main()
