#!/usr/bin/env python3
"""Scenes whose building crashes workers: these go on, and two of them suffice to blame the scene."""
import os
import pathlib
import signal
import unittest

import scenes
from tessera_process import PATIENCE, TesseraTest, catches, wait_until

FRAME = ["--size", "160x120", "--tile", "16", "--spp", "2"]
DEADLY = 666  # the seed of frames that crash whoever builds them
CRASH = "building the scene ended the worker's process by signal 11 (SEGV)"


class Crashes(TesseraTest):
    def setUp(self):
        super().setUp()
        self.scene = self.write("scene.tessera", scenes.glass_scene())

    def serve(self, *options):
        self.coordinator = self.start("serve", "--bind", "tcp://127.0.0.1:*", *options)
        self.endpoint = self.coordinator.stdout.readline().split()[-1]

    def serve_with_keys(self, *names):
        for name in names:
            role = "submitter" if name == "alice" else "worker"
            self.assertEqual(0, self.run_program("keygen", f"{name}.key", "--role", role).code)
        self.assertEqual(0, self.run_program("keygen", "farm.key", "--role", "coordinator").code)
        self.write("farm.allow", "".join((self.folder / f"{name}.pub").read_text() for name in names))
        self.serve("--key", "farm.key", "--allow", "farm.allow")

    def as_(self, name=None):
        keys = ["--key", f"{name}.key", "--server-key", "farm.pub"] if name else []
        return ["--connect", self.endpoint, *keys]

    def worker(self, name, *connection):
        """Its log is in NAME.log."""
        with open(self.folder / f"{name}.log", "w") as log:
            return self.start("worker", *connection, "--threads", "2", "--crash-seed", DEADLY, stderr=log)

    def crashes(self, name):
        """The lines of its log that tell of crashes."""
        return [line for line in (self.folder / f"{name}.log").read_text().splitlines()
                if "the worker crashed" in line]

    def assert_renders(self, *connection):
        """A job of the farm, with the pixels that a process alone gives it."""
        alone = self.render(self.scene, "--workers", "0", *FRAME, "--seed", "1")
        farm = self.render(self.scene, *connection, *FRAME, "--seed", "1")
        self.assertEqual(alone["pixels_sha256"], farm["pixels_sha256"])
        self.assertEqual(0, farm["tiles"]["mismatches"])
        return farm

    def end_farm(self, *workers):
        """Told to end, they do, though they have crashed before."""
        for worker in workers:
            worker.send_signal(signal.SIGTERM)
            self.assertEqual(0, worker.wait(PATIENCE))
        self.coordinator.send_signal(signal.SIGTERM)
        self.assertEqual(0, self.coordinator.wait(PATIENCE))

    def test_two_keys_blame_the_scene_and_go_on(self):
        self.serve_with_keys("one", "two", "alice")
        workers = {name: self.worker(name, *self.as_(name)) for name in ("one", "two")}
        for jobs in (1, 2, 3):
            failed = self.run_program("render", self.scene, "-o", "no.png", "--quiet", *self.as_("alice"),
                                      *FRAME, "--seed", DEADLY)
            self.assert_error(failed, 3, f"{CRASH}; that happened to 2 workers")
            for name in workers:
                self.assertEqual(jobs, len(self.crashes(name)), "each job crashes each worker once")
        for name, worker in workers.items():
            self.assertIsNone(worker.poll(), "it is the same process")
            self.assertIn("signal 11 (SEGV) while it built a scene", self.crashes(name)[-1])
            self.assertEqual("tessera", pathlib.Path(f"/proc/{worker.pid}/comm").read_text().strip())
        # The connections of the workers before are gone, not inherited: as many files as of one that
        # never crashed.
        self.assert_renders(*self.as_("alice"))
        fresh = self.worker("fresh", *self.as_("one"))
        self.assertEqual(2, self.assert_renders(*self.as_("alice"))["workers"]["seen"] - 1)
        files = {p.pid: os.listdir(f"/proc/{p.pid}/fd") for p in (*workers.values(), fresh)}
        self.assertEqual({len(files[fresh.pid])}, {len(f) for f in files.values()})
        self.end_farm(*workers.values(), fresh)

    def test_one_alone_is_not_believed_and_the_job_is_held(self):
        self.serve()
        worker = self.worker("lone", *self.as_())
        submitted = self.run_program("submit", self.scene, *self.as_(), *FRAME, "--seed", DEADLY)
        self.assertEqual(0, submitted.code, submitted.err)
        job = submitted.out.strip()
        wait_until(lambda: f"{CRASH}; a worker that can is waited for" in
                   self.run_program("status", job, *self.as_()).out, "the job is held")
        self.assertEqual(1, len(self.crashes("lone")))
        self.assert_renders(*self.as_())
        # One that can build it comes.
        other = self.start("worker", *self.as_())
        fetched = self.run_program("fetch", job, "--wait", "-o", "late.png", *self.as_())
        self.assertEqual(0, fetched.code, fetched.err)
        self.assertEqual(1, len(self.crashes("lone")), "it did not build it again")
        self.end_farm(worker, other)

    def crash_from_outside(self, worker, name, times):
        """Crashes it so often, each time once it is there again."""
        for _ in range(times):
            before = len(self.crashes(name))
            wait_until(lambda: catches(worker, signal.SIGSEGV), "it goes on after crashes")
            worker.send_signal(signal.SIGSEGV)
            wait_until(lambda: len(self.crashes(name)) > before, "it is there again")

    def test_one_that_only_crashes_ends(self):
        self.serve()
        worker = self.worker("weak", *self.as_())
        self.assert_renders(*self.as_())
        self.crash_from_outside(worker, "weak", 6)
        self.assertIn("while it neither built a scene nor traced a tile", self.crashes("weak")[-1])
        self.assert_renders(*self.as_())  # since when it begins to count anew
        self.crash_from_outside(worker, "weak", 9)
        self.assertIsNone(worker.poll())
        self.crash_from_outside(worker, "weak", 1)
        self.assertEqual(3, worker.wait(PATIENCE))
        self.assertIn("crashed 10 times without tracing a tile, the last time with signal 11 (SEGV)",
                      (self.folder / "weak.log").read_text())
        self.end_farm()

    def test_what_was_told_to_end_is_not_started_anew(self):
        """It crashes while it waits for what is being traced."""
        self.serve()
        worker = self.worker("told", *self.as_())
        long = self.start("render", self.scene, "-o", "long.png", "--quiet", *self.as_(),
                          "--size", "32x32", "--tile", "32", "--spp", "1000000")
        wait_until(lambda: len(self.busy_threads(worker)) > 0, "it traces")
        worker.send_signal(signal.SIGTERM)
        wait_until(lambda: not catches(worker, signal.SIGTERM) or self.has_heard(worker), "it was told")
        worker.send_signal(signal.SIGSEGV)
        self.assertEqual(-signal.SIGSEGV, worker.wait(PATIENCE))
        long.send_signal(signal.SIGTERM)
        self.assertEqual(4, long.wait(PATIENCE))
        self.end_farm()

    def busy_threads(self, worker):
        """Those that have had a tenth of a second of a processor."""
        busy = []
        for thread in pathlib.Path(f"/proc/{worker.pid}/task").iterdir():
            fields = (thread / "stat").read_text().rpartition(")")[2].split()
            if sum(map(int, fields[11:13])) > os.sysconf("SC_CLK_TCK") / 10:
                busy.append(thread.name)
        return busy

    def has_heard(self, worker):
        """Whether no signal to the process waits."""
        status = pathlib.Path(f"/proc/{worker.pid}/status").read_text()
        return int(status.split("ShdPnd:")[1].split()[0], 16) == 0

    def test_a_record_that_is_none_is_told(self):
        worker = self.run_program("worker", "--connect", "tcp://127.0.0.1:1", "--crash-record", "0")
        self.assert_error(worker, 2, "--crash-record")


if __name__ == "__main__":
    unittest.main()
