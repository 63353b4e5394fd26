#!/usr/bin/env python3
"""Farm test 28: no file descriptor is left, in the coordinator or in a worker."""
import collections
import os
import resource
import signal
import socket
import threading
import time
import unittest

from service_test import ServiceTest
from tessera_process import nightly, wait_until


def limited(count):
    """Between fork and exec: so many descriptors and no more."""
    return {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (count, count))}


def processor_seconds(process):
    with open(f"/proc/{process.pid}/stat", encoding="ascii") as stat:
        fields = stat.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


# Of ZeroMQ's protocol, without keys: what one sends first who is let in if he goes on.
GREETING = b"\xff" + bytes(8) + b"\x7f\x03\x00NULL" + bytes(48)


class Flood(threading.Thread):
    """Connections from several addresses that say nothing, over and over until stop()."""

    def __init__(self, ports, most_held):
        super().__init__(daemon=True)
        self.ports, self.most_held = ports, most_held
        self.made, self.stopping = 0, threading.Event()
        self.start()

    def run(self):
        held = collections.deque()
        while not self.stopping.wait(0.01):
            for _ in range(10):
                one = socket.socket()
                one.setblocking(False)
                one.bind((f"127.0.0.{1 + self.made % 7}", 0))
                one.connect_ex(("127.0.0.1", self.ports[self.made % len(self.ports)]))
                held.append(one)
                self.made += 1
            while len(held) > self.most_held:
                held.popleft().close()
        for one in held:
            one.close()

    def stop(self):
        self.stopping.set()
        self.join()


class Descriptors(ServiceTest):
    LIMIT = 80

    def limited_service(self, count):
        service = self.start("serve", "--bind", self.endpoint, "--store", self.store,
                             **limited(count))
        self.assertIn("serving at", service.stdout.readline())
        return service

    @nightly
    def test_a_flood_of_silent_connections_takes_none_from_the_farm(self):
        limit = 640
        service = self.limited_service(limit)
        port = int(self.endpoint.rpartition(":")[2])
        worker = self.worker()
        flood = Flood([port, port + 1], 2 * limit)
        wait_until(lambda: flood.made > 4 * limit, "the flood is there")
        most = 0
        for seed in range(3):
            job = self.submit("--seed", seed)
            while self.status(job)["state"] in ("queued", "running"):
                most = max(most, len(os.listdir(f"/proc/{service.pid}/fd")))
            self.assertEqual("done", self.status(job)["state"])
            self.assertEqual(self.expected("--seed", seed), self.pixels(job))
        made = flood.made
        wait_until(lambda: flood.made > made + 4 * limit, "the flood lasts")
        flood.stop()
        # 64 are kept for files, and a quarter of the others may be connections that wait: 144, and
        # those that are being ended. Without such a bound they would be all 576.
        self.assertGreater(most, 144)
        self.assertLess(most, 400)
        self.assertIsNone(worker.poll())
        service.send_signal(signal.SIGTERM)
        _, log = service.communicate(timeout=60)
        self.assertEqual(0, service.returncode, log)
        self.assertEqual(1, log.count("the oldest are ended"), log)
        self.assertNotIn("no file descriptor is left", log)
        self.assertEqual(0, worker.wait(60))

    def test_a_coordinator_turns_away_whom_it_has_none_for(self):
        service = self.limited_service(self.LIMIT)
        worker = self.worker()
        job = self.submit()
        wait_until(lambda: self.status(job)["tiles"]["done"] > 0, "the job runs")
        port = int(self.endpoint.rpartition(":")[2])
        held = []
        while len(held) < 2 * self.LIMIT:  # each is ended if it says nothing more for 5 s
            try:
                held.append(socket.create_connection(("127.0.0.1", port), timeout=5))
                held[-1].sendall(GREETING)
            except OSError:
                break
        before, used = time.monotonic(), processor_seconds(service)
        self.assertEqual(self.expected(), self.pixels_of(job, worker))
        for one in held:
            one.close()
        # It must not have spent all the while in circles: one thread of it would be busy throughout.
        self.assertLess(processor_seconds(service) - used, 0.5 * (time.monotonic() - before) + 1)
        service.send_signal(signal.SIGTERM)
        _, log = service.communicate(timeout=60)
        self.assertEqual(0, service.returncode, log)
        self.assertEqual(1, log.count("no file descriptor is left"), log)
        self.assertEqual(0, worker.wait(60))

    def test_a_client_waits_for_who_hangs_up_for_a_while(self):
        """As a coordinator without a descriptor does, which lets in later."""
        hung_up = []
        with socket.create_server(("127.0.0.1", int(self.endpoint.rpartition(":")[2]))) as listener:
            listener.settimeout(10)
            client = self.start("status", "--connect", self.endpoint)
            began = time.monotonic()
            while time.monotonic() < began + 4:  # what is certain is told after 2 s
                listener.accept()[0].close()
                hung_up.append(1)
        self.assertGreater(len(hung_up), 3)
        service = self.serve()
        out, err = client.communicate(timeout=60)
        self.assertEqual(0, client.returncode, err)
        self.assertEqual("0 workers", out.splitlines()[-1])
        self.stop(service)

    def pixels_of(self, job, worker):
        """Once the job has ended, of which the worker's old connection tells while no new ones are
        let in; a client gets in when those that say nothing more are ended."""
        wait_until(lambda: self.run_program("status", job, "--connect", self.endpoint).code == 0,
                   "a client gets in again")
        self.assertIsNone(worker.poll())
        return self.pixels(job)

    def test_too_few_to_begin_with_is_an_error(self):
        for command in (["serve", "--bind", "tcp://127.0.0.1:*"],
                        ["worker", "--connect", self.endpoint, "--quiet", "--threads", 1],
                        ["status", "--connect", self.endpoint]):
            for count in (6, 8, 12, 20):
                with self.subTest(command=command[0], count=count):
                    result = self.run_program(*command, **limited(count))
                    self.assertEqual(3, result.code, result.err)
                    self.assertIn("descriptor", result.err)


del ServiceTest

if __name__ == "__main__":
    unittest.main()
