#!/usr/bin/env python3
"""The coordinator service: jobs that outlive clients, workers, and the coordinator itself."""
import contextlib
import json
import os
import pathlib
import random
import re
import signal
import socket
import sqlite3
import subprocess
import time
import unittest
import unittest.mock

import scenes
from tessera_process import SLOWER, TesseraTest, wait_until

LOAD = ["--size", "320x240", "--tile", "16", "--spp"]
TILES = 300


def free_port():
    """A port whose successor, for blobs, is free too. Below those that connections are given, which
    would keep a coordinator that is started anew from it for a minute after their end."""
    while True:
        port = random.SystemRandom().randrange(20000, 32000, 2)
        with socket.socket() as one, socket.socket() as two:
            try:
                one.bind(("127.0.0.1", port))
                two.bind(("127.0.0.1", port + 1))
                return port
            except OSError:
                pass


def threads_at_work(process):
    """How many of its threads run, or want to."""
    states = [stat.read_text().rpartition(")")[2].split()[0]
              for stat in pathlib.Path(f"/proc/{process.pid}/task").glob("*/stat")]
    return states.count("R")


class ServiceTest(TesseraTest):
    spp = 8

    def setUp(self):
        super().setUp()
        self.endpoint = f"tcp://127.0.0.1:{free_port()}"
        self.store = self.folder / "farm"
        self.scene = self.write("scene.tessera", scenes.glass_scene())

    def serve(self, *options):
        """A coordinator that answers."""
        process = self.start("serve", "--bind", self.endpoint, "--store", self.store, *options)
        line = process.stdout.readline()
        self.assertIn("serving at", line, process.stderr.read() if not line else "")
        return process

    def worker(self, *options):
        return self.start("worker", "--connect", self.endpoint, "--threads", 2, "--quiet", *options)

    def ask(self, *command, code=0):
        result = self.run_program(*command, "--connect", self.endpoint)
        self.assertEqual(code, result.code, result.err)
        return result.out

    def submit(self, *options, scene=None):
        return int(self.ask("submit", scene or self.scene, *LOAD, self.spp, *options))

    def status(self, job):
        return json.loads(self.ask("status", job, "--json"))

    def pixels(self, job, *options):
        """What was fetched, as the bytes of a file of floats."""
        self.ask("fetch", job, "--wait", "-o", "fetched.pfm", *options)
        return (self.folder / "fetched.pfm").read_bytes()

    def expected(self, *options):
        self.render(self.scene, "-o", "expected.pfm", "--workers", "0", *LOAD, self.spp, *options)
        return (self.folder / "expected.pfm").read_bytes()

    def stop(self, *processes):
        """What each has told on standard error."""
        for process in processes:
            process.send_signal(signal.SIGTERM)
        return [process.communicate(timeout=60)[1] for process in processes]

    def kept_tiles(self):
        """How many tiles the store of a coordinator that is no more has."""
        with contextlib.closing(sqlite3.connect(self.store / "farm.db")) as database:
            return database.execute("SELECT count(*) FROM tiles").fetchone()[0]


class Kills(ServiceTest):
    def test_no_committed_tile_is_traced_again(self):
        reference = self.expected()
        resumed = 0
        for seed in range(4):
            with self.subTest(seed=seed):
                chance = random.Random(seed)
                self.store = self.folder / f"farm{seed}"
                service, workers = self.serve(), [self.worker(), self.worker()]
                job = self.submit()
                kept = 0
                for _ in range(1 + seed % 3):
                    goal = min(TILES, kept + chance.randrange(1, TILES // 3))
                    wait_until(lambda: self.status(job)["tiles"]["done"] >= goal, f"{goal} tiles are done")
                    service.send_signal(signal.SIGKILL)
                    service.communicate()
                    kept = self.kept_tiles()
                    service = self.serve()
                    if kept < TILES:
                        self.assertEqual(kept, self.status(job)["tiles"]["restored"])
                    resumed += 0 < kept < TILES
                self.assertEqual(reference, self.pixels(job))
                status = self.status(job)
                self.assertEqual(("done", TILES), (status["state"], status["tiles"]["done"]))
                self.assertEqual(TILES, len(self.tiles_of_store(service, workers)))
        self.assertGreaterEqual(resumed, 2)

    def tiles_of_store(self, service, workers):
        self.stop(service, *workers)
        with contextlib.closing(sqlite3.connect(self.store / "farm.db")) as database:
            return database.execute("SELECT x0, y0 FROM tiles").fetchall()

    def test_a_second_coordinator_on_a_store_is_refused(self):
        service = self.serve()
        second = self.run_program("serve", "--bind", f"tcp://127.0.0.1:{free_port()}", "--store", self.store)
        self.assert_error(second, 75, "another process uses it")
        self.assertEqual("0 workers", self.ask("status").splitlines()[-1])
        self.stop(service)

    def test_an_address_that_is_taken_leaves_no_store(self):
        service = self.serve()
        second = self.run_program("serve", "--bind", self.endpoint, "--store", self.folder / "other" / "farm")
        self.assert_error(second, 75, self.endpoint, "Address already in use")
        self.assertFalse((self.folder / "other").exists())
        self.stop(service)


class Told(ServiceTest):
    """What users and logs are told of jobs."""

    def test_what_waits_for_workers_says_so(self):
        service = self.serve()
        job = self.submit()
        table = self.ask("status")
        self.assertRegex(table.splitlines()[1], r"^ +\d+ +running .*\(waits for workers\)$")
        self.assertEqual("0 workers: jobs wait for some", table.splitlines()[-1])
        self.assertRegex(self.ask("status", job), "waits for +workers")
        self.assertEqual(("running", "workers"),
                         tuple(self.status(job)[key] for key in ("state", "waits_for")))
        worker = self.worker()
        self.pixels(job)
        self.assertIsNone(self.status(job)["waits_for"])
        self.stop(service, worker)

    def test_a_job_is_watched_to_its_end(self):
        service = self.serve()
        job = self.submit()
        other = self.submit("--name", "other")
        self.ask("cancel", other)
        self.assertIn("cancelled", self.ask("status", other, "--wait", code=4))
        watcher = self.start("status", job, "--wait", "--json", "--connect", self.endpoint)
        self.assertIn(f"0/{TILES} tiles", watcher.stderr.readline(), "it waits, and shows progress")
        worker = self.worker()
        out, err = watcher.communicate(timeout=60)
        self.assertEqual((0, "done"), (watcher.returncode, json.loads(out)["state"]), err)
        self.assert_error(self.run_program("status", "--wait", "--connect", self.endpoint), 2, "expected a job")
        self.stop(service, worker)

    def test_of_several_of_one_name_it_is_said_which_is_meant(self):
        service = self.serve()
        jobs = [self.submit() for _ in range(3)]
        result = self.run_program("status", "scene", "--json", "--connect", self.endpoint)
        self.assertEqual((0, jobs[2]), (result.code, json.loads(result.out)["job"]))
        self.assertIn(f"job {jobs[2]}, the latest, is meant, not {jobs[0]}, {jobs[1]}", result.err)
        states = [self.status(job)["state"] for job in jobs]
        for order in (["pause"], ["resume"], ["retry"], ["cancel"], ["cancel", "--forget"], ["fetch", "--forget"]):
            self.assert_error(self.run_program(*order, "scene", "--connect", self.endpoint), 2,
                              f"3 jobs have the name 'scene': {jobs[0]}, {jobs[1]}, {jobs[2]}; expected one of")
        self.assertEqual(states, [self.status(job)["state"] for job in jobs])
        for job in jobs[:2]:
            self.ask("cancel", "--forget", job)
        self.assertEqual("", self.run_program("status", "scene", "--connect", self.endpoint).err)
        self.stop(service)

    def test_a_job_may_be_named_like_a_number(self):
        service = self.serve()
        job = self.submit("--name", "2024")
        result = self.run_program("cancel", "2024", "--connect", self.endpoint)
        self.assert_error(result, 2, "'2024' is no job; there is 1 job: 1 2024; did you mean 'name:2024'?")
        self.assertIn(f"job {job} is cancelled", self.ask("cancel", "name:2024"))
        self.stop(service)

    def test_a_job_may_be_named_like_an_option(self):
        service = self.serve()
        self.submit("--name=-o")
        there = ["--connect", self.endpoint, "--", "-o"]
        for command in (["status"], ["pause"], ["cancel", "--forget"]):
            result = self.run_program(*command, *there)
            self.assertEqual(0, result.code, result.err)
        self.assertIn("0 workers", self.ask("status"))
        self.assert_error(self.run_program("cancel", "--", "-o", "--connect", self.endpoint), 2,
                          "'--connect' is one argument too many behind '--'; options go before it")
        self.stop(service)

    def test_the_log_tells_of_jobs_that_go_on_and_how_others_end(self):
        service, worker = self.serve(), self.worker()
        self.spp = 64
        job = self.submit("--name", "long")
        wait_until(lambda: self.status(job)["tiles"]["done"] > 0, "the job runs")
        self.stop(service)
        self.assertEqual(0, worker.wait(30))
        kept = self.kept_tiles()
        service = self.serve()
        self.ask("cancel", job)
        service.send_signal(signal.SIGTERM)
        log = service.communicate(timeout=60)[1]
        self.assertIn("the store has 1 job, of which 1 has not ended", log)
        self.assertIn(f"job {job} (long) goes on: {kept} of {TILES} tiles are kept, {TILES - kept} to do", log)
        self.assertRegex(log, rf"job {job} was cancelled\n")

    def test_workers_that_leave_with_it_are_not_lost(self):
        service, workers = self.serve(), [self.worker() for _ in range(3)]
        job = self.submit()
        wait_until(lambda: self.status(job)["tiles"]["done"] > 0, "the job runs")
        service.send_signal(signal.SIGTERM)
        log = service.communicate(timeout=60)[1]
        self.assertNotIn("lost worker", log)
        for worker in workers:
            self.assertEqual(0, worker.wait(30))


class Ends(ServiceTest):
    def test_told_to_end_it_takes_what_is_traced(self):
        reference = self.expected()
        service, worker = self.serve(), self.worker()
        job = self.submit()
        wait_until(lambda: self.status(job)["tiles"]["done"] > 0, "the job runs")
        service.send_signal(signal.SIGTERM)
        _, log = service.communicate(timeout=30)
        self.assertEqual(0, service.returncode, log)
        self.assertEqual(0, worker.wait(30), "it is told to end")
        kept = self.kept_tiles()
        service, worker = self.serve(), self.worker()
        self.assertEqual(reference, self.pixels(job))
        if kept < TILES:
            self.assertEqual(kept, self.status(job)["tiles"]["restored"])
        self.stop(service, worker)

    def test_a_worker_told_to_end_gives_back_its_tiles(self):
        service, first = self.serve(), self.worker()
        job = self.submit()
        wait_until(lambda: self.status(job)["tiles"]["done"] > 0, "the job runs")
        second = self.worker()
        first.send_signal(signal.SIGTERM)
        self.assertEqual(0, first.wait(30))
        self.assertEqual(self.expected(), self.pixels(job))
        service.send_signal(signal.SIGTERM)
        lost = [line for line in service.communicate(timeout=30)[1].splitlines()
                if "lost worker" in line and f":{first.pid}:" in line]
        self.assertEqual([], lost)
        self.assertEqual(0, second.wait(30))

    def test_a_worker_told_to_end_traces_what_it_has_begun_to_the_end(self):
        """And its queue is another's before that."""
        service, first = self.serve(), self.worker()
        job = int(self.ask("submit", self.scene, "--size", "64x64", "--tile", "16", "--spp", 512))
        wait_until(lambda: threads_at_work(first) >= 2, "both threads trace")
        first.send_signal(signal.SIGTERM)
        second = self.worker()
        self.assertEqual(0, first.wait(60 * SLOWER))
        self.ask("fetch", job, "--wait", "-o", "fetched.pfm")
        self.assertEqual(0, second.poll() or 0)
        status = self.status(job)
        self.assertEqual(("done", 16), (status["state"], status["tiles"]["done"]))
        self.render(self.scene, "-o", "alone.pfm", "--workers", "0", "--size", "64x64", "--spp", 512)
        self.assertEqual((self.folder / "alone.pfm").read_bytes(),
                         (self.folder / "fetched.pfm").read_bytes())
        self.stop(service)
        self.assertEqual(0, second.wait(30))

    def test_an_orphan_comes_back_or_leaves(self):
        service = self.serve()
        patient, hasty = self.worker(), self.worker("--orphan-timeout", 1)
        # Whose coordinator is its parent ends with that alone.
        child = self.worker("--orphan-timeout", .5, "--parent", os.getpid())
        job = self.submit()
        wait_until(lambda: self.status(job)["tiles"]["done"] > 0, "the job runs")
        service.send_signal(signal.SIGKILL)
        service.communicate()
        self.assertEqual(3, hasty.wait(30 * SLOWER))
        service = self.serve()
        self.assertEqual(self.expected(), self.pixels(job))
        self.assertEqual([None, None], [patient.poll(), child.poll()])
        self.stop(service, patient, child)

    def test_an_idle_worker_leaves(self):
        service = self.serve()
        job = self.submit()
        worker = self.worker("--idle-timeout", 2 * SLOWER)
        self.assertEqual(self.expected(), self.pixels(job))
        self.assertEqual(0, worker.wait(30 * SLOWER))
        self.assertEqual("0 workers", self.ask("status").splitlines()[-1])
        self.stop(service)

    def test_the_service_manager_is_told(self):
        """What systemd's Type=notify waits for, by a socket of either kind."""
        for address in (str(self.folder / "notify"), f"\0tessera-test-{self.mark}"):
            with self.subTest(address=address), \
                    socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
                manager.bind(address)
                manager.settimeout(60)
                with unittest.mock.patch.dict(
                        os.environ, NOTIFY_SOCKET=address.replace("\0", "@")):
                    service = self.serve()
                self.assertEqual(b"READY=1", manager.recv(100))
                self.stop(service)
                self.assertEqual(b"STOPPING=1", manager.recv(100))

    def begin_on_a_small_disk(self, size):
        """A store on a disk of its own, a worker and a job that has filled it."""
        self.store.mkdir()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "none", self.store],
                                 capture_output=True, text=True)
        if mounted.returncode != 0:
            self.skipTest(f"no small disk can be mounted here, by root alone: {mounted.stderr}")
        self.addCleanup(subprocess.run, ["umount", "-l", self.store])
        service, worker = self.serve(), self.worker()
        job = self.submit()
        wait_until(lambda: "full" in self.status(job)["failure"], "the disk is full")
        return service, worker, job

    def test_a_full_disk_pauses_the_job_until_there_is_room(self):
        service, worker, job = self.begin_on_a_small_disk("8700k")
        done = self.status(job)["tiles"]["done"]
        time.sleep(0.5)
        self.assertLess(self.status(job)["tiles"]["done"], min(TILES, done + 12))
        subprocess.run(["mount", "-o", "remount,size=40m", self.store], check=True)
        self.assertEqual(self.expected(), self.pixels(job))
        self.stop(service, worker)

    def test_on_a_full_disk_orders_tell_what_they_did_and_a_start_waits_for_room(self):
        service, worker, job = self.begin_on_a_small_disk("8800k")
        result = self.run_program("pause", job, "--connect", self.endpoint)
        self.assertEqual("paused" == self.status(job)["state"], result.code == 0, result.err)
        service.kill()
        service.wait()
        with open(self.store / "rest", "wb", buffering=0) as rest:
            with contextlib.suppress(OSError):
                while rest.write(bytes(4096)) == 4096:
                    pass
        service = self.serve()
        self.assertIn(self.status(job)["state"], ("queued", "running", "paused"))
        result = self.run_program("cancel", job, "--forget", "--connect", self.endpoint)
        self.assertEqual(0, result.code, result.err)
        (self.store / "rest").unlink()
        self.stop(service, worker)

    def test_where_nobody_listens_that_is_said_soon(self):
        commands = [("status",), ("submit", self.scene), ("render", self.scene)]
        for endpoint in (self.endpoint, f"ipc://{self.folder}/none"):
            for command in commands:
                with self.subTest(endpoint=endpoint, command=command[0]):
                    result = self.run_program(*command, "--connect", endpoint)
                    # Who only loses patience says that there is "no connection".
                    self.assert_error(result, 3, f"nothing listens at {endpoint}", "tessera serve")

    def test_who_comes_a_little_later_is_waited_for(self):
        asks = self.start("status", "--connect", self.endpoint)
        time.sleep(0.5)
        service = self.serve()
        out, err = asks.communicate(timeout=30)
        self.assertEqual(0, asks.returncode, err)
        self.assertIn("0 workers", out)
        self.stop(service)

    def test_results_of_a_worker_that_had_to_end_are_handed_in_by_the_next(self):
        cache = self.folder / "cache"
        service, first = self.serve(), self.worker("--cache", cache)
        job = int(self.ask("submit", self.scene, "--size", "64x64", "--tile", "16", "--spp", 384))
        wait_until(lambda: self.status(job)["tiles"]["done"] > 0, "the job runs")
        wait_until(lambda: threads_at_work(first) >= 2, "both threads trace")
        service.send_signal(signal.SIGKILL)
        service.communicate()
        first.send_signal(signal.SIGTERM)
        self.assertEqual(0, first.wait(60 * SLOWER))
        left = list(cache.glob("*.results"))
        self.assertEqual(1, len(left))
        kept = self.kept_tiles()
        service = self.serve()
        second = self.start("worker", "--connect", self.endpoint, "--threads", 2, "--cache", cache)
        wait_until(lambda: not list(cache.glob("*.results")), "they are handed in")
        wait_until(lambda: self.status(job)["tiles"]["done"] > kept, "they are taken")
        self.ask("fetch", job, "--wait", "-o", "fetched.pfm")
        self.render(self.scene, "-o", "alone.pfm", "--workers", "0", "--size", "64x64", "--spp", 384)
        self.assertEqual((self.folder / "alone.pfm").read_bytes(),
                         (self.folder / "fetched.pfm").read_bytes())
        self.stop(service)
        self.assertIn("kept on disk", second.communicate(timeout=60)[1])


class Jobs(ServiceTest):
    def test_from_submission_to_pictures(self):
        service, worker = self.serve(), self.worker()
        first = self.submit()
        self.assertEqual(self.expected(), self.pixels(first))
        second = self.run_program("submit", self.scene, *LOAD, 2, "--priority", 5, "--name", "again",
                                  "--connect", self.endpoint)
        self.assertEqual(f"{first + 1}\n", second.out)
        self.assertIn("sent 0 of 1 blob, 0 bytes", second.err)
        self.ask("fetch", "again", "--wait", "-o", "again.png")
        self.assertTrue((self.folder / "again.png").stat().st_size > 100)
        result = self.run_program("fetch", "agian", "--connect", self.endpoint)
        self.assert_error(result, 2, "'agian' is no job", "did you mean 'again'?")
        self.assert_error(self.run_program("pause", 9, "--connect", self.endpoint), 2,
                          "'9' is no job", "there are 2 jobs: 1 ")
        self.ask("cancel", first, "--forget")
        self.assert_error(self.run_program("status", first, "--connect", self.endpoint), 2, "forgotten")
        # render waits for its job, fetches it, and leaves nothing.
        stats = self.render(self.scene, *LOAD, self.spp, "--connect", self.endpoint)
        self.assertEqual(TILES, stats["tiles"]["done"])
        self.assertEqual([2], [job["job"] for job in json.loads(self.ask("status", "--json"))["jobs"]])
        self.stop(service, worker)

    def test_an_animation(self):
        service, worker = self.serve(), self.worker()
        scene = self.write("moving.tessera", scenes.CAMERA + scenes.SUN + """
            nodes { keys { time: 0 transform { steps { translate { x: 0 } } } }
                    keys { time: 1 transform { steps { translate { x: 1 } } } } shape { sphere { } } }
            """)
        options = ["--size", "64x48", "--frames", "3-6"]
        job = int(self.ask("submit", scene, *options))
        self.ask("fetch", job, "--wait", "-o", "fetched.pfm")
        result = self.run_program("render", scene, *options, "-o", "rendered.pfm", "--workers", 0)
        self.assertEqual(0, result.code, result.err)
        for frame in range(3, 7):
            self.assertEqual((self.folder / f"rendered.{frame:04}.pfm").read_bytes(),
                             (self.folder / f"fetched.{frame:04}.pfm").read_bytes())
        bright = self.run_program("fetch", job, "--exposure", 20, "-o", "bright.png", "--connect", self.endpoint)
        self.assertEqual(1, bright.err.count("brighter than white"), bright.err)
        self.assertIn("warning: frame 3: ", bright.err)
        chosen = self.run_program("fetch", job, "--exposure", "auto", "-o", "chosen.png", "--connect", self.endpoint)
        stops, = re.findall(r"exposure chosen: --exposure (\S+)\n", chosen.err)
        self.ask("fetch", job, "--exposure", stops, "-o", "same.png")
        for frame in range(3, 7):
            self.assertEqual((self.folder / f"same.{frame:04}.png").read_bytes(),
                             (self.folder / f"chosen.{frame:04}.png").read_bytes())
        self.assert_error(self.run_program("submit", scene, "--exposure", "auto", "--connect", self.endpoint), 2,
                          "--exposure auto", "tessera fetch")
        told = self.stop(service, worker)[0]
        for frame in range(3, 7):
            self.assertIn(f"job {job} frame {frame} is done", told)

    def test_pause_resume_and_cancel(self):
        service = self.serve()
        job = self.submit()
        self.assertEqual(f"job {job} is paused\n", self.ask("pause", job))
        worker = self.worker()
        time.sleep(0.5 * SLOWER)
        self.assertEqual(0, self.status(job)["tiles"]["done"])
        self.assert_error(self.run_program("fetch", job, "--connect", self.endpoint), 3, "--wait waits")
        # It stays so over a restart.
        service.send_signal(signal.SIGKILL)
        service.communicate()
        service = self.serve()
        self.assertEqual("paused", self.status(job)["state"])
        self.ask("resume", job, "--priority", "7")
        self.assertEqual(self.expected(), self.pixels(job))
        self.assertEqual(7, self.status(job)["priority"])
        self.assert_error(self.run_program("pause", job, "--connect", self.endpoint), 2, "is done")
        self.spp = 4096
        long = self.submit()
        wait_until(lambda: self.status(long)["tiles"]["done"] > 0, "the job runs")
        self.assertEqual(f"job {long} is cancelled\n", self.ask("cancel", long))
        self.ask("fetch", long, "-o", "part.png", code=4)
        self.assertTrue((self.folder / "part.png").exists())
        self.stop(service, worker)

    def test_a_cancelled_job_leaves_its_workers_idle(self):
        """Its tiles would take many minutes each."""
        service, worker = self.serve(), self.worker()
        job = int(self.ask("submit", self.scene, "--size", "64x48", "--tile", "32", "--spp", 1_000_000))
        wait_until(lambda: threads_at_work(worker) >= 2, "both threads trace")
        self.assertEqual(f"job {job} is cancelled\n", self.ask("cancel", job))
        wait_until(lambda: all(threads_at_work(worker) == 0 for _ in range(5)), "nobody traces")
        self.assertIsNone(worker.poll())
        self.assertEqual(self.expected(), self.pixels(self.submit()))
        self.stop(service, worker)

    def test_a_wrong_scene_fails_its_job_alone(self):
        service, worker = self.serve(), self.worker()
        bad = self.write("bad.tessera", scenes.ONE_SPHERE.replace("sphere {", "sphere { radius: -1"))
        job = self.submit(scene=bad)
        result = self.run_program("fetch", job, "--wait", "--connect", self.endpoint)
        self.assert_error(result, 1, "radius")
        good = self.submit()
        self.assertEqual(self.expected(), self.pixels(good))
        self.assertEqual("failed", self.status(job)["state"])
        self.stop(service, worker)


class StoreFolder(ServiceTest):
    def test_what_is_no_store_is_left_alone(self):
        self.store.mkdir()
        (self.store / "farm.db").write_bytes(b"diary " * 1000)
        result = self.run_program("serve", "--bind", self.endpoint, "--store", self.store)
        self.assert_error(result, 2, "expected a store")
        self.assertEqual(6000, (self.store / "farm.db").stat().st_size)
        pathlib.Path(self.folder / "file").write_text("x")
        result = self.run_program("serve", "--bind", self.endpoint, "--store", self.folder / "file")
        self.assert_error(result, 2, "folder to write to")
