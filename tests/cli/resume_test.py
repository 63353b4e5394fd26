#!/usr/bin/env python3
"""Coordinators that are killed or interrupted: with --resume no kept tile is traced again."""
import random
import signal
import time

import scenes
from tessera_process import SLOWER, TesseraTest, wait_until

LOAD = ["--size", "320x240", "--tile", "16", "--spp"]
TILES = 300


class Resume(TesseraTest):
    spp = 8

    def setUp(self):
        super().setUp()
        self.scene = self.write("scene.tessera", scenes.glass_scene())
        self.reference = self.render(self.scene, "--workers", "0", *LOAD, self.spp)
        self.kept = self.folder / "picture.png.tiles"

    def start_render(self, workers):
        return self.start("render", self.scene, "-o", "picture.png", "--stats", "stats.json",
                          "--workers", workers, "--resume", *LOAD, self.spp)

    def end_after(self, process, seconds, sent):
        """Sends the signal, after so long and once a tile is kept; the exit code."""
        wal = self.folder / "picture.png.tiles-wal"
        wait_until(lambda: process.poll() is not None or
                   (wal.exists() and wal.stat().st_size > 64 << 10), 10, "tiles are kept")
        time.sleep(seconds * SLOWER)
        process.send_signal(sent)
        process.communicate(timeout=60)
        return process.returncode

    def finish(self):
        (self.folder / "stats.json").unlink(missing_ok=True)
        process = self.start_render(2)
        _, err = process.communicate(timeout=200)
        self.assertEqual(0, process.returncode, err)
        stats = self.stats()
        self.assertEqual(self.reference["pixels_sha256"], stats["pixels_sha256"])
        self.assertEqual(self.reference["rays"], stats["rays"])
        self.assertEqual(TILES, stats["tiles"]["done"])
        self.assertEqual([], [p.name for p in self.folder.glob("*.tiles*")])
        return stats["tiles"]["restored"]

    def test_after_kills_at_any_moment(self):
        resumed = 0
        for seed in range(6):
            with self.subTest(seed=seed):
                chance = random.Random(seed)
                for _ in range(1 + seed % 3):
                    process = self.start_render(seed % 3)
                    self.end_after(process, chance.uniform(0, 0.3), signal.SIGKILL)
                resumed += self.finish() > 0
        self.assertGreaterEqual(resumed, 3)

    def test_after_an_interrupt_it_tells_what_is_kept(self):
        self.spp = 64
        self.reference = self.render(self.scene, "--workers", "0", *LOAD, self.spp)
        process = self.start_render(2)
        wait_until(self.kept.exists, 10, "tiles are kept")
        time.sleep(0.2 * SLOWER)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
        self.assertEqual(4, process.returncode, err)
        told = int(err.split(f" of {TILES} tiles are kept")[0].split()[-1])
        self.assertEqual(told, self.finish())

    def test_another_scene_starts_anew(self):
        self.end_after(self.start_render(2), 0.2, signal.SIGKILL)
        self.scene = self.write("scene.tessera", scenes.glass_scene().replace("0.9", "0.8"))
        self.reference = self.render(self.scene, "--workers", "0", *LOAD, self.spp)
        self.assertEqual(0, self.finish())

    def test_a_file_of_something_else_is_refused_and_kept(self):
        self.kept.write_bytes(b"diary " * 1000)
        result = self.run_program("render", self.scene, *LOAD, self.spp, "-o", "picture.png", "--resume")
        self.assert_error(result, 2, "file of finished tiles")
        self.assertEqual(6000, self.kept.stat().st_size)
