#!/usr/bin/env python3
"""What the program may replace, and what it leaves where it cannot write."""
import os
import pathlib
import resource
import shutil
import stat
import subprocess
import time
import unittest

import scenes
from tessera_process import PATIENCE, PROGRAM, SLOWER, Result, TesseraTest, wait_until

SMALL = ["--size", "96x96", "--workers", "0", "--threads", "1"]
ENDINGS = ["png", "exr", "jpg", "bmp", "tif", "tga", "ppm", "webp", "hdr", "pfm", "sgi"]


class OutputFiles(TesseraTest):
    def setUp(self):
        super().setUp()
        self.scene = self.write("scene.tessera", scenes.ONE_SPHERE)

    def commands(self, place):
        """Every way to name a file to write."""
        yield "render", self.scene, *SMALL, "--stats", place
        if str(place).endswith(".png"):
            yield "render", self.scene, *SMALL, "-o", place
        if str(place).endswith(".json"):
            yield "convert", self.scene, place

    def test_a_fifo_is_never_replaced(self):
        for name in ("pipe.png", "pipe.json"):
            os.mkfifo(self.folder / name)
            os.symlink(name, self.folder / f"link-{name}")
            for place in (name, f"link-{name}"):
                for command in self.commands(place):
                    with self.subTest(command=command):
                        self.assert_error(self.run_program(*command), 2, place, "no regular file")
            self.assertTrue(stat.S_ISFIFO(os.lstat(self.folder / name).st_mode))

    def test_a_link_is_kept_and_its_target_replaced(self):
        for name in ("real.png", "real.json"):
            for command in self.commands(f"link-{name}"):
                with self.subTest(command=command):
                    (self.folder / "sub").mkdir(exist_ok=True)
                    self.write(f"sub/{name}", "old")
                    if not os.path.lexists(self.folder / f"link-{name}"):
                        os.symlink(f"sub/{name}", self.folder / f"link-{name}")
                    self.assertEqual(0, self.run_program(*command).code)
                    self.assertTrue((self.folder / f"link-{name}").is_symlink())
                    self.assertNotEqual(b"old", (self.folder / f"sub/{name}").read_bytes())

    def test_frames_go_on_however_long_one_takes_to_write(self):
        """Meanwhile the thread that traces hears nothing of its coordinator."""
        programs = self.folder / "bin"
        programs.mkdir()
        for file in pathlib.Path(PROGRAM).resolve().parent.glob("tessera*"):
            shutil.copy(file, programs)
        codec = programs / "tessera-image-codec"
        codec.rename(programs / "codec")
        codec.write_text(f"#!/bin/sh\nmkdir '{self.folder}/slept' 2>/dev/null && sleep 63\n"
                         f"exec '{programs}/codec' \"$@\"\n")
        codec.chmod(0o755)
        done = subprocess.run([programs / "tessera", "render", self.scene, *SMALL, "--frames", "0-2", "-o", "f.exr"],
                              cwd=self.folder, env=self.environment(), capture_output=True, text=True,
                              timeout=PATIENCE + 63)
        self.assertEqual(0, done.returncode, done.stderr)
        self.assertNotIn("lost worker", done.stderr)
        self.assertEqual(3, len(list(self.folder.glob("f*.exr"))), done.stderr)
        self.assertTrue((self.folder / "slept").exists())

    def test_a_link_to_nothing_yet(self):
        os.symlink("new.png", self.folder / "link.png")
        self.assertEqual(0, self.run_program("render", self.scene, *SMALL, "-o", "link.png").code)
        self.assertTrue((self.folder / "link.png").is_symlink())
        self.assertTrue((self.folder / "new.png").read_bytes().startswith(b"\x89PNG"))

    def test_a_link_to_itself(self):
        os.symlink("loop.png", self.folder / "loop.png")
        for command in self.commands("loop.png"):
            self.assert_error(self.run_program(*command), 2, "loop.png")

    def test_a_file_that_does_not_fit_leaves_the_old_one(self):
        def few_bytes():
            resource.setrlimit(resource.RLIMIT_FSIZE, (512, resource.RLIM_INFINITY))

        for ending in ENDINGS:
            with self.subTest(ending=ending):
                self.write(f"old.{ending}", "old")
                process = self.start("render", self.scene, *SMALL, "-o", f"old.{ending}",
                                     preexec_fn=few_bytes)
                out, err = process.communicate(timeout=PATIENCE)
                self.assert_error(Result(process.returncode, out, err), 3, f"old.{ending}",
                                  "File too large")
                self.assertEqual(b"old", (self.folder / f"old.{ending}").read_bytes())

    def test_readers_that_leave_early(self):
        for stream in ("stderr", "stdout"):
            with self.subTest(stream=stream):
                (self.folder / "picture.png").unlink(missing_ok=True)
                reader, writer = os.pipe()
                os.close(reader)
                process = self.start("render", self.scene, "--size", "640x480", "--spp", str(int(400 / SLOWER)),
                                     "--tile", "16", "--workers", "2", "-o", "picture.png",
                                     **{stream: writer})
                os.close(writer)
                process.communicate(timeout=PATIENCE)
                self.assertEqual(0, process.returncode)
                self.assertTrue((self.folder / "picture.png").exists())

    def test_the_same_file_twice(self):
        os.symlink("a.png", self.folder / "b.png")
        for files in (["-o", "a.png", "-o", "./a.png"], ["-o", "a.png", "-o", "b.png"],
                      ["-o", "a.png", "--stats", "a.png"]):
            with self.subTest(files=files):
                self.assert_error(self.run_program("render", self.scene, *SMALL, *files), 2, "twice")

    def test_what_is_read_is_never_written(self):
        self.assertEqual(0, self.run_program("convert", self.scene, "scene.json").code)
        scene = self.folder / "scene.json"
        before = scene.read_bytes()
        os.symlink("scene.json", self.folder / "link.json")
        os.link(scene, self.folder / "hard.json")
        for place in ("scene.json", "./tmp/../scene.json", "link.json", "hard.json"):
            for command in (("convert", scene, place), ("render", scene, *SMALL, "--stats", place)):
                with self.subTest(command=command):
                    self.assert_error(self.run_program(*command), 2, place, "the file that is read")
                    self.assertEqual(before, scene.read_bytes())

    def test_an_interrupted_animation_tells_how_far_it_came(self):
        process = self.start("render", self.scene, "--size", "64x64", "--spp", "64", "--frames",
                             "1-5000", "-o", "anim.png", "--workers", "1")
        wait_until(lambda: (self.folder / "anim.0002.png").exists(), "two frames")
        process.terminate()
        _, err = process.communicate(timeout=PATIENCE)
        self.assertEqual(4, process.returncode)
        frames = len(list(self.folder.glob("anim.*.png")))
        self.assertIn(f"{frames} of 5000 frames", err)


if __name__ == "__main__":
    unittest.main()
