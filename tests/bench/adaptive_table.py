#!/usr/bin/env python3
"""What adaptive sampling takes to the error that as many samples everywhere have.

    tests/bench/adaptive_table.py TESSERA [SCENE...] [--samples 4 8 16 32]

For each scene of `tessera bench error` and each count N: the error of N samples a pixel everywhere,
against a picture of --reference samples; then the target error at which adaptive sampling, of at
most 16 N and at least N / 2 samples, has that error, found by halving; and what it takes then,
samples and processor time of tracing, over what N samples everywhere take. N is a power of two,
where uniform sampling is at its best. Means over --seeds pictures; one thread."""
import argparse
import json
import math
import pathlib
import statistics
import subprocess
import tempfile

import timed_render

SCENES = ["cornell", "edge", "checker", "textured", "lens", "mirrors", "sky-wall", "furnace",
          "sphere-light", "glossy", "rectangle-light", "plates", "caustic", "many-lights"]


class Bench:
    def __init__(self, options, folder):
        self.options, self.folder = options, pathlib.Path(folder)
        self.scene = self.folder / "scene.tessera"
        self.truth = None

    def render(self, seed, *words):
        """Pixels, samples a pixel (of those that may see something) and processor seconds."""
        stats = self.folder / "stats.json"
        found, seconds = timed_render.render(
            self.options.program, self.scene, self.folder / "picture.pfm", "--size",
            self.options.size, "--seed", str(seed), "--stats", stats, *words)
        told = json.loads(stats.read_text())
        return found, told["rays"]["primary"] / (told["width"] * told["height"]), seconds

    def measure(self, *words):
        """Error, samples a pixel, seconds: over all seeds."""
        squares, counts, seconds = [], [], []
        for seed in range(1, self.options.seeds + 1):
            found, count, took = self.render(seed, *words)
            squares.append(timed_render.mean_square(found, self.truth))
            counts.append(count)
            seconds.append(took)
        return math.sqrt(statistics.mean(squares)), statistics.mean(counts), min(seconds)

    def to_error(self, wanted, samples):
        """At the target error that gives the wanted one."""
        words = ["--spp", str(16 * samples), "--min-spp", str(max(2, int(samples * self.options.least)))]
        low, high, best = math.log(wanted / 8), math.log(wanted * 64), None
        for _ in range(self.options.steps):
            middle = (low + high) / 2
            found = self.measure(*words, "--target-error", f"{math.exp(middle):.6g}")
            if found[0] <= wanted:
                low, best = middle, found
            else:
                high = middle
        return best

    def compare(self, name):
        subprocess.run([self.options.program, "convert", "error:" + name, self.scene], check=True,
                       stdout=subprocess.DEVNULL)
        self.truth = self.render(1000, "--spp", str(self.options.reference))[0]
        start = min(self.render(1, "--spp", "1", "--crop", "0,0,1,1")[2] for _ in range(3))
        cells = []
        for samples in self.options.samples:
            error, count, seconds = self.measure("--spp", str(samples))
            found = self.to_error(error, samples)
            if not found:
                cells.append("-")
                continue
            ratio = (found[2] - start) / max(seconds - start, 1e-3)
            cells.append(f"{found[1] / count:.2f} ({ratio:.2f})")
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--samples", nargs="+", type=int, default=[4, 8, 16, 32])
    parser.add_argument("--size", default="96x64")
    parser.add_argument("--least", type=float, default=0.5, help="--min-spp, in counts")
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--steps", type=int, default=10, help="halvings of the target error")
    parser.add_argument("--reference", type=int, default=4096)
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(parser.parse_args(), folder)
        print("samples (seconds) over those of uniform sampling\n| scene | "
              + " | ".join(map(str, bench.options.samples)) + " |")
        for scene in bench.options.scenes:
            bench.compare(scene)


if __name__ == "__main__":
    main()
