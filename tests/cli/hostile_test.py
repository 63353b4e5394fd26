#!/usr/bin/env python3
"""Farm test 19, behind the door: workers and clients that are let in and send whatever there is, to a
real coordinator that has a job to do; and a coordinator that does the same to real workers.
TESSERA_HOSTILE_SECONDS=600 is ten minutes of it, TESSERA_HOSTILE_SEED another one."""
import os
import pathlib
import re
import subprocess
import time
import unittest

from farm_limits_test import resident_bytes
from service_test import TILES, ServiceTest
from tessera_process import PATIENCE, PROGRAM, SLOWER, nightly, wait_until

SECONDS = int(os.environ.get("TESSERA_HOSTILE_SECONDS", "4"))
SEED = int(os.environ.get("TESSERA_HOSTILE_SEED", "1"))
PEER = pathlib.Path(PROGRAM).parent / "farm_hostile_peer"


class Hostile(ServiceTest):
    spp = int(64 / SLOWER)

    def environment(self):
        # What a sanitizer keeps of what was freed has not grown.
        options = ":".join(filter(None, [os.environ.get("ASAN_OPTIONS"), "quarantine_size_mb=16"]))
        return {**super().environment(), "ASAN_OPTIONS": options}

    def peer(self, endpoint, role, seed):
        process = subprocess.Popen([PEER, endpoint, role, str(seed), str(SECONDS)], stdout=subprocess.PIPE,
                                   text=True, env=self.environment())
        self.addCleanup(process.kill)
        return process

    def sent_by(self, *peers):
        """How many messages; all have come to their end."""
        count = 0
        for peer in peers:
            out, _ = peer.communicate(timeout=PATIENCE + SECONDS)
            self.assertEqual(0, peer.returncode)
            count += int(re.search(r"(\d+) messages", out)[1])
        return count

    @nightly
    def test_who_is_let_in_cannot_spoil_a_job(self):
        reference = self.expected()
        service = self.serve("--verify", "100%")
        honest = [self.worker("--cache", self.folder / "cache") for _ in range(3)]
        wait_until(lambda: self.ask("status").splitlines()[-1].startswith("3 workers"), "all have come")
        before = resident_bytes(service)
        peers = [self.peer(self.endpoint, role, SEED + i) for i, role in enumerate(["worker", "client"] * 2)]
        end, rounds = time.monotonic() + SECONDS, 0
        while time.monotonic() < end or rounds == 0:
            # Other pixels each time.
            job = self.submit("--seed", rounds)
            pixels = self.pixels(job)
            if rounds == 0:
                self.assertEqual(reference, pixels)
            else:
                self.assertEqual(self.expected("--seed", rounds), pixels)
            status = self.status(job)
            self.assertEqual(("done", TILES), (status["state"], status["tiles"]["done"]))
            rounds += 1
        grown = resident_bytes(service) - before
        sent = self.sent_by(*peers)
        print(f"{rounds} jobs beside {sent} messages, the coordinator grew by {grown >> 10} KiB", flush=True)
        self.assertGreater(sent, 500 * SECONDS)
        self.assertLess(grown, 256 << 20)
        # They are gone, and nothing is left of them.
        self.assertEqual(reference, self.pixels(self.submit("--name", "after")))
        self.stop(service)
        self.assertEqual(0, service.returncode)
        for worker in honest:
            self.assertEqual(0, worker.wait(PATIENCE), worker.stderr.read())

    def test_a_coordinator_can_do_nothing_but_waste_a_workers_time(self):
        peer = self.peer("tcp://127.0.0.1:*", "coordinator", SEED)
        endpoint = peer.stdout.readline().strip()
        cache = self.folder / "cache"
        workers = [self.start("worker", "--connect", endpoint, "--threads", 1, "--quiet", "--cache", cache)
                   for _ in range(2)]
        end = time.monotonic() + SECONDS
        while time.monotonic() < end - 0.5:
            for worker in workers:
                self.assertIsNone(worker.poll(), worker.poll() and worker.stderr.read())
                self.assertLess(resident_bytes(worker), 512 << 20)
            time.sleep(0.2)
        self.assertGreater(self.sent_by(peer), 500 * SECONDS)
        self.stop(*workers)
        self.assertEqual([0, 0], [worker.returncode for worker in workers])


del ServiceTest

if __name__ == "__main__":
    unittest.main()
