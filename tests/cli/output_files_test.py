#!/usr/bin/env python3
"""What the program may replace, and what it leaves where it cannot write."""
import os
import resource
import stat
import unittest

import scenes
from tessera_process import Result, TesseraTest

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
                out, err = process.communicate(timeout=60)
                self.assert_error(Result(process.returncode, out, err), 3, f"old.{ending}",
                                  "File too large")
                self.assertEqual(b"old", (self.folder / f"old.{ending}").read_bytes())


if __name__ == "__main__":
    unittest.main()
