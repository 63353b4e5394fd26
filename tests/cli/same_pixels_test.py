#!/usr/bin/env python3
"""The picture is the same to the last bit however the work is cut and whoever does it."""
import concurrent.futures
import json
import os
import pathlib
import subprocess
import unittest

import scenes
from tessera_process import PROGRAM, SLOWER, TesseraTest, nightly

SAMPLES = pathlib.Path(__file__).parents[2] / "scenes/samples"
WIDTH, HEIGHT = 72, 50  # no multiple of any tile
WORKERS = [0, 1, 2, 3, 4, 8]
THREADS = [1, 2, 4]
TILES = [8, 16, 48, 64, max(WIDTH, HEIGHT)]
if SLOWER > 1:  # sanitizers look at the code, not at the combinations
    WORKERS, THREADS, TILES = [0, 1, 4], [1, 4], [8, 48]


class SamePixels(TesseraTest):
    workers_for_paths = [0, 3]  # each makes tables of rough glass before it begins

    def combined(self, workers, threads, tiles):
        """Each pair of two of them, in as few renders as that takes."""
        return [(w, threads[(i + j) % len(threads)], tile)
                for i, w in enumerate(workers) for j, tile in enumerate(tiles)]

    def digest(self, scene, options, size=(WIDTH, HEIGHT)):
        """The (pixels_sha256, counts that may not depend on the cut) of one render."""
        name = "-".join(map(str, options)).replace("--", "")
        result = subprocess.run(
            [PROGRAM, "render", scene, "-o", f"{name}.png", "--stats", f"{name}.json", "--quiet",
             "--size", "x".join(map(str, size)), *map(str, options)],
            cwd=self.folder, env=self.environment(), capture_output=True, text=True,
            timeout=120 * SLOWER)
        self.assertEqual((0, ""), (result.returncode, result.stderr), name)
        stats = json.loads((self.folder / f"{name}.json").read_text())
        self.assertEqual(stats["tiles"]["total"], stats["tiles"]["done"], name)
        self.assertEqual(0, stats["tiles"]["mismatches"], name)
        return stats["pixels_sha256"], stats["rays"], stats["hits"]

    def assert_all_equal(self, text, *sampling, workers=WORKERS, threads=THREADS):
        scene = self.write("scene.tessera", text)
        ways = [("--workers", w, "--threads", t, "--tile", tile, *sampling)
                for w, t, tile in self.combined(workers, threads, TILES)]
        reference = self.digest(scene, ("--workers", 0, "--threads", 1, "--accel", "linear",
                                        *sampling))
        self.assertGreater(reference[2], WIDTH * HEIGHT / 2, "the picture shows next to nothing")
        with concurrent.futures.ThreadPoolExecutor(max(2, os.cpu_count() // 2)) as pool:
            for way, found in zip(ways, pool.map(lambda way: self.digest(scene, way), ways)):
                self.assertEqual(reference, found, way)

    def test_a_mesh(self):
        self.assert_all_equal(scenes.mesh_scene(rings=12, segments=24))

    def test_mirror_and_glass(self):
        self.assert_all_equal(scenes.glass_scene())

    def test_paths(self):
        self.assert_all_equal(scenes.paths_scene(), workers=self.workers_for_paths)

    def test_many_lights(self):
        self.assert_all_equal(scenes.lights_scene())

    def test_as_many_samples_as_it_takes(self):
        self.assert_all_equal(scenes.glass_scene(), "--target-error", ".05", "--spp", 40, "--filter",
                              "mitchell", workers=[0, 3], threads=[2])

    def test_cost(self):
        """Two meshes, of which rays come near one before the other."""
        scene = self.write("scene.tessera", scenes.two_meshes_scene())
        options = ("--integrator", "cost", "--spp", 4)
        ways = [("--workers", w, "--threads", t, "--tile", tile, *options)
                for w in (0, 3) for t in (1, 3) for tile in (8, 16, max(WIDTH, HEIGHT))]
        ways.append(("--workers", 3, "--verify", "100%", *options))
        found = {way: self.digest(scene, way)[0] for way in ways}
        self.assertEqual(1, len(set(found.values())), found)

    @nightly
    def test_cost_on_other_machines(self):
        """Of a scene whose visits differ where products are not rounded before they are summed."""
        scene = SAMPLES / "knot.tessera"
        options = ("--integrator", "cost", "--workers", 0, "--threads", 1)
        found = {}
        self.addCleanup(os.environ.pop, "TESSERA_SIMD", None)
        for simd in ("SCALAR", "SSE4", "AVX2", "AVX3"):
            os.environ["TESSERA_SIMD"] = simd
            asked = self.start("render", scene, "--size", "1x1", "--workers", "0", "-o", "x.png")
            if asked.wait(60 * SLOWER) == 0:
                found[simd] = self.digest(scene, options, (480, 270))[0]
        self.assertIn("SCALAR", found)
        self.assertEqual(1, len(set(found.values())), found)

    def test_other_settings_give_other_pixels(self):
        """That the digests could differ at all."""
        scene = self.write("scene.tessera", scenes.lights_scene())
        digests = {self.digest(scene, options)[0]
                   for options in [("--spp", 1), ("--spp", 4), ("--spp", 4, "--seed", 1),
                                   ("--camera", "side"), ("--spp", 4, "--filter", "mitchell"),
                                   ("--spp", 4, "--filter", "mitchell:1.5"),
                                   ("--spp", 4, "--pattern", "blue-noise"),
                                   ("--target-error", ".1", "--spp", 64)]}
        self.assertEqual(8, len(digests))


class Crop(TesseraTest):
    def test_a_crop_has_the_pixels_of_the_whole(self):
        scene = self.write("scene.tessera", scenes.glass_scene())
        self.render(scene, "-o", "whole.pfm", "--size", "60x40", "--spp", "4")
        self.render(scene, "-o", "crop.pfm", "--size", "60x40", "--spp", "4", "--crop", "13,7,41,30")
        whole, crop = self.pixels("whole.pfm"), self.pixels("crop.pfm")
        self.assertEqual((28, 23), (len(crop[0]), len(crop)))
        self.assertEqual([row[13:41] for row in whole[7:30]], crop)

    def pixels(self, name):
        """Rows from the top, each a list of 12-byte pixels."""
        header, size, _, data = (self.folder / name).read_bytes().split(b"\n", 3)
        self.assertEqual(b"PF", header)
        width, height = map(int, size.split())
        rows = [[data[12 * (y * width + x):][:12] for x in range(width)] for y in range(height)]
        return rows[::-1]  # the file has the bottom row first


if __name__ == "__main__":
    unittest.main()
