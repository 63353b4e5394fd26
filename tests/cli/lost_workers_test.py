#!/usr/bin/env python3
"""Workers that are killed, stopped or late, in the midst of a loaded farm: same picture, exit 0."""
import os
import pathlib
import random
import resource
import signal
import time
import unittest

import scenes
from tessera_process import TesseraTest, is_worker, marked_processes, wait_until

SEEDS = int(os.environ.get("TESSERA_TEST_SEEDS", "12"))
# Enough work for there to be a midst. When something happens is a share of it, not a time: so it
# happens in the midst on every machine.
LOAD = ["--size", "320x240", "--tile", "16", "--spp"]


def processor_seconds(processes):
    """What these have spent so far; one that has ended counts nothing."""
    ticks = 0
    for process in processes:
        try:
            fields = pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
            ticks += int(fields[11]) + int(fields[12])
        except OSError:
            pass
    return ticks / os.sysconf("SC_CLK_TCK")


class LostWorkers(TesseraTest):
    spp = 8
    references = {}       # pixels_sha256 by samples per pixel
    seconds_a_sample = 0  # of a processor, for one sample in every pixel

    def setUp(self):
        super().setUp()
        self.scene = self.write("scene.tessera", scenes.glass_scene())
        if not self.references:
            before = self.render_reference(1)
            type(self).seconds_a_sample = (self.render_reference(self.spp) - before) / (self.spp - 1)
        self.reference = self.references[self.spp]

    def render_reference(self, spp):
        """By threads of one process; the processor seconds that it took."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.references[spp] = self.render(self.scene, "--workers", "0", *LOAD, spp)["pixels_sha256"]
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime

    def load(self, spp):
        if spp not in self.references:
            self.render_reference(spp)
        self.spp, self.reference = spp, self.references[spp]

    def start_render(self, workers, *options):
        process = self.start("render", self.scene, "-o", "picture.png", "--stats", "stats.json",
                             "--quiet", "--workers", workers, *LOAD, self.spp, *options)
        return process

    def workers_of(self, process):
        return [p for p in marked_processes(self.mark) if p != process.pid and is_worker(p)]

    def wait_for_workers(self, process, count):
        return wait_until(lambda: len(w := self.workers_of(process)) >= count and w, 10,
                          f"{count} workers run")

    def wait_for_work(self, process, workers, share):
        """Until the workers have done that share of the work."""
        work = self.seconds_a_sample * self.spp * share
        wait_until(lambda: process.poll() is not None or processor_seconds(workers) >= work, 60,
                   f"{share:.2f} of the work is done")

    def assert_same_picture(self, process, seconds=90):
        out, err = process.communicate(timeout=seconds)
        self.assertEqual(0, process.returncode, err)
        stats = self.stats()
        self.assertEqual(self.reference, stats["pixels_sha256"])
        self.assertEqual(stats["tiles"]["total"], stats["tiles"]["done"])
        self.assertEqual(0, stats["tiles"]["mismatches"])
        return stats

    def kill(self, process, sent=signal.SIGKILL):
        try:
            os.kill(process, sent)
        except ProcessLookupError:
            pass  # it had just ended

    def test_kill_one_at_any_moment(self):
        losses = 0
        for seed in range(SEEDS):
            with self.subTest(seed=seed):
                chance = random.Random(seed)
                process = self.start_render(3)
                workers = self.wait_for_workers(process, 3)
                self.wait_for_work(process, workers, chance.uniform(0, 0.6))
                self.kill(chance.choice(workers))
                losses += self.assert_same_picture(process)["workers"]["lost"]
        # Some may not have said hello yet.
        self.assertGreater(losses, SEEDS / 2)

    def test_kill_all_but_one(self):
        losses, rounds = 0, max(1, SEEDS // 3)
        for seed in range(rounds):
            with self.subTest(seed=seed):
                chance = random.Random(1000 + seed)
                process = self.start_render(4)
                workers = self.wait_for_workers(process, 4)
                self.wait_for_work(process, workers, chance.uniform(0.05, 0.5))
                for worker in chance.sample(workers, 3):
                    self.kill(worker)
                losses += self.assert_same_picture(process)["workers"]["lost"]
        self.assertGreater(losses, 3 * rounds / 2)

    def test_kill_every_worker(self):
        """They are replaced."""
        process = self.start_render(3)
        killed = self.wait_for_workers(process, 3)
        self.wait_for_work(process, killed, 0.2)
        for worker in killed:
            self.kill(worker)
        wait_until(lambda: set(self.workers_of(process)) - set(killed), 10, "others take their place")
        stats = self.assert_same_picture(process)
        self.assertGreaterEqual(stats["workers"]["lost"], 1)  # who had said hello

    def test_a_loss_under_load_is_counted(self):
        """Killed while it surely has tiles: they are tried again, and that shows."""
        self.load(64)
        process = self.start_render(3)
        workers = self.wait_for_workers(process, 3)
        self.wait_for_work(process, workers, 0.1)
        self.kill(workers[0])
        stats = self.assert_same_picture(process)
        self.assertGreaterEqual(stats["workers"]["lost"], 1)
        self.assertGreaterEqual(stats["tiles"]["retries"], 1)

    def test_stop_one_for_good(self):
        """A stopped process is silent, but its socket still stands."""
        for seed in range(max(1, SEEDS // 6)):
            with self.subTest(seed=seed):
                chance = random.Random(2000 + seed)
                process = self.start_render(3)
                workers = self.wait_for_workers(process, 3)
                self.wait_for_work(process, workers, chance.uniform(0.05, 0.5))
                stopped = chance.choice(workers)
                self.kill(stopped, signal.SIGSTOP)
                self.assert_same_picture(process)
                self.assertNotIn(stopped, marked_processes(self.mark))

    def test_a_late_worker_joins(self):
        """A coordinator without workers waits for one; a second one comes while it works."""
        self.load(64)  # long enough for the second one to be in time
        serve = self.start("serve", "--bind", "tcp://127.0.0.1:*")
        endpoint = serve.stdout.readline().split()[-1]
        process = self.start("render", self.scene, "-o", "picture.png", "--stats", "stats.json",
                             "--quiet", "--connect", endpoint, *LOAD, self.spp)
        time.sleep(0.3)
        self.assertIsNone(process.poll(), "it should wait for a worker")
        workers = [self.start("worker", "--connect", endpoint, "--threads", 1)]
        time.sleep(0.3)
        workers.append(self.start("worker", "--connect", endpoint, "--threads", 2))
        self.assertEqual(2, self.assert_same_picture(process)["workers"]["seen"])
        serve.send_signal(signal.SIGTERM)
        self.assertEqual(0, serve.wait(10))
        for worker in workers:
            self.assertEqual(0, worker.wait(10))

    def test_the_workers_die_with_the_program(self):
        process = self.start_render(4)
        self.wait_for_workers(process, 4)
        process.kill()
        process.wait()
        wait_until(lambda: not marked_processes(self.mark), 5, "all workers are gone")
        for folder in self.temporary.iterdir():  # nobody was left to tidy up
            for file in folder.iterdir():
                file.unlink()
            folder.rmdir()


if __name__ == "__main__":
    unittest.main()
