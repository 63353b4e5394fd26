#!/usr/bin/env python3
"""Processor time to equal error: adaptive sampling against as many samples everywhere.

    tests/bench/adaptive_time.py TESSERA [SCENE...]

Each picture's error is its root mean square difference from one of --reference samples and another
seed, in linear light. The time of uniform sampling to an adaptive picture's error is read off the
line between its two neighbours, both axes logarithmic. One thread, the least of --repeat runs."""
import argparse
import math
import pathlib
import tempfile

import timed_render

SAMPLES = pathlib.Path(__file__).parents[2] / "scenes/samples"
SCENES = ["still_life.tessera", "lanterns.tessera", "mosaic.tessera", "knot.tessera", "temple.x3d",
          "stage.tessera", "toolbox.tessera", "hall.tessera"]
UNIFORM = [8, 16, 32, 64, 128, 256]
TARGETS = [0.03, 0.01, 0.003]


class Bench:
    def __init__(self, arguments, folder):
        self.arguments, self.picture = arguments, pathlib.Path(folder) / "picture.pfm"

    def render(self, scene, *options, repeat=None):
        """The pixels, and the processor seconds."""
        found = [timed_render.render(self.arguments.program, scene, self.picture, "--size",
                                     self.arguments.size, *options)
                 for _ in range(repeat or self.arguments.repeat)]
        return found[0][0], min(seconds for _, seconds in found)

    def compare(self, scene):
        truth, _ = self.render(scene, "--spp", str(self.arguments.reference), "--seed", "1000",
                               repeat=1)

        def error(values):
            return math.sqrt(timed_render.mean_square(values, truth))

        # Reading and building the scene is the same for both.
        _, start = self.render(scene, "--spp", "1", "--crop", "0,0,1,1")
        curve = []
        for samples in UNIFORM:
            values, seconds = self.render(scene, "--spp", str(samples))
            curve.append((math.log(error(values)), math.log(seconds - start)))
        for target in TARGETS:
            values, seconds = self.render(scene, "--spp", "1024", "--target-error", str(target))
            e, t = error(values), seconds - start
            uniform = time_at(curve, math.log(e))
            print(f"{pathlib.Path(scene).name:20} {target:6} error {e:.5f}  {t:7.2f} s  "
                  f"uniform {uniform:7.2f} s  ratio {t / uniform:.2f}", flush=True)


def time_at(curve, error):
    """Seconds on the line through the neighbours of a logarithm of an error, or the nearest two."""
    pairs = list(zip(curve, curve[1:]))
    for (e0, t0), (e1, t1) in pairs:
        if e1 <= error or ((e0, t0), (e1, t1)) == pairs[-1]:
            slope = (t1 - t0) / (e1 - e0)
            return math.exp(t0 + slope * (error - e0))
    raise AssertionError


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("scenes", nargs="*", default=[SAMPLES / name for name in SCENES])
    parser.add_argument("--size", default="160x90")
    parser.add_argument("--reference", type=int, default=4096)
    parser.add_argument("--repeat", type=int, default=3)
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(parser.parse_args(), folder)
        for scene in bench.arguments.scenes:
            bench.compare(scene)


if __name__ == "__main__":
    main()
