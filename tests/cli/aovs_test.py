#!/usr/bin/env python3
"""Channels beside light: there, right, and the same bits whoever traced them."""
import os
import signal
import unittest

import scenes
from exr import read_exr
from service_test import ServiceTest
from tessera_process import PATIENCE, is_worker, marked_processes, nightly, wait_until

SIZE = ["--size", "70x45"]
CHANNELS = {"albedo": ["albedo.R", "albedo.G", "albedo.B"], "normal": ["N.X", "N.Y", "N.Z"],
            "depth": ["Z"], "position": ["P.X", "P.Y", "P.Z"], "id": ["id"],
            "variance": ["variance.R", "variance.G", "variance.B"], "samples": ["samples"],
            "origin": [f"origin.{i}" for i in range(8)], "primitive": ["primitive"]}
ALL = [channel for channels in CHANNELS.values() for channel in channels]


class Aovs(ServiceTest):
    def setUp(self):
        super().setUp()
        self.scene = self.write("scene.tessera", scenes.glass_scene())

    def channels(self, *options, scene=None, name="a.exr"):
        """All channels of a picture, as bytes, and the digest of its light."""
        result = self.run_program("render", scene or self.scene, "-o", name, "--stats", "stats.json",
                                  *options)
        self.assertEqual(0, result.code, result.err)
        found = read_exr(self.folder / name)[1]
        return ({channel: values.tobytes() for channel, values in found.items()},
                self.stats()["pixels_sha256"])

    def test_light_keeps_its_bits_and_only_what_is_asked_for_is_there(self):
        plain, digest = self.channels(*SIZE, "--spp", 4, "--workers", 0)
        self.assertEqual({"R", "G", "B"}, set(plain))
        for name, expected in CHANNELS.items():
            found, same = self.channels(*SIZE, "--spp", 4, "--workers", 0, "--aovs", name)
            self.assertEqual({"R", "G", "B", *expected}, set(found))
            self.assertEqual(digest, same)
            self.assertEqual(plain, {channel: found[channel] for channel in "RGB"})
            self.assertTrue(any(any(found[channel]) for channel in expected), name)

    def test_the_same_bits_however_it_is_cut(self):
        for sampling in (["--spp", 5, "--filter", "mitchell"],
                         ["--spp", 64, "--target-error", ".01"]):
            options = [*SIZE, *sampling, "--aovs", "all"]
            reference = self.channels(*options, "--workers", 0, "--threads", 1, "--tile", 64)
            self.assertEqual({"R", "G", "B", *ALL}, set(reference[0]))
            for workers, threads, tile in ((0, 2, 8), (1, 1, 5), (3, 2, 16), (2, 1, 70)):
                found = self.channels(*options, "--workers", workers, "--threads", threads, "--tile",
                                      tile)
                self.assertEqual(reference, found, (workers, threads, tile))

    def start_and_keep_some(self, load, workers):
        """A render to b.exr that has kept some tiles."""
        process = self.start("render", self.scene, *load, "--workers", workers, "-o", "b.exr",
                             "--quiet", "--resume")
        kept = self.folder / "b.exr.tiles-wal"
        wait_until(lambda: process.poll() is not None or
                   (kept.exists() and kept.stat().st_size > 100_000), "tiles are kept")
        return process

    @nightly
    def test_after_a_killed_worker(self):
        load = ["--size", "320x240", "--tile", "16", "--spp", 12, "--aovs", "all"]
        reference = self.channels(*load, "--workers", 0)
        process = self.start_and_keep_some(load, 3)
        for worker in marked_processes(self.mark):
            if worker != process.pid and is_worker(worker):
                os.kill(worker, signal.SIGKILL)
                break
        _, err = process.communicate(timeout=PATIENCE)
        self.assertEqual(0, process.returncode, err)
        found = {c: v.tobytes() for c, v in read_exr(self.folder / "b.exr")[1].items()}
        self.assertEqual(reference[0], found)

    def test_after_a_killed_run(self):
        load = ["--size", "320x240", "--tile", "16", "--spp", 12, "--aovs", "albedo,depth,samples"]
        reference = self.channels(*load, "--workers", 0)
        process = self.start_and_keep_some(load, 2)
        process.kill()
        process.communicate(timeout=PATIENCE)
        found = self.channels(*load, "--workers", 2, "--resume", name="b.exr")
        self.assertEqual(reference, found)

    def test_from_a_farm(self):
        options = [*SIZE, "--spp", 4, "--aovs", "all"]
        reference = self.channels(*options, "--workers", 0)
        service, worker = self.serve(), self.worker()
        self.assertEqual(reference,
                         self.channels(*options, "--connect", self.endpoint, name="b.exr"))
        job = int(self.ask("submit", self.scene, *options))
        self.ask("fetch", job, "--wait", "-o", "c.exr", "-o", "c.png")
        found = {c: v.tobytes() for c, v in read_exr(self.folder / "c.exr")[1].items()}
        self.assertEqual(reference[0], found)
        self.stop(service, worker)

    def test_formats_without_room_for_them(self):
        for outputs in ([], ["-o", "a.png"], ["-o", "a.hdr", "-o", "a.pfm"]):
            self.assert_error(self.run_program("render", self.scene, "--aovs", "depth", *outputs), 2,
                              "--aovs", ".exr")
        both, _ = self.channels(*SIZE, "--aovs", "depth", "--workers", 0, "-o", "a.png")
        self.assertIn("Z", both)
        self.assertTrue((self.folder / "a.png").exists())
        self.assert_error(self.run_program("render", self.scene, "--aovs", "dept", "-o", "a.exr"), 2,
                          "'dept'", "did you mean 'depth'")
        self.assert_error(self.run_program("render", self.scene, "--aovs", "all", "--tile", "65536",
                                           "--size", "20000x1", "-o", "a.exr"), 2, "tiles of 65536")

    def test_views_of_how_it_was_found(self):
        options = [*SIZE, "--spp", 64, "--target-error", ".01", "--workers", 0]
        beside, _ = self.channels(*options, "--aovs", "samples,variance")
        samples, _ = self.channels(*options, "--integrator", "samples")
        self.assertEqual({beside["samples"]}, {samples[channel] for channel in "RGB"})
        counts = set(read_exr(self.folder / "a.exr")[1]["R"])
        self.assertTrue({16} < counts <= {16, 32, 64}, counts)
        everywhere = [*SIZE, "--spp", 16, "--workers", 0]
        self.channels(*everywhere, "--integrator", "error", name="error.exr")
        error = read_exr(self.folder / "error.exr")[1]["G"]
        self.channels(*everywhere, "--aovs", "variance", name="variance.exr")
        variance = read_exr(self.folder / "variance.exr")[1]
        for i, value in enumerate(error):
            mean = sum(variance[f"variance.{channel}"][i] for channel in "RGB") / 3
            self.assertAlmostEqual(mean ** .5, value, delta=1e-6 + 1e-5 * value)
        # To a target error it is what is claimed of samples that are better spread than by chance.
        self.channels(*everywhere, "--target-error", ".01", "--integrator", "error",
                      name="claimed.exr")
        claimed = read_exr(self.folder / "claimed.exr")[1]["G"]
        self.assertLess(0, sum(value * value for value in claimed))
        self.assertLess(sum(value * value for value in claimed),
                        .5 * sum(value * value for value in error))

    def test_denoising(self):
        options = [*SIZE, "--spp", 8, "--integrator", "path"]
        scene = self.write("paths.tessera", scenes.paths_scene())
        noisy, _ = self.channels(*options, "--workers", 0, scene=scene)
        reference = self.channels(*options, "--workers", 0, "--denoise", scene=scene)
        self.assertEqual({"R", "G", "B"}, set(reference[0]))
        self.assertNotEqual(noisy, reference[0])
        self.assertIn("tessera:Denoised", read_exr(self.folder / "a.exr")[0])
        for workers, tile in ((1, 8), (3, 16)):
            self.assertEqual(reference, self.channels(*options, "--workers", workers, "--tile", tile,
                                                      "--denoise", scene=scene))
        beside, _ = self.channels(*options, "--workers", 0, "--denoise", "--aovs", "samples,depth",
                                  scene=scene)
        self.assertEqual({"R", "G", "B", "Z", "samples"}, set(beside))
        self.assertEqual(reference[0], {channel: beside[channel] for channel in "RGB"})
        self.channels(*options, "--workers", 0, scene=scene)
        self.assertNotIn("tessera:Denoised", read_exr(self.folder / "a.exr")[0])
        self.assert_error(self.run_program("render", scene, "--denoise", "--spp", 1), 2, "--spp 2")
        service, worker = self.serve(), self.worker()
        job = int(self.ask("submit", scene, *options, "--aovs", "albedo,normal,depth,variance"))
        self.ask("fetch", job, "--wait", "--denoise", "-o", "b.pfm")
        self.run_program("render", scene, *options, "--workers", 0, "--denoise", "-o", "c.pfm")
        self.assertEqual((self.folder / "c.pfm").read_bytes(), (self.folder / "b.pfm").read_bytes())
        job = int(self.ask("submit", scene, *options))
        self.ask("fetch", job, "--wait", "--denoise", "-o", "d.pfm", code=2)
        job = int(self.ask("submit", scene, *SIZE, "--integrator", "path", "--spp", 1, "--aovs", "albedo,normal,depth,variance"))
        self.ask("fetch", job, "--wait", "--denoise", "-o", "d.pfm", code=2)
        self.stop(service, worker)

    def test_passes_end_in_the_same_picture(self):
        options = [*SIZE, "--spp", 20, "--aovs", "samples", "--workers", 2]
        reference = self.channels(*options)
        self.assertEqual(reference, self.channels(*options, "--progressive", name="b.exr"))

    def test_an_interrupt_leaves_the_last_pass(self):
        for spp in (4096, 16384, 65536):
            process = self.start("render", self.scene, *SIZE, "--spp", spp, "--aovs", "samples",
                                 "--workers", 2, "-o", "b.exr", "--quiet", "--progressive")
            wait_until(lambda: (self.folder / "b.exr").exists() or process.poll() is not None,
                       "a pass is written")
            process.send_signal(signal.SIGINT)
            _, err = process.communicate(timeout=PATIENCE)
            if process.returncode != 0:
                break
        self.assertEqual(4, process.returncode, err)
        found = read_exr(self.folder / "b.exr")[1]
        samples = int(found["samples"][0])
        self.assertIn(samples, [4 ** i for i in range(8)])
        self.assertIn(f"the picture has {samples} sample", err)
        expected, _ = self.channels(*SIZE, "--spp", samples, "--aovs", "samples", "--workers", 0,
                                    "--pattern", "owen-sobol")
        self.assertEqual(expected, {channel: values.tobytes() for channel, values in found.items()})


if __name__ == "__main__":
    unittest.main()
