#!/usr/bin/env python3
"""What the Python package costs beside the command line and numpy: rows P1 to P4 and P7 to P10.

Each row takes the things it compares by turns and tells their medians.

    PYTHONPATH=build/release/python python3 tests/bench/python_speed.py [--rounds 9] [--check]

python_rays.py beside this measures ray queries.
"""
import argparse
import hashlib
import pathlib
import statistics
import subprocess
import sys
import tempfile
import threading
import time

import numpy as np
from bench_table import Table, add_options, medians

import tessera as ts

ROOT = pathlib.Path(__file__).parents[2]
KNOT = str(ROOT / "scenes" / "samples" / "knot.tessera")


class Sizes:
    """How much is measured."""

    def __init__(self, tiny):
        self.picture = (48, 27) if tiny else (480, 270)
        self.small_picture = (16, 9) if tiny else (96, 54)
        self.large_picture = (64, 36) if tiny else (7680, 4320)
        self.triangles = 2000 if tiny else 1_000_000
        self.objects = 100 if tiny else 100_000
        self.counting = .02 if tiny else .5  # seconds
        self.rays = 10_000 if tiny else 2_000_000


def milliseconds(*taken):
    """"12.3 and 4.5 ms"."""
    return " and ".join(f"{t * 1e3:.2f}" for t in taken) + " ms"


def python(script):
    subprocess.run([sys.executable, "-c", script], check=True)


def command_line(folder, size):
    subprocess.run([ts.program(), "render", KNOT, "--size", f"{size[0]}x{size[1]}", "--quiet",
                    "-o", f"{folder}/x.png"], check=True)


def starting(table, sizes, rounds, folder):
    ours, theirs = medians(rounds, lambda: python("import tessera"), lambda: python("pass"))
    table.add("P1 import, above an empty Python", (ours - theirs) * 1e3, "ms", at_most=60,
              of=milliseconds(ours, theirs))

    whole = f"import tessera as t; t.render({KNOT!r}, size={sizes.picture}).save({folder + '/y.png'!r})"
    script, running, theirs = medians(
        rounds, lambda: python(whole),
        lambda: ts.render(KNOT, size=sizes.picture).save(folder + "/z.png"),
        lambda: command_line(folder, sizes.picture))
    table.add("P2 a script that renders, above the command line", (script - theirs) * 1e3, "ms",
              at_most=150, of=milliseconds(script, theirs))
    table.add("P2 render() in a running Python, above it", (running - theirs) * 1e3, "ms",
              at_most=20, of=milliseconds(running, theirs))


def kept_farms(table, sizes, rounds, folder):
    """A farm that is kept saves the start, never the tracing: so both are told, and the limit is on
    the whole only where tracing by itself takes less than the limit."""
    with ts.LocalFarm() as farm:
        for size in (sizes.picture, sizes.small_picture):
            traced = []

            def kept():
                traced.append(ts.render(KNOT, size=size, farm=farm).stats["seconds"]["trace"])

            ours, theirs = medians(rounds, kept, lambda: command_line(folder, size))
            tracing = statistics.median(traced)
            name = "P3 {}x{} by a kept LocalFarm, of the command line".format(*size)
            is_tracing = tracing > .6 * theirs
            table.add(name, ours / theirs, "", at_most=None if is_tracing else .6,
                      of=f"{milliseconds(ours, theirs)}; {tracing * 1e3:.2f} ms of each trace")
            if is_tracing:
                table.add("   less the tracing, which by itself is above .6",
                          (ours - tracing) / (theirs - tracing), "", at_most=.6)
    ball = ts.Scene(width=16, height=16)
    ball.add(ts.Sphere(), ts.DirectionalLight((0, 0, -1)))
    with ts.Threads(1) as farm:
        ours, = medians(rounds, lambda: ball.render(farm=farm))
    table.add("P3 a sphere at 16x16 by kept Threads(1)", ours * 1e3, "ms", at_most=5)


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


def changing(table, sizes, rounds):
    points, triangles = grid(sizes.triangles)
    taken = []
    for _ in range(rounds):
        material = ts.Classic(diffuse=(.5, .5, .5))
        scene = ts.Scene()
        scene.add(ts.Mesh(points, triangles), material=material)
        scene.add(ts.DirectionalLight((0, 0, -1)))
        with ts.LocalFarm() as farm:
            first = first_tile(scene, farm)
            material.diffuse = (.9, .1, .1)
            taken.append((first_tile(scene, farm), first))
    second, first = (statistics.median(column) for column in zip(*taken))
    table.add("P4 first tile after a change of material, of the first's", second / first, "",
              at_most=.3, of=milliseconds(second, first))


def moving(table, sizes, rounds):
    """A camera that goes around a mesh, by a kept farm: what a frame takes over its tracing."""
    scene = ts.Scene(width=320, height=240, spp=1)
    scene.add(ts.Mesh(*grid(sizes.triangles)), ts.DirectionalLight((0, 0, -1)))
    over = []
    with ts.LocalFarm() as farm:
        for i in range(10 * rounds + 1):
            scene.camera = ts.Camera.look_at(eye=(np.cos(i / 5), np.sin(i / 5), 2), target=(0, 0, 0))
            begin = time.perf_counter()
            stats = scene.render(farm=farm).stats
            over.append(time.perf_counter() - begin - stats["seconds"]["trace"])
    table.add("P4 a frame after a move of the camera, over its tracing", statistics.median(over[1:]) * 1e3,
              "ms", at_most=30)


def arrays(table, sizes, rounds):
    points, triangles = grid(sizes.triangles)
    wide, long = points.astype(np.float64), triangles.astype(np.int64)
    shared = points.copy()
    shared.flags.writeable = False
    copies = np.empty_like(points), np.empty_like(triangles)
    mesh, copy, of_shared, of_wide, astype = medians(
        rounds, lambda: ts.Mesh(points, triangles),
        lambda: (np.copyto(copies[0], points), np.copyto(copies[1], triangles)),
        lambda: [ts.Mesh(shared, triangles[:1]) for _ in range(100)], lambda: ts.Mesh(wide, long),
        lambda: (wide.astype(np.float32), long.astype(np.uint32)))
    table.add("P7 Mesh of 10^6 triangles, of two copies", mesh / copy, "", at_most=2,
              of=milliseconds(mesh, copy))
    table.add("P7 with shared positions, without indices to copy", of_shared / 100 * 1e3, "ms", at_most=.05)
    table.add("P7 what float64 and int64 add, of numpy's astype", (of_wide - mesh) / astype, "",
              at_most=1, of=milliseconds(of_wide, mesh, astype))

    data = points.tobytes() + triangles.tobytes()

    def describe():
        scene = ts.Scene()
        scene.add(ts.Mesh(points, triangles))
        scene.digest

    ours, theirs = medians(rounds, describe, lambda: hashlib.blake2b(data, digest_size=32).digest())
    table.add("P7 to its digest, of hashlib's blake2b", ours / theirs, "", at_most=1.3,
              of=milliseconds(ours, theirs))


def many_objects(table, sizes, rounds):
    def objects():
        scene = ts.Scene()
        scene.add(*[ts.Sphere((i, 0, 0), .1) for i in range(sizes.objects)])
        scene.digest

    def instances():
        moves = np.tile(np.eye(4)[:3], (sizes.objects, 1, 1))
        moves[:, 0, 3] = np.arange(sizes.objects)
        scene = ts.Scene()
        scene.instances(ts.Sphere(), moves)
        scene.digest

    one_by_one, at_once = medians(rounds, objects, instances)
    table.add("P8 10^5 spheres as objects", one_by_one, "s", at_most=1)
    table.add("P8 as one call of instances", at_once, "s", at_most=.15)


def pictures(table, sizes, rounds, folder):
    width, height = sizes.large_picture
    values = np.random.default_rng(1).random((height, width, 3), np.float32)
    image = ts.Image.from_array(values)
    linear, ours, saved = medians(
        rounds, lambda: [ts.Image._of(image._picture).linear for _ in range(100)], image.to_srgb,
        lambda: image.save(folder + "/large.png"))
    table.add("P9 image.linear of 7680x4320", linear / 100 * 1e3, "ms", at_most=.05)
    # Both call one function for the tone mapping; the command line compresses what it returns.
    table.add("P9 to_srgb(), of a PNG by the command line's function", ours / saved, "", at_most=1,
              of=milliseconds(ours, saved))


def counting(table, sizes, rounds):
    """How far a thread counts beside work on the other core, over counting alone."""
    def count():
        end = time.perf_counter() + sizes.counting
        n = 0
        while time.perf_counter() < end:
            n += 1
        return n

    def told(name, rates):
        alone, beside = (statistics.median(column) for column in zip(*rates))
        table.add(f"P10 a counting thread beside a {name}", beside / alone, "", at_least=.8)

    rates = []
    with ts.Threads(1) as farm:
        for _ in range(rounds):
            alone = count()
            with ts.render(KNOT, size=(4000, 3000), spp=64, farm=farm, wait=False):
                rates.append((alone, count()))
    told("render", rates)

    tracer = ts.load(KNOT).tracer(threads=1)
    random = np.random.default_rng(1)
    origins, directions = random.uniform(-1, 1, (2, sizes.rays, 3))
    rates = []
    for _ in range(rounds):
        alone = count()
        ended = threading.Event()

        def query():
            while not ended.is_set():
                tracer.intersect(origins, directions, threads=1)

        thread = threading.Thread(target=query)
        thread.start()
        rates.append((alone, count()))
        ended.set()
        thread.join()
    told("query", rates)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add_options(parser, 9)
    options = parser.parse_args()
    table, sizes, rounds = Table(), Sizes(options.tiny), options.rounds
    few = max(1, rounds // 3)
    with tempfile.TemporaryDirectory() as folder:
        starting(table, sizes, rounds, folder)
        kept_farms(table, sizes, rounds, folder)
        changing(table, sizes, few)
        moving(table, sizes, few)
        arrays(table, sizes, rounds)
        many_objects(table, sizes, few)
        pictures(table, sizes, few, folder)
        counting(table, sizes, few)
    table.finish(options)


if __name__ == "__main__":
    main()
