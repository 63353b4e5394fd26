#!/usr/bin/env python3
"""Coordinators that are killed or interrupted: with --resume no kept tile is traced again."""
import contextlib
import random
import shutil
import signal
import sqlite3

import scenes
from tessera_process import PATIENCE, TesseraTest, nightly, wait_until

LOAD = ["--size", "320x240", "--tile", "16", "--spp"]
TILES = 300


class Resume(TesseraTest):
    def setUp(self):
        super().setUp()
        self.scene = self.write("scene.tessera", scenes.glass_scene())
        self.kept = self.folder / "picture.png.tiles"
        self.log = self.folder / "picture.png.tiles-wal"
        self.load(8)

    def load(self, spp):
        self.spp = spp
        self.reference = self.render(self.scene, "--workers", "0", *LOAD, spp)

    def start_render(self, workers):
        return self.start("render", self.scene, "-o", "picture.png", "--stats", "stats.json",
                          "--workers", workers, "--resume", *LOAD, self.spp)

    def kept_tiles(self):
        """How many of this picture, told by a copy: a look at the file itself would change it."""
        for file in self.folder.glob(self.kept.name + "*"):
            shutil.copy(file, self.temporary)
        with contextlib.closing(sqlite3.connect(self.temporary / self.kept.name)) as copy:
            jobs = copy.execute("SELECT count(*) FROM tiles GROUP BY job ORDER BY max(rowid)").fetchall()
        for file in self.temporary.glob("*.tiles*"):
            file.unlink()
        return jobs[-1][0] if jobs else 0

    def end_midway(self, workers, log_bytes, sent):
        """Sends the signal once the store's log has grown so long and some tiles, but not all, are
        kept; how many are, and what was said."""
        while True:
            process = self.start_render(workers)
            wait_until(lambda: process.poll() is not None or
                       (self.log.exists() and self.log.stat().st_size >= log_bytes), "tiles are kept")
            process.send_signal(sent)
            _, err = process.communicate(timeout=PATIENCE)
            if process.returncode != 0 and (tiles := self.kept_tiles()) > 0:
                self.assertIn(process.returncode, (4, -signal.SIGKILL), err)
                return tiles, err
            if process.returncode == 0:
                self.load(2 * self.spp)  # that was too little for us to be in time

    def finish(self):
        restored, _ = self.finish_beside_others()
        self.assertEqual([], [p.name for p in self.folder.glob("*.tiles*")])
        return restored

    def finish_beside_others(self):
        (self.folder / "stats.json").unlink(missing_ok=True)
        process = self.start_render(2)
        out, err = process.communicate(timeout=PATIENCE)
        self.assertEqual(0, process.returncode, err)
        stats = self.stats()
        restored = stats["tiles"]["restored"]
        self.assertEqual(restored > 0, f", {restored} kept from an earlier run, " in out, out)
        self.assertEqual(self.reference["pixels_sha256"], stats["pixels_sha256"])
        self.assertEqual(self.reference["rays"], stats["rays"])
        self.assertEqual(TILES, stats["tiles"]["done"])
        return stats["tiles"]["restored"], err

    @nightly
    def test_after_kills_at_any_moment(self):
        for seed in range(6):
            with self.subTest(seed=seed):
                chance = random.Random(seed)
                for _ in range(1 + seed % 3):
                    size = chance.uniform(30_000, 300_000)
                    kept, _ = self.end_midway(seed % 3, size, signal.SIGKILL)
                self.assertEqual(kept, self.finish())

    def test_after_an_interrupt_it_tells_what_is_kept(self):
        kept, err = self.end_midway(2, 100_000, signal.SIGINT)
        self.assertIn(f"{kept} of {TILES} tiles are kept", err)
        self.assertEqual(kept, self.finish())

    def test_another_scene_starts_anew_and_takes_nothing_from_the_first(self):
        kept, _ = self.end_midway(2, 100_000, signal.SIGKILL)
        first = self.scene
        self.scene = self.write("other.tessera", scenes.glass_scene().replace("0.9", "0.8"))
        self.load(self.spp)
        restored, err = self.finish_beside_others()
        self.assertEqual(0, restored)
        self.assertIn(f"{kept} tiles of other scenes or settings stay in", err)
        self.scene = first
        self.load(self.spp)
        self.assertEqual(kept, self.finish())

    def test_no_file_is_made_for_a_scene_that_is_missing(self):
        result = self.run_program("render", "missing.stl", "--resume", "-o", "missing.png")
        self.assert_error(result, 1, "missing.stl: no such file")
        self.assertEqual([], list(self.folder.glob("missing*")))

    def test_a_file_of_something_else_is_refused_and_kept(self):
        self.kept.write_bytes(b"diary " * 1000)
        result = self.run_program("render", self.scene, *LOAD, self.spp, "-o", "picture.png", "--resume")
        self.assert_error(result, 2, "file of finished tiles")
        self.assertEqual(6000, self.kept.stat().st_size)
