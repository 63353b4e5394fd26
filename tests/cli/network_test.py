#!/usr/bin/env python3
"""Bad networks between coordinator and workers: a relay in between that delays, slices, holds back,
swallows and resets; and, where the kernel has it, netem in a network namespace."""
import json
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

from blob_cache_test import hills
from service_test import LOAD, TILES, ServiceTest, free_port
from tessera_process import PATIENCE, PROGRAM, catches, wait_until


BOTH = ("control", "bulk")
LOST = 3  # seconds of silence after which a worker is counted no more


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
        self.dropped = []  # lines, in the order in which their connections ended
        self.refuse = set()  # of "control" and "bulk": the lines that let nobody through
        self.mute = set()  # of lines whose bytes are swallowed, both ways
        self.slow = {}  # line -> seconds, each way, beside `delay`
        self.chance = random.Random(seed)
        self.pairs = {}  # socket -> (other, direction, line)
        self.queues = {}  # socket -> [(due, bytes)]
        self.free_at = {}
        self.poller = selectors.DefaultSelector()
        self.listeners = []
        for number, line in ((port, "control"), (port + 1, "bulk")):
            listener = socket.create_server(("127.0.0.2", number))
            listener.setblocking(False)
            self.poller.register(listener, selectors.EVENT_READ, (number, line))
            self.listeners.append(listener)
        self.resets, self.ended = set(), False
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def reset(self, lines=BOTH):
        """Ends all connections, as a firewall would that was started anew."""
        self.resets = set(lines)
        wait_until(lambda: not self.resets, "the relay has reset its connections")

    def ended_of(self, line):
        return line in self.dropped

    def close(self):
        self.ended = True
        self.thread.join()

    def run(self):
        while not self.ended:
            if self.resets:
                for one in [one for one, (_, _, line) in self.pairs.items() if line in self.resets]:
                    self.drop(one)
                self.resets = set()
            for key, _ in self.poller.select(0.005):
                if key.data is not None:
                    self.accept(key.fileobj, *key.data)
                elif key.fileobj in self.pairs:
                    self.read(key.fileobj)
            self.write()
        for one in list(self.pairs):
            self.drop(one)
        for listener in self.listeners:
            listener.close()

    def accept(self, listener, port, line):
        near, _ = listener.accept()
        try:
            if line in self.refuse:
                raise OSError
            far = socket.create_connection(("127.0.0.1", port))
        except OSError:
            near.close()
            return
        self.connections += 1
        for one, other, way in ((near, far, "up"), (far, near, "down")):
            one.setblocking(False)
            self.pairs[one] = (other, way, line)
            self.queues[one] = []
            self.free_at[one] = 0.0
            self.poller.register(one, selectors.EVENT_READ)

    def drop(self, one):
        if one not in self.pairs:
            return
        other, _, line = self.pairs[one]
        self.dropped.append(line)
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
        other, way, line = self.pairs[one]
        if way in self.swallow or line in self.mute:
            return  # the byte stream is broken now: the peers notice when they are heard again
        now = time.monotonic()
        due = now + self.delay + self.slow.get(line, 0) + self.chance.uniform(-self.jitter, self.jitter)
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
            if queue and self.pairs[one][2] in self.mute:
                queue.clear()
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


class BothLines(BadNetwork):
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
            self.relay.refuse = set(BOTH)
            self.relay.reset()
            time.sleep(1)
            self.relay.refuse = set()
            time.sleep(1)
        # Two channels each, and some tries of a socket that was just reset: no storm.
        self.assertLess(self.relay.connections - before, 2 * 2 * flaps * 6)
        self.finish(service, workers, job)


class OneLine(BadNetwork):
    """Each party has two connections: one of them is cut, refused, muted or delayed while the other
    one goes on. Nobody may wait for what does not come any more."""

    def setUp(self):
        super().setUp()
        # Some megabytes, so that something is on the bulk line whenever it is tampered with.
        self.scene = self.write("hills.obj", hills(300))
        self.relay.rate = 3_000_000

    def far(self, *command):
        return self.start(*command, "--connect", f"tcp://127.0.0.2:{self.port}")

    def log_file(self):
        log = open(self.folder / "worker.log", "w")
        self.addCleanup(log.close)
        return log

    def tamper(self, chance):
        """One line is not what it was, for a while; what was done."""
        line, what = chance.choice(BOTH), chance.choice(("cut", "refuse", "mute", "slow"))
        if what == "refuse":
            self.relay.refuse = {line}
        if what == "mute":
            self.relay.mute = {line}
        if what == "slow":
            self.relay.slow = {line: chance.uniform(0.2, 1)}
        if what in ("cut", "refuse"):
            self.relay.reset({line})
        time.sleep(chance.uniform(0, 1.5))
        self.relay.refuse, self.relay.mute, self.relay.slow = set(), set(), {}
        if what == "mute":  # the stream lacks bytes now: as good as cut, once somebody notices
            self.relay.reset({line})
        return f"{what} {line}"

    def test_one_line_alone_fails_again_and_again(self):
        """The client, too, is behind the relay: it submits, watches and fetches over such lines."""
        expected = self.expected()
        for seed in range(int(os.environ.get("TESSERA_LINE_SEEDS", "3"))):
            with self.subTest(seed=seed):
                chance = random.Random(seed)
                self.store = self.folder / f"farm{seed}"
                service, workers = self.serve(), [self.far_worker() for _ in range(2)]
                picture = self.far("render", self.scene, "-o", "far.pfm", "--quiet", "--stats",
                                   "stats.json", *LOAD, self.spp)
                done = []
                while picture.poll() is None and len(done) < 8:
                    time.sleep(chance.uniform(0, 0.5))
                    done.append(self.tamper(chance))
                _, err = picture.communicate(timeout=PATIENCE)
                self.assertEqual(0, picture.returncode, f"{err}, after {done}")
                self.assertEqual(expected, (self.folder / "far.pfm").read_bytes(), done)
                self.assertEqual(0, self.stats()["tiles"]["mismatches"])
                self.assertEqual(TILES, self.stats()["tiles"]["done"])
                for worker in workers:
                    self.assertIsNone(worker.poll(), done)
                # Whoever is away when the service ends is told nothing and would wait for it.
                time.sleep(LOST)
                wait_until(lambda: "2 workers" in self.ask("status"), f"all are back, after {done}")
                self.stop(service)
                for worker in workers:
                    self.assertEqual(0, worker.wait(60), done)

    def test_a_bulk_line_that_is_not_there_is_told_and_waited_for(self):
        """As where a firewall has but one of the two ports open."""
        self.relay.refuse = {"bulk"}
        service = self.serve()
        worker = self.start("worker", "--connect", f"tcp://127.0.0.2:{self.port}", "--threads", 1,
                            stderr=self.log_file())
        job = self.submit()
        log = self.folder / "worker.log"
        wait_until(lambda: f":{self.port + 1}, which does not answer" in log.read_text(), "it is told")
        self.assertEqual(0, self.done(job))
        self.relay.refuse = set()
        self.finish(service, [worker], job)

    def test_an_interrupted_upload_leaves_no_job(self):
        service = self.serve()
        self.relay.rate = 50_000
        for command in (["submit", self.scene], ["render", self.scene, "-o", "far.pfm"]):
            for sent in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                with self.subTest(command=command[0], signal=sent.name):
                    before = self.relay.forwarded
                    process = self.far(*command)
                    wait_until(lambda: self.relay.forwarded > before + 20_000, "the scene is on its way")
                    process.send_signal(sent)
                    _, err = process.communicate(timeout=PATIENCE)
                    self.assertEqual(4, process.returncode, err)
                    self.assertIn("interrupted", err)
                    self.assertEqual([], [job for job in json.loads(self.ask("status", "--json"))["jobs"]
                                          if job["state"] != "cancelled"])
        self.assertFalse((self.folder / "far.pfm").exists())
        self.stop(service)

    def test_bulk_that_goes_silent_while_the_scene_comes(self):
        """Its connection stays, and brings nothing more: nobody tells the worker that."""
        service, worker = self.serve(), self.far_worker()
        job = self.submit()
        before = self.relay.forwarded
        wait_until(lambda: self.relay.forwarded > before + (1 << 20), "the scene is on its way")
        self.relay.mute = {"bulk"}
        wait_until(lambda: self.relay.ended_of("bulk"), "the worker has given that connection up")
        self.relay.mute = set()
        self.finish(service, [worker], job)


class Netem(ServiceTest):
    """The same by the kernel: packets are lost, doubled and overtaken, not bytes of a stream."""
    spp = 16

    def ip(self, *arguments):
        return subprocess.run(["ip", *arguments], capture_output=True, text=True, check=False)

    def permitted(self, done, what):
        if done.returncode == 0:
            return
        self.skipTest(f"{what} is not permitted or not there: {done.stderr.strip()}")

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


NAME_SERVER = """
import json, pathlib, socket, struct, sys, threading, time
said = pathlib.Path(sys.argv[2])
family = socket.AF_INET6 if ":" in sys.argv[1] else socket.AF_INET
server = socket.socket(family, socket.SOCK_DGRAM)
server.bind((sys.argv[1], 53))
print("ready", flush=True)
def answer(query, asker, says):
    time.sleep(says.get("after", 0))
    end = query.index(b"\\0", 12) + 5
    kind = struct.unpack("!H", query[end - 4:end - 2])[0]
    found = {1: says.get("A", []), 28: says.get("AAAA", [])}.get(kind, [])
    code = 3 if says.get("unknown") else 0
    reply = query[:2] + struct.pack("!HHHHH", 0x8180 | code, 1, len(found), 0, 0) + query[12:end]
    for address in found:
        data = socket.inet_pton(socket.AF_INET if kind == 1 else socket.AF_INET6, address)
        reply += b"\\xc0\\x0c" + struct.pack("!HHIH", kind, 1, 0, len(data)) + data
    server.sendto(reply, asker)
while True:
    query, asker = server.recvfrom(2048)
    says = json.loads(said.read_text())
    if "silent" not in says:
        threading.Thread(target=answer, args=(query, asker, says), daemon=True).start()
"""


@unittest.skipIf(os.geteuid() != 0 or not shutil.which("nsenter"), "needs root, nsenter and iproute2")
class Names(ServiceTest):
    """The coordinator's host is given by name, in a network of its own with a name server that says
    what the test wants. Asked in vain, the system's resolver waits longer than any test does."""
    spp = 16

    def enter(self, *setup, server="127.0.0.1"):
        """Makes the network: loopback, after `setup` by `ip`, and the name server."""
        resolver = self.write("resolv.conf", f"nameserver {server}\noptions timeout:30 attempts:5\n")
        hosts = self.write("hosts", "127.0.0.1 localhost\n")
        script = (f"mount --bind {resolver} /etc/resolv.conf && mount --bind {hosts} /etc/hosts && "
                  "ip link set lo up && echo ready && exec sleep 3600")
        network = subprocess.Popen(["unshare", "-n", "-m", "sh", "-c", script], text=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(self.end, network)
        if network.stdout.readline() != "ready\n":
            network.kill()
            why = network.communicate()[1].strip()
            self.skipTest(f"a network namespace is not permitted: {why}")
        self.inside = ("nsenter", "-t", str(network.pid), "-n", "-m", "--")
        for command in setup:
            done = subprocess.run([*self.inside, *command.split()], capture_output=True, text=True)
            if done.returncode != 0:
                self.skipTest(f"such a network is not permitted here: {command}: {done.stderr.strip()}")
        self.said = self.folder / "said.json"
        self.say(unknown=True)
        names = subprocess.Popen(
            [*self.inside, "python3", self.write("names.py", NAME_SERVER), server, self.said],
            text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(self.end, names)
        self.assertEqual("ready\n", names.stdout.readline())
        self.port = free_port()
        self.endpoint = f"tcp://farm.test:{self.port}"

    def say(self, **says):
        """What the name server says from now on."""
        half = self.folder / "said.new"
        half.write_text(json.dumps(says))
        half.rename(self.folder / "said.json")

    def start(self, *arguments, **options):
        process = subprocess.Popen(
            [*self.inside, PROGRAM, *map(str, arguments)], cwd=self.folder, env=self.environment(),
            text=True, stdin=subprocess.DEVNULL,
            **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options})
        self.addCleanup(self.end, process)
        return process

    def serve_at(self, host):
        process = self.start("serve", "--bind", f"tcp://{host}:{self.port}", "--store", self.store,
                             "--insecure")
        line = process.stdout.readline()
        self.assertIn("serving at", line, process.stderr.read() if not line else "")
        return process

    def logging_worker(self, *options):
        log = open(self.folder / "worker.log", "a")
        self.addCleanup(log.close)
        return self.start("worker", "--connect", self.endpoint, "--threads", 1, *options, stderr=log)

    def log(self):
        return (self.folder / "worker.log").read_text()

    def renders(self, host):
        """A farm whose coordinator is at that address does a picture, by its name alone."""
        service, worker = self.serve_at(host), self.logging_worker()
        picture = self.run_program("render", self.scene, "-o", "far.pfm", "--quiet", *LOAD, self.spp,
                                   "--connect", self.endpoint)
        self.assertEqual(0, picture.code, picture.err)
        self.stop(service)
        self.assertEqual(0, worker.wait(PATIENCE), self.log())

    def ends(self, process, sent, code):
        process.send_signal(sent)
        self.assertEqual(code, process.wait(PATIENCE), "a name server is waited for")

    def test_a_host_with_ipv4_alone(self):
        self.enter("sysctl -qw net.ipv6.conf.all.disable_ipv6=1")
        self.say(A=["127.0.0.2"])
        self.renders("127.0.0.2")

    def test_a_host_with_ipv6_alone(self):
        self.enter("ip addr add fd77::1/64 dev lo nodad", "ip addr del 127.0.0.1/8 dev lo",
                   server="::1")
        self.say(AAAA=["fd77::1"])
        self.renders("[fd77::1]")

    def test_a_link_local_address_with_its_zone(self):
        self.enter("ip addr add fe80::77/64 dev lo nodad")
        self.endpoint = f"tcp://[fe80::77%lo]:{self.port}"
        self.renders("[fe80::77%lo]")

    def test_a_host_with_both_of_which_one_is_lost(self):
        """What goes to the other one's network is never answered."""
        hole = ("ip link add hole type dummy", "ip link set hole up",
                "ip addr add 192.0.2.1/24 dev hole", "ip addr add fd88::1/64 dev hole nodad")
        self.enter("ip addr add fd77::1/64 dev lo nodad", *hole)
        for host, says in (("[fd77::1]", {"A": ["192.0.2.77"], "AAAA": ["fd77::1"]}),
                           ("127.0.0.2", {"A": ["127.0.0.2"], "AAAA": ["fd88::77"]}),
                           ("127.0.0.2", {"A": ["192.0.2.77", "127.0.0.2"]}),
                           ("*", {"A": ["127.0.0.2"], "AAAA": ["fd77::1"]})):
            with self.subTest(host=host, says=says):
                self.say(**says)
                self.renders(host)

    def test_a_name_of_which_one_address_is_of_this_machine(self):
        """The other is that of a proxy before it, say."""
        self.enter("ip addr add fd77::1/64 dev lo nodad")
        self.say(A=["192.0.2.77"], AAAA=["fd77::1"])
        self.renders("farm.test")
        self.say(A=["192.0.2.77", "127.0.0.2"])
        self.renders("farm.test")

    def test_a_name_server_that_falls_silent(self):
        self.enter()
        self.say(A=["127.0.0.2"])
        service, worker = self.serve_at("127.0.0.2"), self.logging_worker()
        job = self.submit()
        wait_until(lambda: self.status(job)["tiles"]["done"] > 0, "the job runs")
        self.say(silent=True)
        service.kill()
        service.communicate()
        service = self.serve_at("127.0.0.2")
        self.endpoint = f"tcp://127.0.0.2:{self.port}"
        wait_until(lambda: "1 worker" in self.ask("status"), "it is back, by the last address")
        self.assertEqual("done", self.finished(job))
        service.kill()
        service.communicate()
        wait_until(lambda: "no name server answers for the host of" in self.log(), "the cause is told")
        self.ends(worker, signal.SIGTERM, 0)

    def finished(self, job):
        return wait_until(lambda: (state := self.status(job)["state"]) != "running" and state,
                          "the job has ended")

    def test_a_name_server_that_was_never_heard(self):
        self.enter()
        self.say(silent=True)
        worker = self.logging_worker()
        asks = self.run_program("status", "--connect", self.endpoint)
        self.assert_error(asks, 3, "no name server answers for the host of", self.endpoint)
        self.assertIn(f"no name server answers for the host of {self.endpoint}", self.log())
        asker = self.start("status", "--connect", self.endpoint)
        wait_until(lambda: catches(asker, signal.SIGINT), "it heeds Ctrl-C")
        self.ends(asker, signal.SIGINT, 4)
        self.ends(worker, signal.SIGTERM, 0)

    def test_a_name_server_that_is_slow(self):
        self.enter()
        self.say(A=["127.0.0.2"], after=3)
        service = self.serve_at("127.0.0.2")
        self.assertIn("0 workers", self.ask("status"))
        self.stop(service)

    def test_a_name_server_that_is_wrong_and_changes_its_answer(self):
        self.enter()
        asks = self.run_program("status", "--connect", self.endpoint)
        self.assert_error(asks, 2, self.endpoint, "the name of the host is unknown")
        asks = self.run_program("serve", "--bind", self.endpoint, "--insecure")
        self.assert_error(asks, 2, self.endpoint, "the name of the host is unknown")
        service, worker = self.serve_at("127.0.0.2"), self.logging_worker()
        wait_until(lambda: f"the name of the host of {self.endpoint} is unknown" in self.log(), "told")
        self.say(A=["127.0.0.9"])  # where nothing is
        asks = self.run_program("status", "--connect", self.endpoint)
        self.assert_error(asks, 3, f"nothing listens at {self.endpoint}, which is tcp://127.0.0.9")
        self.say(A=["127.0.0.2"])
        wait_until(lambda: "1 worker" in self.ask("status"), "it has found the coordinator")
        self.stop(service)
        self.assertEqual(0, worker.wait(PATIENCE), self.log())

    def test_a_coordinator_that_moves(self):
        self.enter()
        self.say(A=["127.0.0.2"])
        service, worker = self.serve_at("127.0.0.2"), self.logging_worker()
        wait_until(lambda: "1 worker" in self.ask("status"), "it is there")
        service.kill()
        service.communicate()
        self.say(A=["127.0.0.3"])
        service = self.serve_at("127.0.0.3")
        wait_until(lambda: "1 worker" in self.ask("status"), "it has followed")
        self.stop(service)
        self.assertEqual(0, worker.wait(PATIENCE), self.log())

    def test_a_coordinator_bound_to_a_name(self):
        self.enter()
        self.say(A=["127.0.0.2"])
        for name in ("localhost", "farm.test"):
            with self.subTest(name=name):
                self.endpoint = f"tcp://{name}:{self.port}"
                self.renders(name)


# Those of the class that these are made from have their own run.
del ServiceTest

if __name__ == "__main__":
    unittest.main()
