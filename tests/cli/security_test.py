#!/usr/bin/env python3
"""A farm with keys: who is let in, who is not, and that whoever knocks in vain does no harm."""
import contextlib
import os
import pathlib
import re
import resource
import shutil
import signal
import socket
import stat
import subprocess
import unittest

import scenes
from tessera_process import PATIENCE, PROGRAM, TesseraTest, nightly, wait_until

FRAME = ["--size", "320x240", "--tile", "16", "--spp"]
GREETING = (b"\xff" + bytes(7) + b"\x01\x7f\x03\x00" + b"CURVE".ljust(20, b"\0") + bytes(32))
HELLO = b"\x04\xc8\x05HELLO\x01\x00" + b"x" * 192


def resident_bytes(process):
    status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+)", status)[1]) * 1024


class KeyedFarm(TesseraTest):
    def setUp(self):
        super().setUp()
        for name, role in (("farm", "worker"), ("node", "worker"), ("alice", "submitter"),
                           ("wall", "viewer"), ("stranger", "worker")):
            made = self.run_program("keygen", f"{name}.key", "--role", role)
            self.assertEqual(0, made.code, made.err)
        self.allow("node", "alice", "wall")
        self.scene = self.write("scene.tessera", scenes.glass_scene())

    def allow(self, *names):
        self.write("farm.allow", "".join((self.folder / f"{n}.pub").read_text() for n in names))

    def serve(self, *options, bind="tcp://127.0.0.1:*", prefix=()):
        """A coordinator with keys; its log is in serve.log."""
        self.log = open(self.folder / "serve.log", "w")
        self.addCleanup(self.log.close)
        self.coordinator = self.start("serve", "--bind", bind, "--key", "farm.key", "--allow",
                                      "farm.allow", *options, stderr=self.log, prefix=prefix)
        self.endpoint = self.coordinator.stdout.readline().split()[-1]
        return self.coordinator

    def start(self, *arguments, prefix=(), **options):
        if not prefix:
            return super().start(*arguments, **options)
        process = subprocess.Popen(
            [*prefix, PROGRAM, *map(str, arguments)], cwd=self.folder, env=self.environment(),
            text=True, stdin=subprocess.DEVNULL,
            **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options})
        self.addCleanup(self.end, process)
        return process

    def as_(self, name, server="farm.pub"):
        return ["--connect", self.endpoint, "--key", f"{name}.key", "--server-key", server]

    def worker(self, *options):
        return self.start("worker", *options, "--threads", "1")

    def logged(self):
        return (self.folder / "serve.log").read_text()

    def wait_for_log(self, text):
        wait_until(lambda: text in self.logged(), f"'{text}' in the log")

    def render_on_farm(self, *who, spp=16, **options):
        return self.start("render", self.scene, "-o", "picture.png", "--stats", "stats.json",
                          "--quiet", *FRAME, spp, *who, **options)

    def assert_right(self, process, spp=16):
        _, err = process.communicate(timeout=120)
        self.assertEqual(0, process.returncode, err)
        farm = self.stats()
        alone = self.render(self.scene, "--workers", "0", *FRAME, spp)
        self.assertEqual(alone["pixels_sha256"], farm["pixels_sha256"])
        self.assertEqual(0, farm["tiles"]["mismatches"])

    def end_farm(self, *workers):
        self.coordinator.send_signal(signal.SIGTERM)
        self.assertEqual(0, self.coordinator.wait(10))
        for worker in workers:
            self.assertEqual(0, worker.wait(10), worker.stderr.read())

    # ------------------------------------------------------------------------------------- keygen

    def test_keys_are_private_and_never_replaced(self):
        secret, public = self.folder / "node.key", self.folder / "node.pub"
        self.assertEqual(0o600, stat.S_IMODE(secret.stat().st_mode))
        self.assertRegex(public.read_text(), r"^[0-9a-f]{64} worker node\n$")
        self.assertNotIn(re.search(r"secret (\w+)", secret.read_text())[1], public.read_text())
        before = secret.read_text()
        self.assert_error(self.run_program("keygen", "node.key"), 2, "node.key", "is there already")
        public.unlink()
        self.assert_error(self.run_program("keygen", "node.key"), 2, "node.key", "is there already")
        self.write("lone.pub", "")
        self.assert_error(self.run_program("keygen", "lone.key"), 2, "lone.pub", "is there already")
        self.assertFalse((self.folder / "lone.key").exists())
        self.assertEqual(before, secret.read_text())
        self.assertFalse(public.exists())
        made = self.run_program("keygen", ".", "--name", "box-1", "--role", "submitter")
        self.assertEqual((self.folder / "box-1.pub").read_text(), made.out)
        self.assertTrue(made.out.endswith(" submitter box-1\n"))
        own = self.run_program("keygen", "own.key")
        self.assertRegex(own.out, r"^[0-9a-f]{64} coordinator own\n$")
        (self.folder / "own.allow").write_text(own.out)
        self.assert_error(self.run_program("serve", "--bind", "tcp://127.0.0.1:*", "--key", "own.key", "--allow",
                                           "own.allow"), 2, "own.allow:1:66: a coordinator's own key")
        self.assert_error(self.run_program("keygen", "x.key", "--role", "wroker"), 2, "did you mean 'worker'")
        self.assert_error(self.run_program("keygen", "no/x.key"), 2, "no/x.key")

    def test_wrong_options_are_told(self):
        def serve(*options):
            return self.run_program("serve", "--bind", "tcp://127.0.0.1:*", *options)
        keys = ("--key", "farm.key", "--allow", "farm.allow")
        self.assert_error(serve("--key", "farm.key"), 2, "--allow")
        self.assert_error(serve("--allow", "farm.allow"), 2, "--key")
        self.assert_error(serve("--key", "frm.key", "--allow", "farm.allow"), 2, "did you mean 'farm.key'")
        self.assert_error(serve("--key", "farm.pub", "--allow", "farm.allow"), 2, "every user can read it")
        os.chmod(self.folder / "farm.pub", 0o600)
        self.assert_error(serve("--key", "farm.pub", "--allow", "farm.allow"), 2, "farm.pub:1:1")
        self.assert_error(serve(*keys, "--insecure"), 2, "--insecure")
        self.assert_error(self.run_program("serve", "--bind", "tcp://0.0.0.0:*"), 2, "expected keys")
        self.write("farm.allow", "")
        empty = self.start("serve", "--bind", "tcp://127.0.0.1:*", *keys)
        self.assertIn("serving at", empty.stdout.readline())
        empty.send_signal(signal.SIGTERM)
        self.assertIn("'farm.allow' lists no key: nobody is let in", empty.communicate(timeout=60)[1])
        self.write("farm.allow", "\n x worker node\n")
        self.assert_error(serve(*keys), 2, "farm.allow:2:2:")
        self.assert_error(self.run_program("render", self.scene, "--key", "alice.key"), 2, "--connect")
        self.endpoint = "tcp://127.0.0.1:1"
        self.assert_error(self.run_program("worker", *self.as_("node")[:4]), 2, "--server-key")
        self.assert_error(self.run_program("worker", *self.as_("node", "node.key")), 2, "no public key")

    # -------------------------------------------------------------------------------------- roles

    def test_each_key_does_what_it_is_for(self):
        self.serve()
        worker = self.worker(*self.as_("node"))
        digits = (self.folder / "farm.pub").read_text().split()[0]
        self.assert_right(self.render_on_farm(*self.as_("alice", digits)))
        for name in ("node", "wall"):
            process = self.render_on_farm(*self.as_(name))
            _, err = process.communicate(timeout=20)
            self.assertEqual(2, process.returncode, err)
            self.assertIn(f"the key of {name} is a", err)
        for name in ("alice", "wall"):
            refused = self.run_program("worker", *self.as_(name))
            self.assertEqual(2, refused.code)
            self.assertIn(f"the key of {name} is a", refused.err)
        self.end_farm(worker)

    # ------------------------------------------------------------------- test 18 of the farm's list

    def knock(self, count, first=b""):
        """Connections to control and bulk that say no more than that."""
        host, port = self.endpoint.removeprefix("tcp://").rsplit(":", 1)
        ports = self.ports_of(self.coordinator)
        self.assertIn(int(port), ports)
        knockers = []
        for i in range(count):
            knocker = socket.create_connection((host, ports[i % len(ports)]))
            knocker.sendall(first)
            knockers.append(knocker)
            self.addCleanup(knocker.close)
        return knockers

    @staticmethod
    def ports_of(process):
        """Where it listens."""
        inodes = set()
        for descriptor in pathlib.Path(f"/proc/{process.pid}/fd").iterdir():
            with contextlib.suppress(FileNotFoundError):  # closed since it was listed
                inodes.add(os.readlink(descriptor))
        lines = [line.split() for line in pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]]
        return sorted(int(f[1].split(":")[1], 16) for f in lines
                      if f[3] == "0A" and f"socket:[{f[9]}]" in inodes)

    def test_who_has_no_key_does_no_harm(self):
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        if hard < 4096:
            self.skipTest(f"{hard} open files are allowed; expected at least 4096")
        resource.setrlimit(resource.RLIMIT_NOFILE, (4096, hard))
        self.addCleanup(resource.setrlimit, resource.RLIMIT_NOFILE, (soft, hard))
        self.serve()
        worker = self.worker(*self.as_("node"))
        self.wait_for_log("has come, with")
        before = resident_bytes(self.coordinator)
        job = self.render_on_farm(*self.as_("alice"))
        # In turns: nothing, a greeting, a false handshake, another protocol, noise.
        for first in (b"", GREETING, GREETING + HELLO, b"GET / HTTP/1.1\r\n\r\n", os.urandom(5000)):
            self.knock(200, first)
        strangers = [self.worker("--connect", self.endpoint),
                     self.worker(*self.as_("stranger")),
                     self.worker(*self.as_("node", "stranger.pub"))]
        for who in (["--connect", self.endpoint], self.as_("stranger")):
            refused = self.run_program("render", self.scene, *FRAME, 1, *who)
            self.assertEqual(2, refused.code, refused.err)
            self.assertIn("no connection to the coordinator", refused.err)
        self.assert_right(job)
        self.assertLess(resident_bytes(self.coordinator) - before, 100 << 20)
        self.assertNotIn("none of ours", self.logged())  # no frame of theirs came so far
        self.assertEqual(1, self.logged().count("has come, with"), self.logged())
        self.assertIn("let nobody in", self.logged())
        for stranger in strangers:
            self.assertIsNone(stranger.poll())
            stranger.send_signal(signal.SIGTERM)
            stranger.wait(10)
        self.end_farm(worker)

    def test_a_half_open_handshake_is_ended(self):
        self.serve()
        for knocker in self.knock(2) + self.knock(2, GREETING):
            knocker.settimeout(20)
            while knocker.recv(4096):
                pass  # its own greeting; then the end
        self.end_farm()

    def test_a_revoked_worker_is_shut_out_and_the_job_goes_on(self):
        made = self.run_program("keygen", "other.key", "--role", "worker")
        self.assertEqual(0, made.code)
        self.allow("node", "other", "alice")
        self.serve()
        revoked = self.worker(*self.as_("node"), "--orphan-timeout", 10)
        stays = self.worker(*self.as_("other"))
        wait_until(lambda: self.logged().count("has come, with") == 2, "both workers have come")
        job = self.render_on_farm(*self.as_("alice"), spp=24)
        self.wait_for_log("of 320x240 pixels")
        self.allow("other", "alice")
        self.coordinator.send_signal(signal.SIGHUP)
        self.wait_for_log("lost worker")
        self.assertRegex(self.logged(), f":{revoked.pid}: its connection is gone")
        self.assert_right(job, spp=24)
        # A list that is wrong changes nothing.
        self.write("farm.allow", "oops\n")
        self.coordinator.send_signal(signal.SIGHUP)
        self.wait_for_log("the list of keys stays as it was")
        self.assert_right(self.render_on_farm(*self.as_("alice")))
        self.assertEqual(1, self.stats()["workers"]["seen"])
        self.end_farm(stays)
        self.assertEqual(3, revoked.wait(PATIENCE), revoked.stderr.read())

    @nightly
    def test_who_is_listed_again_comes_back_by_itself(self):
        self.serve()
        worker = self.worker(*self.as_("node"))
        self.wait_for_log("has come, with")
        self.allow("alice")
        self.coordinator.send_signal(signal.SIGHUP)
        self.wait_for_log("lost worker")
        self.wait_for_log("let nobody in")
        self.allow("node", "alice")
        self.coordinator.send_signal(signal.SIGHUP)
        self.wait_for_log("is back")
        self.assert_right(self.render_on_farm(*self.as_("alice")))
        self.end_farm(worker)

    def test_a_job_is_submitted_watched_and_fetched_with_keys(self):
        self.serve()
        worker = self.worker(*self.as_("node"))

        def ask(who, *command, code=0):
            result = self.run_program(*command, *self.as_(who))
            self.assertEqual(code, result.code, result.err)
            return result
        job = ask("alice", "submit", self.scene, *FRAME, 16).out.strip()
        ask("alice", "fetch", job, "--wait", "-o", "fetched.pfm")
        self.assertIn("done", ask("wall", "status", job).out, "a viewer may look")
        for command in (["cancel", job], ["submit", self.scene, *FRAME, 16]):
            refused = ask("wall", *command, code=2)
            self.assertIn("viewer", refused.err)
        stranger = self.run_program("status", job, *self.as_("stranger"))
        self.assertNotEqual(0, stranger.code)
        self.assertNotIn("done", stranger.out)
        self.render(self.scene, "-o", "alone.pfm", "--workers", "0", *FRAME, 16)
        self.assertEqual((self.folder / "alone.pfm").read_bytes(),
                         (self.folder / "fetched.pfm").read_bytes())
        self.end_farm(worker)

    # ----------------------------------------------------------------------------------- enrolment

    def make_tokens(self, count, *options):
        """In rack.tokens; they are on the list of keys."""
        made = self.run_program("keygen", "rack.tokens", "--tokens", count, *options)
        self.assertEqual(0, made.code, made.err)
        with open(self.folder / "farm.allow", "a") as allow:
            allow.write(made.out)
        return made.out

    def enrolment(self, key, *options, tokens="rack.tokens"):
        return ["keygen", key, "--enrol", tokens, "--connect", self.endpoint, "--server-key",
                "farm.pub", *options]

    def enrol(self, key, *options, **where):
        return self.run_program(*self.enrolment(key, *options, **where))

    def test_tokens_are_made_as_secret_keys(self):
        lines = self.make_tokens(2, "--for", "90m", "--role", "viewer")
        self.assertRegex(lines, r"^(\w{64} enrol:viewer rack-[12] until=\d{4}-\d\d-\d\dT[\d:]{8}Z\n){2}$")
        tokens = self.folder / "rack.tokens"
        self.assertEqual(0o600, stat.S_IMODE(tokens.stat().st_mode))
        self.assertEqual(2, len(re.findall(r"^secret \w{64}$", tokens.read_text(), re.M)))
        before = tokens.read_text()
        self.assert_error(self.run_program("keygen", "rack.tokens", "--tokens", 1), 2, "is there already")
        self.assertEqual(before, tokens.read_text())
        for wrong, says in ((["--for", "1h"], "--tokens"), (["--tokens", 0], "--tokens"),
                            (["--tokens", 1, "--for", "1y"], "--for: '1y'"),
                            (["--tokens", 1, "--role", "king"], "role 'king'"),
                            (["--tokens", 1, "--enrol", "rack.tokens"], "--tokens"),
                            (["--enrol", "rack.tokens"], "--connect"),
                            (["--connect", "tcp://127.0.0.1:1"], "--enrol")):
            self.assert_error(self.run_program("keygen", "x.key", *wrong), 2, says)
        self.assert_error(self.run_program("serve", "--bind", "tcp://127.0.0.1:*", "--key", "farm.key",
                                           "--allow", "farm.allow"), 2, "--enrolled or --store")
        self.assertEqual([], list(self.folder.glob("x.*")))

    def test_a_machine_enrols_and_works_until_it_is_revoked(self):
        token = self.make_tokens(1).split()[0]
        self.serve("--store", "store")
        made = self.enrol("node7.key", "--name", "node7")
        self.assertEqual(0, made.code, made.err)
        self.assertRegex(made.out, r"^\w{64} worker node7\n$")
        self.assertEqual(made.out, (self.folder / "node7.pub").read_text())
        self.assertEqual(0o600, stat.S_IMODE((self.folder / "node7.key").stat().st_mode))
        self.assertFalse((self.folder / "node7.key.new").exists())
        key = made.out.split()[0]
        self.assertRegex((self.folder / "store/enrolled.allow").read_text(),
                         rf"^{key} worker node7 token={token} since=[\dTZ:-]+\n$")
        self.assertIn(f"enrolled the worker node7, key {key}, by the token rack, from 127.0.0.1",
                      self.logged())
        worker = self.worker(*self.as_("node7"), "--orphan-timeout", 10)
        self.assert_right(self.render_on_farm(*self.as_("alice")))
        before = (self.folder / "node7.key").read_text()
        again = self.enrol("node7.key")
        self.assertEqual(0, again.code, again.err)
        self.assertIn("nothing to enrol", again.err)
        self.assertEqual(before, (self.folder / "node7.key").read_text())
        with open(self.folder / "farm.allow", "a") as allow:
            allow.write(f"{key} revoked node7\n")
        self.coordinator.send_signal(signal.SIGHUP)
        self.wait_for_log("lost worker")
        self.assertEqual(3, worker.wait(PATIENCE), worker.stderr.read())
        self.end_farm()

    def test_tokens_are_of_use_once_for_nothing_else_and_not_for_ever(self):
        self.make_tokens(1)
        self.serve("--store", "store")
        # A token is a secret key: as such it is let in.
        shutil.copy(self.folder / "rack.tokens", self.folder / "token.key")
        for command in (["worker"], ["status"], ["submit", self.scene], ["cancel", "1"],
                        ["fetch", "1"]):
            refused = self.run_program(*command, *self.as_("token"))
            self.assertEqual(2, refused.code, refused.err)
            self.assertIn("the key of rack is an enrolment token", refused.err)
        refused = self.enrol("own.key", tokens="node.key")
        self.assertEqual(2, refused.code, refused.err)
        self.assertIn("the key of node is a worker's; expected an enrolment token", refused.err)
        self.assert_error(self.enrol("a.key", "--name", "alice"), 2, "the name alice is another key's")
        self.assert_error(self.enrol("a.key", "--name", "a b"), 2, "--name")
        self.assertEqual(0, self.enrol("a.key", "--name", "a").code)
        self.assert_error(self.enrol("b.key", "--name", "b"), 2, "of 1 token in 'rack.tokens' none",
                          "the token rack has enrolled a already")
        self.assertFalse((self.folder / "b.key").exists())
        os.rename(self.folder / "rack.tokens", self.folder / "used.tokens")
        unlisted = (self.folder / "farm.allow").read_text()
        lines = self.make_tokens(1)
        self.write("farm.allow", unlisted + re.sub("until=....", "until=2020", lines))
        self.coordinator.send_signal(signal.SIGHUP)
        self.wait_for_log("has been read again")
        self.assert_error(self.enrol("b.key", "--name", "b"), 2, "none is of use",
                          "does not let this key in")
        self.end_farm()

    def test_machines_that_race_for_tokens_get_one_each(self):
        self.make_tokens(3)
        self.serve("--store", "store")
        racers = [self.start(*self.enrolment(f"m{i}.key", "--name", f"m{i}")) for i in range(4)]
        ended = [racer.wait(PATIENCE) for racer in racers]
        self.assertEqual([0, 0, 0, 2], sorted(ended))
        lines = (self.folder / "store/enrolled.allow").read_text().splitlines()
        self.assertEqual(3, len(lines))
        self.assertEqual(3, len({line.split()[3] for line in lines}))
        self.assertEqual({f"m{i}" for i in range(4) if ended[i] == 0},
                         {line.split()[2] for line in lines})
        self.end_farm()

    def test_an_answer_that_was_lost_does_no_harm(self):
        self.make_tokens(1)
        self.serve("--store", "store")
        made = self.enrol("node7.key", "--name", "node7")
        self.assertEqual(0, made.code, made.err)
        # As if the coordinator had been killed after it kept the key and before it answered.
        self.coordinator.kill()
        self.coordinator.wait()
        os.rename(self.folder / "node7.key", self.folder / "again.key.new")
        self.endpoint = "tcp://127.0.0.1:1"
        self.assert_error(self.enrol("again.key", "--name", "node7"), 75, "127.0.0.1:1")
        self.serve("--store", "store")
        again = self.enrol("again.key", "--name", "node7")
        self.assertEqual((0, made.out), (again.code, again.out), again.err)
        self.assertEqual(1, (self.folder / "store/enrolled.allow").read_text().count("\n"))
        worker = self.worker(*self.as_("again"))
        self.assert_right(self.render_on_farm(*self.as_("alice")))
        self.end_farm(worker)

    def test_what_cannot_be_kept_is_not_let_in(self):
        self.make_tokens(1)
        (self.folder / "kept").mkdir()
        self.serve("--enrolled", "kept/enrolled.allow")
        (self.folder / "kept").rmdir()
        self.assert_error(self.enrol("node7.key", "--name", "node7"), 75, "cannot be kept now", "no folder")
        os.rename(self.folder / "node7.key.new", self.folder / "early.key")
        refused = self.run_program("worker", *self.as_("early"), "--orphan-timeout", 1)
        self.assertNotIn("has come, with", self.logged())
        self.assertIn(refused.code, (2, 3), refused.err)
        os.rename(self.folder / "early.key", self.folder / "node7.key.new")
        (self.folder / "kept").mkdir()
        made = self.enrol("node7.key", "--name", "node7")
        self.assertEqual(0, made.code, made.err)
        self.assertEqual(["enrolled.allow"], os.listdir(self.folder / "kept"))
        self.end_farm()

    # ---------------------------------------------------------------------------- over a network

    def test_over_a_network_with_keys_alone(self):
        """Coordinator and worker in network namespaces of their own, joined by a wire."""
        spaces = [f"tessera-{self.mark[:6]}-{side}" for side in "cw"]
        wires = [f"t{self.mark[:6]}{side}" for side in "cw"]

        def ip(*arguments):
            return subprocess.run(["ip", *arguments], capture_output=True, text=True)
        if os.geteuid() != 0 or not shutil.which("ip") or ip("netns", "add", spaces[0]).returncode != 0:
            self.skipTest("network namespaces are not permitted here (they need root)")
        self.addCleanup(ip, "netns", "del", spaces[0])
        self.addCleanup(ip, "netns", "del", spaces[1])
        steps = [["netns", "add", spaces[1]],
                 ["link", "add", wires[0], "type", "veth", "peer", "name", wires[1]]]
        for i in range(2):
            steps += [["link", "set", wires[i], "netns", spaces[i]],
                      ["-n", spaces[i], "addr", "add", f"10.231.77.{i + 1}/24", "dev", wires[i]],
                      ["-n", spaces[i], "link", "set", wires[i], "up"],
                      ["-n", spaces[i], "link", "set", "lo", "up"]]
        for step in steps:
            done = ip(*step)
            if done.returncode != 0:
                self.skipTest(f"a network of its own is not permitted here: ip {' '.join(step)}: {done.stderr}")
        inside = [("ip", "netns", "exec", space) for space in spaces]
        self.serve(bind="tcp://10.231.77.1:7117", prefix=inside[0])
        self.assertEqual("tcp://10.231.77.1:7117", self.endpoint)
        worker = self.start("worker", *self.as_("node"), "--threads", "1", prefix=inside[1])
        stranger = self.start("worker", "--connect", self.endpoint, "--threads", "1", prefix=inside[1])
        self.assert_right(self.render_on_farm(*self.as_("alice"), prefix=inside[1]))
        self.assertEqual(1, self.logged().count("has come, with"))
        stranger.send_signal(signal.SIGTERM)
        stranger.wait(10)
        self.end_farm(worker)


if __name__ == "__main__":
    unittest.main()
