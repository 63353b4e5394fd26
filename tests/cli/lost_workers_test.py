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
from tessera_process import PATIENCE, SLOWER, TesseraTest, is_worker, marked_processes, nightly, wait_until

SEEDS = int(os.environ.get("TESSERA_TEST_SEEDS", "12" if SLOWER == 1 else "3"))
# Enough work for there to be a midst. When something happens is a share of it, not a time: so it
# happens in the midst on every machine.
LOAD = ["--size", "320x240", "--tile", "16", "--spp"]


def tracing_seconds(worker):
    """What its threads that trace have spent of a processor so far; 0 if it has ended.

    They begin once the coordinator has heard its hello and sent it a job, and do nothing else.
    """
    ticks = 0
    for thread in pathlib.Path(f"/proc/{worker}/task").glob("*"):
        try:
            name, _, fields = (thread / "stat").read_text().partition("(")[2].rpartition(")")
            if int(thread.name) != worker and not name.startswith("ZMQ"):
                ticks += sum(map(int, fields.split()[11:13]))
        except OSError:
            pass  # it ended while we looked
    return ticks / os.sysconf("SC_CLK_TCK")


def state_of(process):
    """As ps tells it; T is stopped."""
    try:
        return pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return "X"


class LostWorkers(TesseraTest):
    spp = 8
    references = {}       # pixels_sha256 by samples per pixel
    seconds_a_sample = 0  # of a processor, for one sample in every pixel

    def setUp(self):
        super().setUp()
        self.scene = self.write("scene.tessera", scenes.glass_scene())
        self.load(self.spp)

    def render_reference(self, spp):
        """By threads of one process; the processor seconds that it took."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.references[spp] = self.render(self.scene, "--workers", "0", *LOAD, spp)["pixels_sha256"]
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime

    def load(self, spp):
        """What a sample takes is measured anew: the more of them, the less else there is in it."""
        if spp not in self.references:
            type(self).seconds_a_sample = self.render_reference(spp) / spp
        self.spp, self.reference = spp, self.references[spp]

    def start_render(self, workers, *options):
        return self.start("render", self.scene, "-o", "picture.png", "--stats", "stats.json",
                          "--quiet", "--workers", workers, *LOAD, self.spp, *options)

    def workers_of(self, process):
        return [p for p in marked_processes(self.mark) if p != process.pid and is_worker(p)]

    def start_with_workers(self, count):
        """A render and its `count` workers: one of more samples where all was done before they were
        seen."""
        while True:
            process = self.start_render(count)
            wait_until(lambda: process.poll() is not None or len(self.workers_of(process)) >= count,
                       f"{count} workers run")
            workers = self.workers_of(process)
            if len(workers) >= count:
                return process, workers
            self.assert_same_picture(process)
            self.load(2 * self.spp)

    def work(self, share):
        return self.seconds_a_sample * self.spp * share

    def wait_for_work(self, process, workers, share, least=0):
        """Until the workers have done that share of the work, and each at least some of it."""
        def done():
            seconds = [tracing_seconds(worker) for worker in workers]
            return sum(seconds) >= self.work(share) and min(seconds) >= least
        wait_until(lambda: process.poll() is not None or done(), f"{share:.2f} of the work is done")

    def stop_in_the_midst(self, count, share):
        """A render and its `count` workers, all of which have traced and now stand still, with work
        left: what then happens to them happens in the midst, however slow the machine is."""
        while True:
            process, workers = self.start_with_workers(count)
            self.wait_for_work(process, workers, share, least=0.03)
            for worker in workers:
                self.kill(worker, signal.SIGSTOP)
            wait_until(lambda: all(state_of(worker) in "TZX" for worker in workers), "all stand still")
            if (all(state_of(worker) == "T" for worker in workers) and
                    sum(map(tracing_seconds, workers)) < self.work(0.7)):
                return process, workers
            for worker in workers:
                self.kill(worker, signal.SIGCONT)
            self.assert_same_picture(process)
            self.load(2 * self.spp)  # that was too little for us to be in time

    def kill_and_go_on(self, process, killed, workers):
        """Once the coordinator knows of the deaths."""
        for worker in killed:
            self.kill(worker)
        wait_until(lambda: not any(os.path.exists(f"/proc/{p}") for p in killed), "all are buried")
        for worker in set(workers) - set(killed):
            self.kill(worker, signal.SIGCONT)
        stats = self.assert_same_picture(process)
        self.assertGreaterEqual(stats["workers"]["lost"], len(killed))
        self.assertGreaterEqual(stats["tiles"]["retries"], len(killed))

    def assert_same_picture(self, process):
        out, err = process.communicate(timeout=PATIENCE)
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

    @nightly
    def test_kill_one_at_any_moment(self):
        """Before its hello, too."""
        for seed in range(SEEDS):
            with self.subTest(seed=seed):
                chance = random.Random(seed)
                process, workers = self.start_with_workers(3)
                self.wait_for_work(process, workers, chance.uniform(0, 0.6))
                self.kill(chance.choice(workers))
                self.assert_same_picture(process)

    def test_kill_one_that_has_work(self):
        process, workers = self.stop_in_the_midst(3, 0.1)
        self.kill_and_go_on(process, workers[:1], workers)

    def test_kill_all_but_one(self):
        for seed in range(max(1, SEEDS // 3)):
            with self.subTest(seed=seed):
                chance = random.Random(1000 + seed)
                process, workers = self.stop_in_the_midst(4, chance.uniform(0.05, 0.5))
                self.kill_and_go_on(process, chance.sample(workers, 3), workers)

    def test_kill_every_worker(self):
        """They are replaced."""
        process, workers = self.stop_in_the_midst(3, 0.2)
        self.kill_and_go_on(process, workers, workers)

    def test_stop_one_for_good(self):
        """A stopped process is silent, but its socket still stands."""
        for seed in range(max(1, SEEDS // 6)):
            with self.subTest(seed=seed):
                chance = random.Random(2000 + seed)
                process, workers = self.stop_in_the_midst(3, chance.uniform(0.05, 0.5))
                stopped = chance.choice(workers)
                for worker in set(workers) - {stopped}:
                    self.kill(worker, signal.SIGCONT)
                self.assert_same_picture(process)
                self.assertNotIn(stopped, marked_processes(self.mark))

    def test_a_late_worker_joins(self):
        """A coordinator without workers waits for one; a second one comes while it works."""
        serve = self.start("serve", "--bind", "tcp://127.0.0.1:*")
        endpoint = serve.stdout.readline().split()[-1]
        process = self.start("render", self.scene, "-o", "picture.png", "--stats", "stats.json",
                             "--quiet", "--connect", endpoint, *LOAD, self.spp)
        time.sleep(0.3)
        self.assertIsNone(process.poll(), "it should wait for a worker")
        workers = []
        for threads in (1, 2):
            workers.append(self.start("worker", "--connect", endpoint, "--threads", threads))
            self.wait_for_work(process, [workers[-1].pid], 0, least=0.03)
            workers[-1].send_signal(signal.SIGSTOP)  # or it might leave nothing for the second
        for worker in workers:
            worker.send_signal(signal.SIGCONT)
        self.assertEqual(2, self.assert_same_picture(process)["workers"]["seen"])
        serve.send_signal(signal.SIGTERM)
        self.assertEqual(0, serve.wait(PATIENCE))
        for worker in workers:
            self.assertEqual(0, worker.wait(PATIENCE))

    def test_the_workers_die_with_the_program(self):
        process, _ = self.start_with_workers(4)
        process.kill()
        process.wait()
        wait_until(lambda: not marked_processes(self.mark), "all workers are gone")
        for folder in self.temporary.iterdir():  # nobody was left to tidy up
            for file in folder.iterdir():
                file.unlink()
            folder.rmdir()


if __name__ == "__main__":
    unittest.main()
