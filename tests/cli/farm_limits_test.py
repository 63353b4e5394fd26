#!/usr/bin/env python3
"""Farms at the limits of a machine: very many workers, a scene that all want at once, no memory, no
ports, other addresses, small packets."""
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import socket
import subprocess
import time
import unittest
import urllib.request

from blob_cache_test import hills
from service_test import LOAD, TILES, ServiceTest
from tessera_process import PATIENCE, PROGRAM, SLOWER, nightly, wait_until


def resident_bytes(process):
    status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+)", status)[1]) * 1024


class Limits(ServiceTest):
    def serve_with_log(self, *options, prefix=()):
        self.log = open(self.folder / "serve.log", "w")
        self.addCleanup(self.log.close)
        process = self.start_in(prefix, "serve", "--bind", self.endpoint, "--store", self.store, *options,
                                stderr=self.log)
        self.assertIn("serving at", process.stdout.readline())
        return process

    def logged(self):
        return (self.folder / "serve.log").read_text()

    def start_in(self, prefix, *arguments, **options):
        process = subprocess.Popen(
            [*prefix, PROGRAM, *map(str, arguments)], cwd=self.folder, env=self.environment(),
            text=True, stdin=subprocess.DEVNULL,
            **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options})
        self.addCleanup(self.end, process)
        return process

    def many(self, count, *options):
        """So many workers of one thread each, all started at once, that say nothing."""
        return [self.start("worker", "--connect", self.endpoint, "--threads", 1, "--quiet", *options,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                for _ in range(count)]

    def end_all(self, service, workers):
        service.send_signal(signal.SIGTERM)
        self.assertEqual(0, service.wait(60 * SLOWER), self.logged())
        for worker in workers:
            self.assertEqual(0, worker.wait(60 * SLOWER))


class ManyWorkers(Limits):
    """Farm test 23: real processes and connections. TESSERA_MANY_WORKERS=1000 is the full size."""
    COUNT = int(os.environ.get("TESSERA_MANY_WORKERS", "60"))

    def test_they_all_come_and_trace(self):
        service = self.serve_with_log()
        before = resident_bytes(service)
        began = time.monotonic()
        workers = self.many(self.COUNT)
        wait_until(lambda: self.logged().count("has come, with") == self.COUNT, "all have come")
        came = time.monotonic() - began
        self.assertIn(f"{self.COUNT} workers", self.ask("status"))
        began = time.monotonic()
        self.assertEqual(self.expected(), self.pixels(self.submit()))
        job = self.status(1)
        self.assertEqual(TILES, job["tiles"]["done"])
        self.assertEqual(0, job["tiles"].get("mismatches", 0))
        grown = resident_bytes(service) - before
        print(f"{self.COUNT} workers came in {came:.1f} s, a frame took {time.monotonic() - began:.1f} s, "
              f"the coordinator grew by {grown >> 10} KiB", flush=True)
        # 256 messages of at most some kilobytes may wait for each, and its two connections.
        self.assertLess(grown, (64 << 20) + self.COUNT * (256 << 10))
        self.assertEqual(0, self.logged().count("lost worker"), self.logged())
        self.end_all(service, workers)


class ColdScene(Limits):
    """Farm test 24: all connect at once, and none has anything of the scene. TESSERA_COLD_SIDE=3800
    is half a GB of scene, with which each worker takes 2.3 GB: TESSERA_COLD_WORKERS=4."""
    SIDE = int(os.environ.get("TESSERA_COLD_SIDE", "400"))
    COUNT = int(os.environ.get("TESSERA_COLD_WORKERS", "16"))

    def shipped(self):
        """Bytes of scenes that went to workers."""
        with urllib.request.urlopen(f"{self.page}metrics", timeout=60) as answer:
            return int(re.search(r'wire_bytes_total{kind="scene"} (\d+)', answer.read().decode())[1])

    @nightly
    def test_each_gets_it_once(self):
        self.scene = self.write("hills.obj", hills(self.SIDE))
        service = self.serve_with_log("--http", "127.0.0.1:0")
        self.page = service.stdout.readline().split()[-1]
        workers = self.many(self.COUNT)
        # Of so many samples that nobody is done before all have the scene.
        long = int(self.ask("submit", self.scene, "--size", "64x48", "--tile", "8", "--spp", 1_000_000))
        blobs = [p.stat().st_size for p in (self.store / "blobs").rglob("*") if p.is_file()]
        whole = sum(blobs)
        self.assertGreater(whole, self.SIDE * self.SIDE * 24)
        began = time.monotonic()
        wait_until(lambda: self.shipped() >= self.COUNT * whole, "all have it")
        print(f"{whole >> 20} MiB to {self.COUNT} workers in {time.monotonic() - began:.1f} s", flush=True)
        self.assertLessEqual(self.shipped(), self.COUNT * whole * 1.05)
        self.ask("cancel", long)
        before = self.shipped()
        self.assertEqual(self.expected("--seed", 7), self.pixels(self.submit("--seed", 7)))
        self.assertEqual(before, self.shipped(), "a second job ships nothing")
        self.end_all(service, workers)


class Memory(Limits):
    """Farm test 16."""

    def setUp(self):
        if SLOWER > 1:
            self.skipTest("sanitizers need more memory than is given here")
        super().setUp()

    def limited(self, size):
        """Between fork and exec: so much memory and no more, as in a container."""
        return {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_DATA, (size, size))}

    def test_a_worker_without_memory_for_the_scene_leaves_it_to_others(self):
        self.scene = self.write("hills.obj", hills(400))
        service = self.serve_with_log()
        poor = self.start("worker", "--connect", self.endpoint, "--threads", 1, "--quiet",
                          **self.limited(48 << 20))
        wait_until(lambda: "has come" in self.logged(), "it has come")
        job = self.submit()
        wait_until(lambda: "could not build the scene" in self.logged() or "lost worker" in self.logged(),
                   "it has failed")
        rich = self.worker()
        # That job may have ended with its only worker; a new one has a second.
        self.ask("cancel", job) if self.status(job)["state"] != "failed" else None
        self.assertEqual(self.expected(), self.pixels(self.submit("--seed", "0")))
        self.assertNotEqual(-signal.SIGSEGV, poor.poll())
        service.send_signal(signal.SIGTERM)
        self.assertEqual(0, service.wait(60))
        self.assertEqual(0, rich.wait(60))
        poor.wait(60)

    @nightly
    def test_a_worker_that_is_killed_for_its_memory_is_as_one_that_died(self):
        group = pathlib.Path("/sys/fs/cgroup/memory") / f"tessera-{self.mark[:8]}"
        limit = group / "memory.limit_in_bytes"
        if not group.parent.is_dir():
            group = pathlib.Path("/sys/fs/cgroup") / group.name
            limit = group / "memory.max"
        try:
            group.mkdir()
            limit.write_text(str(24 << 20))
        except OSError as error:
            self.skipTest(f"a memory group is not permitted: {error}")
        self.addCleanup(self.remove, group)
        self.scene = self.write("hills.obj", hills(700))
        service = self.serve_with_log("--http", "127.0.0.1:0")
        page = service.stdout.readline().split()[-1]
        poor = self.start("worker", "--connect", self.endpoint, "--threads", 1, "--quiet",
                          preexec_fn=lambda: (group / "cgroup.procs").write_text(str(os.getpid())))
        rich = self.worker()
        wait_until(lambda: self.logged().count("has come, with") == 2, "both have come")
        job = self.submit()
        self.assertEqual(-signal.SIGKILL, poor.wait(PATIENCE))
        self.assertEqual(self.expected(), self.pixels(job))
        self.assertIn("lost worker", self.logged())
        # The next one of that group takes fewer tiles at one time, and says why.
        again = self.start("worker", "--connect", self.endpoint, "--threads", 4,
                           preexec_fn=lambda: (group / "cgroup.procs").write_text(str(os.getpid())))
        self.assertIn("this memory group has killed 1 worker", again.stderr.readline())

        def credit_of(process):
            with urllib.request.urlopen(f"{page}api/v1/workers", timeout=60) as answer:
                return {worker["name"].rpartition(":")[2]: worker["credit"]
                        for worker in json.load(answer)["workers"]}.get(str(process.pid))
        wait_until(lambda: credit_of(again), "it has come")
        self.assertEqual((4, 10), (credit_of(again), credit_of(rich)))
        self.end_all(service, [rich, again])

    @staticmethod
    def remove(group):
        wait_until(lambda: not (group / "cgroup.procs").read_text(), "the group is empty")
        group.rmdir()


class Network(Limits):
    """The rest of farm test 28: addresses, names, ports and packets."""

    def test_ipv6_alone(self):
        try:
            with socket.create_server(("::1", 0), family=socket.AF_INET6):
                pass
        except OSError as error:
            self.skipTest(f"no IPv6: {error}")
        self.endpoint = self.endpoint.replace("127.0.0.1", "[::1]")
        service, worker = self.serve_with_log(), self.worker()
        self.assertEqual(self.expected(), self.pixels(self.submit()))
        self.end_all(service, [worker])

    def inside(self, *setup):
        """A network of our own, with what is set up in it; the prefix of a command inside."""
        space = f"tessera-{self.mark[:6]}-l"
        if os.geteuid() != 0 or not shutil.which("ip"):
            self.skipTest("a network namespace needs root and iproute2")
        for command in (["ip", "netns", "add", space], ["ip", "-n", space, "link", "set", "lo", "up"],
                        *[["ip", "netns", "exec", space, *step] for step in setup]):
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            if command[2] == "add" and done.returncode == 0:
                self.addCleanup(subprocess.run, ["ip", "netns", "del", space], check=False)
            if done.returncode != 0:
                self.skipTest(f"a network of its own is not permitted here: {' '.join(command)}: {done.stderr.strip()}")
        return ("ip", "netns", "exec", space)

    def picture_inside(self, prefix, service, workers):
        client = self.start_in(prefix, "render", self.scene, "-o", "farm.pfm", "--quiet", *LOAD,
                               self.spp, "--connect", self.endpoint)
        _, err = client.communicate(timeout=PATIENCE)
        self.assertEqual(0, client.returncode, err)
        self.assertEqual(self.expected(), (self.folder / "farm.pfm").read_bytes())
        self.end_all(service, workers)

    def test_small_packets(self):
        prefix = self.inside(["ip", "link", "set", "lo", "mtu", "1280"])
        self.scene = self.write("hills.obj", hills(200))
        service = self.serve_with_log(prefix=prefix)
        workers = [self.start_in(prefix, "worker", "--connect", self.endpoint, "--threads", 1, "--quiet")
                   for _ in range(2)]
        self.picture_inside(prefix, service, workers)

    def test_no_port_is_left(self):
        """Of eight, all are taken when the worker comes; it gets in once some are free."""
        prefix = self.inside(["sysctl", "-qw", "net.ipv4.ip_local_port_range=40000 40007"])
        port = int(self.endpoint.rpartition(":")[2])
        service = self.serve_with_log(prefix=prefix)
        holder = subprocess.Popen(
            [*prefix, "python3", "-c", "import socket, sys\nheld = []\n"
             "for port in sys.argv[1:]:\n"
             "  try:\n"
             "    while True: held.append(socket.create_connection(('127.0.0.1', int(port))))\n"
             "  except OSError: pass\n"
             "print(len(held), flush=True)\nsys.stdin.read()", str(port), str(port + 1)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.addCleanup(lambda: holder.poll() is None and holder.kill())
        self.assertGreaterEqual(int(holder.stdout.readline()), 8)
        worker = self.start_in(prefix, "worker", "--connect", self.endpoint, "--threads", 1, "--quiet")
        time.sleep(1)
        self.assertNotIn("has come", self.logged())
        holder.communicate(timeout=10)
        wait_until(lambda: "has come" in self.logged(), "it gets in")
        self.assertIsNone(worker.poll())
        self.end_all(service, [worker])

    def test_the_coordinators_name_gets_another_address(self):
        if os.geteuid() != 0 or not shutil.which("unshare"):
            self.skipTest("names of our own need root and unshare")
        port = int(self.endpoint.rpartition(":")[2])
        hosts = self.write("hosts", "127.0.0.1 coordinator.test\n")
        prefix = ("unshare", "--mount", "sh", "-c",
                  f'mount --bind "{hosts}" /etc/hosts && exec "$@"', "sh")
        if subprocess.run([*prefix, "true"], capture_output=True, check=False).returncode != 0:
            self.skipTest("a mount namespace is not permitted")
        service = self.serve_with_log()
        worker = self.start_in(prefix, "worker", "--connect", f"tcp://coordinator.test:{port}",
                               "--threads", 1, "--quiet")
        wait_until(lambda: "has come" in self.logged(), "it has come")
        job = self.submit()
        wait_until(lambda: self.status(job)["tiles"]["done"] > 0, "the job runs")
        service.send_signal(signal.SIGKILL)
        service.wait(10)
        hosts.write_text("127.0.0.3 coordinator.test\n")  # the same file, as it is mounted
        self.endpoint = f"tcp://127.0.0.3:{port}"
        service = self.serve_with_log()
        self.assertEqual(self.expected(), self.pixels(job))
        self.assertIsNone(worker.poll())
        self.end_all(service, [worker])


# Those of the class that these are made from have their own run.
del ServiceTest

if __name__ == "__main__":
    unittest.main()
