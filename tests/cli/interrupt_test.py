#!/usr/bin/env python3
"""Ctrl-C, SIGTERM and SIGHUP: once stops cleanly, twice at once; nothing is left behind."""
import os
import signal
import time
import unittest

import scenes
from tessera_process import (PATIENCE, TesseraTest, catches, is_worker, marked_processes,
                             wait_until)

LONG = ["--size", "1600x1200", "--spp", "4096"]


class Interrupt(TesseraTest):
    def setUp(self):
        super().setUp()
        self.scene = self.write("scene.tessera", scenes.glass_scene())

    def wait_for_workers(self, count):
        """Other processes may encode pictures."""
        wait_until(lambda: sum(map(is_worker, marked_processes(self.mark))) == count, "all run")

    def start_long_render(self, workers):
        process = self.start("render", self.scene, "-o", "picture.png", "--stats", "stats.json",
                             "--workers", workers, *LONG)
        self.wait_for_workers(workers)
        wait_until(lambda: catches(process, signal.SIGTERM), "signals are caught")
        time.sleep(0.4)
        return process

    def assert_interrupted(self, process):
        out, err = process.communicate(timeout=PATIENCE)
        self.assertEqual(4, process.returncode, err)
        wait_until(lambda: not marked_processes(self.mark), "no process is left")
        self.assertEqual(["scene.tessera", "tmp"], sorted(p.name for p in self.folder.iterdir()))
        return err

    def test_once(self):
        for sent in [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]:
            for workers in [0, 3]:
                with self.subTest(signal=sent.name, workers=workers):
                    process = self.start_long_render(workers)
                    process.send_signal(sent)
                    self.assertIn("interrupted; no picture was written; no tile was kept: --resume",
                                  self.assert_interrupted(process))

    def test_from_the_terminal_it_reaches_all(self):
        """Ctrl-C goes to the whole process group, workers included."""
        process = self.start("render", self.scene, "-o", "picture.png", "--workers", 3, *LONG,
                             start_new_session=True)
        self.wait_for_workers(3)
        time.sleep(0.3)
        os.killpg(process.pid, signal.SIGINT)
        self.assertIn("interrupted", self.assert_interrupted(process))

    def test_a_terminal_that_closes_may_tell_twice(self):
        process = self.start_long_render(1)
        process.send_signal(signal.SIGHUP)
        process.send_signal(signal.SIGHUP)
        self.assertIn("interrupted; no picture was written", self.assert_interrupted(process))

    def test_what_outlives_its_terminal(self):
        """As nohup starts it."""
        process = self.start("render", self.scene, "-o", "picture.png", "--workers", 1, "--size", "64x64",
                             preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
        wait_until(lambda: catches(process, signal.SIGTERM), "signals are caught")
        process.send_signal(signal.SIGHUP)
        process.communicate(timeout=PATIENCE)
        self.assertEqual(0, process.returncode)

    def test_twice(self):
        process = self.start_long_render(3)
        process.send_signal(signal.SIGINT)
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=PATIENCE)
        self.assertEqual(4, process.returncode)
        wait_until(lambda: not marked_processes(self.mark), "no process is left")
        self.assertFalse((self.folder / "picture.png").exists())

    def test_twice_at_any_moment_leaves_no_file(self):
        for i in range(24):
            process = self.start("render", self.scene, "-o", "picture.png", "-o", "picture.exr",
                                 "--size", "64x64", "--workers", 1 + i % 2)
            wait_until(lambda: catches(process, signal.SIGTERM), "signals are caught")
            time.sleep(0.012 * i)
            process.send_signal(signal.SIGINT)
            time.sleep(0.001 * (i % 4))
            process.send_signal(signal.SIGTERM)
            process.communicate(timeout=PATIENCE)
            self.assertIn(process.returncode, (0, 4))
            wait_until(lambda: not marked_processes(self.mark), "no process is left")
            self.assertEqual([], list(self.temporary.iterdir()), i)
            self.assertEqual([], list(self.folder.glob(".tessera*")), i)

    def test_a_command_that_has_nothing_to_finish_ends_at_once(self):
        for arguments in [("convert", "forest:300000", "forest.json"), ("info", self.scene),
                          ("bench", "precision")]:
            with self.subTest(arguments=arguments):
                process = self.start(*arguments)
                wait_until(lambda: process.poll() is not None or catches(process, signal.SIGINT),
                           "signals are caught")
                process.send_signal(signal.SIGINT)
                process.communicate(timeout=PATIENCE)
                self.assertIn(process.returncode, (4, 0) if arguments[0] == "info" else (4,))

    def test_while_another_program_takes_its_place(self):
        for i in range(40):
            process = self.start("bench", "precision")
            wait_until(lambda: catches(process, signal.SIGINT), "signals are caught")
            time.sleep(0.0002 * i)
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=PATIENCE)
            self.assertEqual(4, process.returncode)

    def test_once_while_a_traced_picture_is_denoised_or_written(self):
        scene = self.write("scene.tessera", "background { solid { r: 1 g: 1 b: 1 } } nodes { shape { sphere {} } }")
        for options in [("picture.png", "--denoise", "--size", "2400x1800", "--spp", 2),
                        ("picture.exr", "--size", "6000x6000", "--spp", 1)]:
            with self.subTest(options=options):
                process = self.start("render", scene, "-o", *options, "--workers", 1)
                self.wait_for_workers(1)
                self.wait_for_workers(0)  # which ends once all is traced
                process.send_signal(signal.SIGINT)
                self.assertIn("interrupted; no picture was written", self.assert_interrupted(process))

    def test_while_it_waits_for_workers(self):
        serve = self.start("serve", "--bind", "tcp://127.0.0.1:*")
        endpoint = serve.stdout.readline().split()[-1]
        process = self.start("render", self.scene, "-o", "picture.png", "--connect", endpoint, *LONG)
        wait_until(lambda: catches(process, signal.SIGINT), "signals are caught")
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=PATIENCE)
        self.assertEqual(4, process.returncode)
        serve.send_signal(signal.SIGINT)
        self.assertEqual(0, serve.wait(PATIENCE))


if __name__ == "__main__":
    unittest.main()
