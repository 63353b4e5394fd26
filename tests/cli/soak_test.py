#!/usr/bin/env python3
"""Farm test 30: one job after the other while all goes wrong at random, and nothing grows.
TESSERA_SOAK_SECONDS=86400 is a day of it, TESSERA_SOAK_SEED another one."""
import json
import os
import pathlib
import random
import signal
import time
import unittest

from farm_limits_test import resident_bytes
from network_test import BOTH, BadNetwork
from service_test import TILES
from tessera_process import SLOWER, wait_until

SECONDS = float(os.environ.get("TESSERA_SOAK_SECONDS", "20"))
SEED = int(os.environ.get("TESSERA_SOAK_SEED", "1"))


def descriptors(process):
    return len(list(pathlib.Path(f"/proc/{process.pid}/fd").iterdir()))


class Soak(BadNetwork):
    spp = 4

    def setUp(self):
        super().setUp()
        self.chance = random.Random(SEED)
        self.cache = self.folder / "cache"
        self.workers = []

    def begin(self):
        self.log = open(self.folder / "serve.log", "a")
        self.addCleanup(self.log.close)
        service = self.start("serve", "--bind", self.endpoint, "--store", self.store, stderr=self.log)
        self.assertIn("serving at", service.stdout.readline())
        return service

    def results(self):
        """What workers that have ended, or cannot hand them in, left of results."""
        return list(self.cache.glob("*.results"))

    def join(self):
        self.workers.append(self.far_worker(stderr=self.log))

    def far_worker(self, **options):
        return self.start("worker", "--connect", f"tcp://127.0.0.2:{self.port}", "--threads", 1,
                          "--quiet", "--cache", self.cache,
                          "--orphan-timeout", 6 if self.workers else 600, **options)

    def present(self):
        return json.loads(self.ask("status", "--json"))["workers"]

    def something_happens(self):
        """What was done; never to the first worker, whose memory is looked at."""
        others = self.workers[1:]
        what = self.chance.choice(["kill", "end", "stop", "join", "reset", "one line", "swallow", "coordinator", "orphans"])
        if what in ("kill", "end", "stop") and others:
            worker = self.chance.choice(others)
            if what == "stop":
                worker.send_signal(signal.SIGSTOP)
                time.sleep(self.chance.uniform(0, 7))
                worker.send_signal(signal.SIGCONT)
            else:
                worker.send_signal(signal.SIGKILL if what == "kill" else signal.SIGTERM)
                worker.wait(60 * SLOWER)
                self.workers.remove(worker)
        if what == "join" and len(self.workers) < 5 or len(self.workers) < 2:
            self.join()
        if what == "reset":
            self.relay.reset()
        if what == "one line":
            self.relay.reset({self.chance.choice(BOTH)})
        if what == "swallow":
            self.relay.swallow = {self.chance.choice(["up", "down"])}
            time.sleep(self.chance.uniform(0, 7))
            self.relay.swallow = set()
            self.relay.reset()
        if what in ("coordinator", "orphans"):
            self.service.send_signal(signal.SIGKILL)  # told to end, it would send the workers away
            self.service.wait(60 * SLOWER)
            if what == "orphans":  # all but the first leave what they have traced to the next ones
                for worker in others:
                    worker.wait(60 * SLOWER)
            self.service = self.begin()
        return what

    def test_nothing_is_lost_and_nothing_grows(self):
        self.service = self.begin()
        self.join()
        self.join()
        pictures = [self.expected("--seed", seed) for seed in range(3)]
        end, rounds, sizes = time.monotonic() + SECONDS, 0, []
        while time.monotonic() < end or rounds < 3:
            seed = rounds % 3
            # Other bits each time, or their tiles would be there already.
            job = self.submit("--seed", seed, "--name", f"round{rounds}")
            happened = [self.something_happens() for _ in range(self.chance.randrange(3))]
            self.workers = [w for w in self.workers if w.poll() is None]
            if len(self.workers) < 2:
                self.join()
            with self.subTest(seed=SEED, round=rounds, happened=happened):
                self.assertEqual(pictures[seed], self.pixels(job))
                status = self.status(job)
                self.assertEqual(("done", TILES), (status["state"], status["tiles"]["done"]))
                self.assertEqual(0, status["tiles"].get("mismatches", 0))
            self.ask("cancel", job, "--forget")
            first = self.workers[0]
            sizes.append((resident_bytes(first), descriptors(first), descriptors(self.service)))
            rounds += 1
        print(f"{rounds} rounds; the first worker: {sizes[0]} and {sizes[-1]} (bytes, descriptors, "
              "the coordinator's)", flush=True)
        early, late = sizes[min(2, len(sizes) - 1)], sizes[-1]
        self.assertLess(late[0], early[0] + (32 << 20))
        self.assertLessEqual(late[1], early[1] + 8)
        self.assertLessEqual(late[2], early[2] + 8 * len(self.workers) + 8)
        self.assertEqual([], list((self.store / "blobs").iterdir()), "blobs of jobs that are forgotten")
        # One worker hands in what one before it left, of jobs that are forgotten too.
        for _ in self.results():
            self.join()
        wait_until(lambda: not self.results(), "all results are handed in")
        # Who is not there at the end hears nothing of it; who died is forgotten after 5 s.
        time.sleep(6)
        wait_until(lambda: self.present() == len(self.workers), "all workers are there")
        self.stop(self.service)
        for worker in self.workers:
            self.assertEqual(0, worker.wait(60 * SLOWER))


del BadNetwork

if __name__ == "__main__":
    unittest.main()
