#!/usr/bin/env python3
"""Bad networks between coordinator and workers: a relay in between that delays, slices, holds back,
swallows and resets; and, where the kernel has it, netem in a network namespace."""
import os
import random
import selectors
import shutil
import signal
import socket
import subprocess
import threading
import time
import unittest

from service_test import LOAD, TILES, ServiceTest
from tessera_process import PROGRAM, wait_until


class Relay:
    """Forwards TCP from 127.0.0.2 to 127.0.0.1, on a port and its successor: control and blobs.
    What it does to the bytes may be changed at any time."""

    def __init__(self, port, seed=1):
        self.delay = self.jitter = 0.0  # seconds, each way
        self.stall = 0.0  # of pieces, that are held back as a lost packet is until it is sent again
        self.rate = None  # bytes a second, each way
        self.swallow = set()  # of "up" (to the coordinator) and "down"
        self.largest = 65536  # bytes in one piece
        self.forwarded = 0
        self.connections = 0
        self.refuse = False
        self.chance = random.Random(seed)
        self.pairs = {}  # socket -> (other, direction)
        self.queues = {}  # socket -> [(due, bytes)]
        self.free_at = {}
        self.poller = selectors.DefaultSelector()
        self.listeners = []
        for number in (port, port + 1):
            listener = socket.create_server(("127.0.0.2", number))
            listener.setblocking(False)
            self.poller.register(listener, selectors.EVENT_READ, number)
            self.listeners.append(listener)
        self.resets, self.ended = 0, False
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def reset(self):
        """Ends all connections, as a firewall would that was started anew."""
        self.resets += 1
        wait_until(lambda: self.resets == 0, "the relay has reset its connections")

    def close(self):
        self.ended = True
        self.thread.join()

    def run(self):
        while not self.ended:
            if self.resets:
                for one in list(self.pairs):
                    self.drop(one)
                self.resets = 0
            for key, _ in self.poller.select(0.005):
                if key.data is not None:
                    self.accept(key.fileobj, key.data)
                elif key.fileobj in self.pairs:
                    self.read(key.fileobj)
            self.write()
        for one in list(self.pairs):
            self.drop(one)
        for listener in self.listeners:
            listener.close()

    def accept(self, listener, port):
        near, _ = listener.accept()
        try:
            if self.refuse:
                raise OSError
            far = socket.create_connection(("127.0.0.1", port))
        except OSError:
            near.close()
            return
        self.connections += 1
        for one, other, way in ((near, far, "up"), (far, near, "down")):
            one.setblocking(False)
            self.pairs[one] = (other, way)
            self.queues[one] = []
            self.free_at[one] = 0.0
            self.poller.register(one, selectors.EVENT_READ)

    def drop(self, one):
        if one not in self.pairs:
            return
        other = self.pairs[one][0]
        for end in (one, other):
            self.poller.unregister(end)
            del self.pairs[end], self.queues[end], self.free_at[end]
            end.close()

    def read(self, one):
        try:
            data = one.recv(self.largest)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            return self.drop(one)
        other, way = self.pairs[one]
        if way in self.swallow:
            return  # the byte stream is broken now: the peers notice when they are heard again
        now = time.monotonic()
        due = now + self.delay + self.chance.uniform(-self.jitter, self.jitter)
        if self.chance.random() < self.stall:
            due += 0.2 + self.delay  # the time until it is sent again
        if self.rate:
            due = max(due, self.free_at[other]) + len(data) / self.rate
        due = max(due, self.free_at[other])  # in order, as TCP has it
        self.free_at[other] = due
        self.queues[other].append((due, data))

    def write(self):
        now = time.monotonic()
        for one in list(self.pairs):
            queue = self.queues.get(one)
            while queue and queue[0][0] <= now:
                due, data = queue.pop(0)
                try:
                    sent = one.send(data)
                except BlockingIOError:
                    sent = 0
                except OSError:
                    self.drop(one)
                    break
                self.forwarded += sent
                if sent < len(data):
                    queue.insert(0, (due, data[sent:]))
                    break


class BadNetwork(ServiceTest):
    spp = 16

    def setUp(self):
        super().setUp()
        self.port = int(self.endpoint.rpartition(":")[2])
        self.relay = Relay(self.port)
        self.addCleanup(self.relay.close)

    def far_worker(self, *options):
        return self.start("worker", "--connect", f"tcp://127.0.0.2:{self.port}", "--threads", 1,
                          "--quiet", *options)

    def begin(self, workers=1):
        """A service, workers behind the relay, and a job of which something is done."""
        service, far = self.serve(), [self.far_worker() for _ in range(workers)]
        job = self.submit()
        wait_until(lambda: self.done(job) > 0, "the job runs")
        return service, far, job

    def done(self, job):
        return self.status(job)["tiles"]["done"]

    def finish(self, service, workers, job):
        """The right picture, each tile once; the service's log."""
        self.assertEqual(self.expected(), self.pixels(job))
        status = self.status(job)
        self.assertEqual(("done", TILES), (status["state"], status["tiles"]["done"]))
        self.assertEqual(0, status["tiles"].get("mismatches", 0))
        service.send_signal(signal.SIGTERM)
        _, log = service.communicate(timeout=60)
        self.assertEqual(0, service.returncode, log)
        for worker in workers:
            worker.wait(60)
        self.assertEqual(TILES, self.kept_tiles())
        return log

    def test_slow_and_lossy(self):
        """Farm test 6: 200 ms +/- 50, what is lost comes later, small pieces, 4 Mbit/s."""
        self.relay.delay, self.relay.jitter, self.relay.stall = 0.2, 0.05, 0.05
        self.relay.largest, self.relay.rate = 1400, 500_000
        service, workers, job = self.begin(2)
        log = self.finish(service, workers, job)
        self.assertNotIn("lost worker", log.split("is done")[0])

    def test_partition_both_ways_then_one_way_then_none(self):
        """Farm test 5: nothing comes through, and the connections stay."""
        service, workers, job = self.begin()
        for ways in ({"up", "down"}, {"down"}, {"up"}):
            self.relay.swallow = ways
            before = self.done(job)
            wait_until(lambda: "0 workers" in self.ask("status"), f"it is lost without {ways}")
            self.assertLessEqual(self.done(job), before + 8)
            self.relay.swallow = set()
            wait_until(lambda: "1 worker" in self.ask("status"), "it is back, by itself")
        self.finish(service, workers, job)

    def test_a_flapping_link(self):
        """Farm test 7, in short: nobody is let through, and all is reset, every other second."""
        service, workers, job = self.begin(2)
        before = self.relay.connections
        flaps = 6
        for _ in range(flaps):
            self.relay.refuse = True
            self.relay.reset()
            time.sleep(1)
            self.relay.refuse = False
            time.sleep(1)
        # Two channels each, and some tries of a socket that was just reset: no storm.
        self.assertLess(self.relay.connections - before, 2 * 2 * flaps * 6)
        self.finish(service, workers, job)


class Netem(ServiceTest):
    """The same by the kernel: packets are lost, doubled and overtaken, not bytes of a stream."""
    spp = 16

    def ip(self, *arguments):
        return subprocess.run(["ip", *arguments], capture_output=True, text=True, check=False)

    def permitted(self, done, what):
        if done.returncode == 0:
            return
        print(f"SKIPPED: {what} is not permitted or not there: {done.stderr.strip()}", flush=True)
        self.skipTest(what)

    @unittest.skipIf(os.geteuid() != 0 or not shutil.which("tc"), "needs root and iproute2")
    def test_loss_doubling_and_reordering(self):
        space = f"tessera-{self.mark[:6]}-n"
        self.permitted(self.ip("netns", "add", space), "a network namespace")
        self.addCleanup(self.ip, "netns", "del", space)
        self.ip("-n", space, "link", "set", "lo", "up")
        self.permitted(
            subprocess.run(["tc", "-n", space, "qdisc", "add", "dev", "lo", "root", "netem", "delay",
                            "100ms", "25ms", "loss", "5%", "duplicate", "2%", "reorder", "10%"],
                           capture_output=True, text=True, check=False), "netem")
        inside = ("ip", "netns", "exec", space)

        def start(*arguments):
            process = subprocess.Popen(
                [*inside, PROGRAM, *map(str, arguments)], cwd=self.folder, env=self.environment(),
                text=True, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            self.addCleanup(self.end, process)
            return process

        service = start("serve", "--bind", self.endpoint, "--store", self.store)
        self.assertIn("serving at", service.stdout.readline())
        workers = [start("worker", "--connect", self.endpoint, "--threads", 1, "--quiet")
                   for _ in range(2)]
        picture = start("render", self.scene, "-o", "farm.pfm", "--quiet", *LOAD, self.spp,
                        "--connect", self.endpoint)
        _, err = picture.communicate(timeout=300)
        self.assertEqual(0, picture.returncode, err)
        self.assertEqual(self.expected(), (self.folder / "farm.pfm").read_bytes())
        self.stop(service)
        for worker in workers:
            worker.wait(60)


# Those of the class that these are made from have their own run.
del ServiceTest

if __name__ == "__main__":
    unittest.main()
