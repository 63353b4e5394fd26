#!/usr/bin/env python3
"""Channels beside light: there, right, and the same bits whoever traced them."""
import os
import signal
import unittest

import scenes
from exr import read_exr
from service_test import ServiceTest
from tessera_process import PATIENCE, is_worker, marked_processes, wait_until

SIZE = ["--size", "70x45"]
CHANNELS = {"albedo": ["albedo.R", "albedo.G", "albedo.B"], "normal": ["N.X", "N.Y", "N.Z"],
            "depth": ["Z"], "position": ["P.X", "P.Y", "P.Z"], "id": ["id"],
            "variance": ["variance.R", "variance.G", "variance.B"], "samples": ["samples"]}
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

    def test_after_a_killed_worker(self):
        load = ["--size", "320x240", "--tile", "16", "--spp", 32, "--aovs", "all"]
        reference = self.channels(*load, "--workers", 0)
        process = self.start("render", self.scene, *load, "--workers", 3, "-o", "b.exr", "--quiet",
                             "--resume")
        kept = self.folder / "b.exr.tiles-wal"
        wait_until(lambda: process.poll() is not None or
                   (kept.exists() and kept.stat().st_size > 100_000), "tiles are kept")
        for worker in marked_processes(self.mark):
            if worker != process.pid and is_worker(worker):
                os.kill(worker, signal.SIGKILL)
                break
        _, err = process.communicate(timeout=PATIENCE)
        self.assertEqual(0, process.returncode, err)
        found = {c: v.tobytes() for c, v in read_exr(self.folder / "b.exr")[1].items()}
        self.assertEqual(reference[0], found)

    def test_after_a_killed_run(self):
        load = ["--size", "320x240", "--tile", "16", "--spp", 32, "--aovs", "albedo,depth,samples"]
        reference = self.channels(*load, "--workers", 0)
        process = self.start("render", self.scene, *load, "--workers", 2, "-o", "b.exr", "--quiet",
                             "--resume")
        kept = self.folder / "b.exr.tiles-wal"
        wait_until(lambda: process.poll() is not None or
                   (kept.exists() and kept.stat().st_size > 100_000), "tiles are kept")
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
        self.channels(*options, "--integrator", "error", name="error.exr")
        error = read_exr(self.folder / "error.exr")[1]["G"]
        self.channels(*options, "--aovs", "variance", name="variance.exr")
        variance = read_exr(self.folder / "variance.exr")[1]
        for i, value in enumerate(error):
            mean = sum(variance[f"variance.{channel}"][i] for channel in "RGB") / 3
            self.assertAlmostEqual(mean ** .5, value, delta=1e-6 + 1e-5 * value)


if __name__ == "__main__":
    unittest.main()
